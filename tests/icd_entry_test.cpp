// The loader's interface: negotiation, exported symbols, lookup of commands.
#include <array>
#include <string>

#include "icd_client.h"

namespace pineda::test {
namespace {

TEST(IcdEntry, NegotiatesVersionFive) {
  const auto negotiate = reinterpret_cast<NegotiateFn>(driver_symbol("vk_icdNegotiateLoaderICDInterfaceVersion"));
  ASSERT_NE(negotiate, nullptr);
  uint32_t version = 7;
  EXPECT_EQ(negotiate(&version), VK_SUCCESS);
  EXPECT_EQ(version, 5u);
  version = 4;
  EXPECT_EQ(negotiate(&version), VK_SUCCESS);
  EXPECT_EQ(version, 4u);
  version = 1;
  EXPECT_EQ(negotiate(&version), VK_ERROR_INCOMPATIBLE_DRIVER);
}

TEST(IcdEntry, ExportsOnlyTheLoaderInterface) {
  EXPECT_NE(driver_symbol("vk_icdGetInstanceProcAddr"), nullptr);
  EXPECT_NE(driver_symbol("vk_icdGetPhysicalDeviceProcAddr"), nullptr);
  EXPECT_EQ(driver_symbol("vkCreateInstance"), nullptr);
  EXPECT_EQ(driver_symbol("vkGetInstanceProcAddr"), nullptr);
}

// VK_VERSION_1_0 and 1_1 of the registry: 137 and 28 commands. G global, I instance, P physical device, D device.
struct CoreCommand {
  char level;
  const char* name;
};
constexpr CoreCommand kCoreCommands[] = {
#define G(name) {'G', "vk" #name},
#define I(name) {'I', "vk" #name},
#define P(name) {'P', "vk" #name},
#define D(name) {'D', "vk" #name},
#include "icd_core_commands.inc"
#undef G
#undef I
#undef P
#undef D
};

TEST(IcdEntry, EveryCoreCommandExists) {
  EXPECT_EQ(std::size(kCoreCommands), 137u + 28u);
  Client client;
  ASSERT_EQ(client.result, VK_SUCCESS);
  const auto get_device_proc = VK(client, GetDeviceProcAddr);
  const auto get_physical = reinterpret_cast<GetProcFn>(driver_symbol("vk_icdGetPhysicalDeviceProcAddr"));
  for (const auto& [level, name] : kCoreCommands) {
    EXPECT_NE(driver_proc(client.instance, name), nullptr) << name;
    EXPECT_EQ(driver_proc(nullptr, name) != nullptr, level == 'G' || std::string(name) == "vkGetInstanceProcAddr") << name;
    EXPECT_EQ(get_device_proc(client.device, name) != nullptr, level == 'D') << name;
    EXPECT_EQ(get_physical(client.instance, name) != nullptr, level == 'P') << name;
  }
}

TEST(IcdEntry, ExtensionCommandsNeedTheirExtension) {
  Client plain(nullptr, {}, {}, Enabled::kOnlyAsked);
  ASSERT_EQ(plain.result, VK_SUCCESS);
  EXPECT_EQ(driver_proc(plain.instance, "vkGetPhysicalDeviceProperties2KHR"), nullptr);
  EXPECT_EQ(driver_proc(plain.instance, "vkCreateDebugUtilsMessengerEXT"), nullptr);
  EXPECT_EQ(VK(plain, GetDeviceProcAddr)(plain.device, "vkTrimCommandPoolKHR"), nullptr) << "an extension of the device";
  Client extended(nullptr, {VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME, VK_EXT_DEBUG_UTILS_EXTENSION_NAME}, {},
                  Enabled::kOnlyAsked);
  ASSERT_EQ(extended.result, VK_SUCCESS);
  EXPECT_NE(driver_proc(extended.instance, "vkGetPhysicalDeviceProperties2KHR"), nullptr);
  EXPECT_NE(VK(extended, GetDeviceProcAddr)(extended.device, "vkSetDebugUtilsObjectNameEXT"), nullptr);
  for (const char* unknown : {"vkCreateAccelerationStructureKHR", "vkNothing", ""}) {
    EXPECT_EQ(driver_proc(extended.instance, unknown), nullptr) << unknown;
  }
}

TEST(IcdEntry, RefusesWhatItDoesNotHave) {
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(driver_proc(nullptr, "vkCreateInstance"));
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.apiVersion = VK_MAKE_API_VERSION(1, 1, 1, 0);
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  VkInstance instance;
  EXPECT_EQ(create(&info, nullptr, &instance), VK_ERROR_INCOMPATIBLE_DRIVER) << "a variant is another API";
  EXPECT_EQ(instance, VkInstance(VK_NULL_HANDLE));
  const char* extension = "VK_NOBODY_has_this";
  info.pApplicationInfo = nullptr;
  info.enabledExtensionCount = 1;
  info.ppEnabledExtensionNames = &extension;
  EXPECT_EQ(create(&info, nullptr, &instance), VK_ERROR_EXTENSION_NOT_PRESENT);
}

TEST(IcdEntry, FeaturesThatAreNotAdvertisedCannotBeEnabled) {
  Client client;
  ASSERT_EQ(client.result, VK_SUCCESS);
  VkPhysicalDeviceFeatures have;
  VK(client, GetPhysicalDeviceFeatures)(client.physical, &have);
  EXPECT_EQ(have.robustBufferAccess, VK_TRUE);
  constexpr size_t kCount = sizeof(have) / sizeof(VkBool32);
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
  for (size_t i = 0; i < kCount; ++i) {
    std::array<VkBool32, kCount> bits{}, available{};
    std::memcpy(available.data(), &have, sizeof(have));
    bits[i] = VK_TRUE;
    VkPhysicalDeviceFeatures wanted;
    std::memcpy(&wanted, bits.data(), sizeof(wanted));
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.pEnabledFeatures = &wanted;
    VkDevice device = VK_NULL_HANDLE;
    const VkResult result = VK(client, CreateDevice)(client.physical, &info, nullptr, &device);
    EXPECT_EQ(result, available[i] ? VK_SUCCESS : VK_ERROR_FEATURE_NOT_PRESENT) << "feature " << i;
    if (device) VK(client, DestroyDevice)(device, nullptr);
  }
}

TEST(IcdEntry, EnumerationReportsIncomplete) {
  Client client;
  uint32_t count = 0;
  const auto enumerate = reinterpret_cast<PFN_vkEnumerateInstanceExtensionProperties>(
      driver_proc(nullptr, "vkEnumerateInstanceExtensionProperties"));
  EXPECT_EQ(enumerate(nullptr, &count, nullptr), VK_SUCCESS);
  ASSERT_GE(count, 2u);
  count = 1;
  VkExtensionProperties one;
  EXPECT_EQ(enumerate(nullptr, &count, &one), VK_INCOMPLETE);
  EXPECT_EQ(count, 1u);
}

}  // namespace
}  // namespace pineda::test
