// The registry (vk.xml of Debian's libvulkan-dev) as the judge of what Vulkan 1.0 and 1.1 consist of: no command and no structure
// of a chain is forgotten.
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "icd_client.h"

namespace pineda::test {
namespace {

// The text between <feature ... name="VK_VERSION_1_n"> and </feature>; empty when the registry is not installed.
std::string feature_block(const std::string& name) {
  std::ifstream file("/usr/share/vulkan/registry/vk.xml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const size_t begin = text.find("name=\"" + name + "\" number=");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find("</feature>", begin) - begin);
}

// The names of <command name="..."/> or <type name="..."/> in the block.
std::set<std::string> names(const std::string& block, const std::string& element) {
  const std::string before = "<" + element + " name=\"";
  std::set<std::string> found;
  for (size_t at = block.find(before); at != std::string::npos; at = block.find(before, at + 1)) {
    const size_t begin = at + before.size();
    found.insert(block.substr(begin, block.find('"', begin) - begin));
  }
  return found;
}

TEST(IcdRegistry, EveryCoreCommandIsThere) {
  Client client;
  const std::string version10 = feature_block("VK_VERSION_1_0"), version11 = feature_block("VK_VERSION_1_1");
  ASSERT_FALSE(version10.empty()) << "no vk.xml: libvulkan-dev has it";
  std::set<std::string> commands = names(version10, "command");
  EXPECT_EQ(commands.size(), 137u);
  commands.merge(names(version11, "command"));
  EXPECT_EQ(commands.size(), 165u);
  for (const std::string& name : commands) {
    const bool global = name == "vkCreateInstance" || name.starts_with("vkEnumerateInstance");
    EXPECT_NE(driver_proc(global ? nullptr : client.instance, name.c_str()), nullptr) << name;
  }
  // The list that the entry tests use is the registry's.
  std::set<std::string> listed;
#define G(name) listed.insert("vk" #name);
#define I(name) listed.insert("vk" #name);
#define P(name) listed.insert("vk" #name);
#define D(name) listed.insert("vk" #name);
#include "icd_core_commands.inc"
#undef G
#undef I
#undef P
#undef D
  EXPECT_EQ(listed, commands);
}

// Structures of 1.1 that extend VkPhysicalDeviceFeatures2 or VkPhysicalDeviceProperties2: all ones before, and then not.
struct Answer {
  const char* name;
  VkStructureType type;
  size_t size_bytes;
};
#define ANSWER(name, type) \
  { #name, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##type, sizeof(name) }
constexpr Answer kFeatureAnswers[] = {
    ANSWER(VkPhysicalDevice16BitStorageFeatures, 16BIT_STORAGE_FEATURES),
    ANSWER(VkPhysicalDeviceMultiviewFeatures, MULTIVIEW_FEATURES),
    ANSWER(VkPhysicalDeviceVariablePointersFeatures, VARIABLE_POINTERS_FEATURES),
    ANSWER(VkPhysicalDeviceProtectedMemoryFeatures, PROTECTED_MEMORY_FEATURES),
    ANSWER(VkPhysicalDeviceSamplerYcbcrConversionFeatures, SAMPLER_YCBCR_CONVERSION_FEATURES),
    ANSWER(VkPhysicalDeviceShaderDrawParametersFeatures, SHADER_DRAW_PARAMETERS_FEATURES),
};
constexpr Answer kPropertyAnswers[] = {
    ANSWER(VkPhysicalDeviceIDProperties, ID_PROPERTIES),
    ANSWER(VkPhysicalDeviceSubgroupProperties, SUBGROUP_PROPERTIES),
    ANSWER(VkPhysicalDevicePointClippingProperties, POINT_CLIPPING_PROPERTIES),
    ANSWER(VkPhysicalDeviceMultiviewProperties, MULTIVIEW_PROPERTIES),
    ANSWER(VkPhysicalDeviceProtectedMemoryProperties, PROTECTED_MEMORY_PROPERTIES),
    ANSWER(VkPhysicalDeviceMaintenance3Properties, MAINTENANCE_3_PROPERTIES),
};
#undef ANSWER

bool is_answered(const Answer& answer, void (*ask)(Client&, void*), Client& client) {
  alignas(8) uint8_t bytes[512];
  EXPECT_LE(answer.size_bytes, sizeof(bytes));
  std::memset(bytes, 0xA5, sizeof(bytes));
  const VkBaseOutStructure header{answer.type, nullptr};
  std::memcpy(bytes, &header, sizeof(header));
  ask(client, bytes);
  bool written = false;
  for (size_t i = sizeof(header); i < sizeof(bytes); ++i) {
    if (i < answer.size_bytes) {
      written |= bytes[i] != 0xA5;
    } else {
      EXPECT_EQ(bytes[i], 0xA5) << answer.name << " has no byte " << i;
    }
  }
  return written;
}

void ask_features(Client& client, void* chain) {
  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, chain};
  VK(client, GetPhysicalDeviceFeatures2)(client.physical, &features);
}

void ask_properties(Client& client, void* chain) {
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, chain};
  VK(client, GetPhysicalDeviceProperties2)(client.physical, &properties);
}

TEST(IcdRegistry, EveryChainedAnswerOf11IsGiven) {
  Client client;
  std::set<std::string> tried;
  for (const Answer& answer : kFeatureAnswers) {
    EXPECT_TRUE(is_answered(answer, ask_features, client)) << answer.name;
    tried.insert(answer.name);
  }
  for (const Answer& answer : kPropertyAnswers) {
    EXPECT_TRUE(is_answered(answer, ask_properties, client)) << answer.name;
    tried.insert(answer.name);
  }
  const std::string block = feature_block("VK_VERSION_1_1");
  ASSERT_FALSE(block.empty()) << "no vk.xml: libvulkan-dev has it";
  for (const std::string& name : names(block, "type")) {
    // The 2-structures are the heads of the chains; sparse, external and memory structures belong to other queries, below.
    const bool extends = name.starts_with("VkPhysicalDevice") && (name.ends_with("Features") || name.ends_with("Properties")) &&
                         name != "VkPhysicalDeviceGroupProperties";
    if (extends && name != "VkPhysicalDeviceVariablePointerFeatures" && name != "VkPhysicalDeviceShaderDrawParameterFeatures") {
      EXPECT_TRUE(tried.contains(name)) << name << " is not in this test";
    }
  }
}

// What each structure of 1.1's other chains means to this driver, and where that is looked at. A structure of the registry that
// is missing here fails the test, so each new header makes somebody think.
const std::map<std::string, const char*> kOtherChains = {
    // Device groups of one: masks and indices can only name device 0.
    {"VkMemoryAllocateFlagsInfo", "device masks name the only device"},
    {"VkDeviceGroupRenderPassBeginInfo", "render areas: icd/record_draw.cpp"},
    {"VkDeviceGroupCommandBufferBeginInfo", "device masks name the only device"},
    {"VkDeviceGroupSubmitInfo", "device indices name the only device"},
    {"VkDeviceGroupBindSparseInfo", "no sparse resources"},
    {"VkBindBufferMemoryDeviceGroupInfo", "device indices name the only device"},
    {"VkBindImageMemoryDeviceGroupInfo", "device indices name the only device; no split instances"},
    {"VkDeviceGroupDeviceCreateInfo", "the only device"},
    {"VkMemoryDedicatedRequirements", "answered: IcdVersion11"},
    {"VkMemoryDedicatedAllocateInfo", "any memory serves any resource"},
    {"VkRenderPassInputAttachmentAspectCreateInfo", "icd/render_pass_info.cpp"},
    {"VkImageViewUsageCreateInfo", "views are made for every use"},
    {"VkPipelineTessellationDomainOriginStateCreateInfo", "no tessellation"},
    {"VkRenderPassMultiviewCreateInfo", "icd/render_pass_info.cpp, IcdMultiview"},
    {"VkProtectedSubmitInfo", "no protected memory"},
    {"VkSamplerYcbcrConversionInfo", "icd/sampler.cpp and icd/image_view.cpp, IcdFormat"},
    {"VkBindImagePlaneMemoryInfo", "no disjoint images (VK_FORMAT_FEATURE_DISJOINT_BIT is not set)"},
    {"VkImagePlaneMemoryRequirementsInfo", "no disjoint images"},
    {"VkSamplerYcbcrConversionImageFormatProperties", "answered: icd/physical_device2.cpp"},
    {"VkPhysicalDeviceExternalImageFormatInfo", "nothing is shared: VK_ERROR_FORMAT_NOT_SUPPORTED"},
    {"VkExternalImageFormatProperties", "answered: icd/physical_device2.cpp"},
    {"VkExternalMemoryImageCreateInfo", "no handle type may be asked for"},
    {"VkExternalMemoryBufferCreateInfo", "no handle type may be asked for"},
    {"VkExportMemoryAllocateInfo", "no handle type may be asked for"},
    {"VkExportFenceCreateInfo", "no handle type may be asked for"},
    {"VkExportSemaphoreCreateInfo", "no handle type may be asked for"},
};

TEST(IcdRegistry, EveryOtherChainOf11HasBeenThoughtOf) {
  std::ifstream file("/usr/share/vulkan/registry/vk.xml");
  const std::set<std::string> of11 = names(feature_block("VK_VERSION_1_1"), "type");
  ASSERT_FALSE(of11.empty()) << "no vk.xml: libvulkan-dev has it";
  size_t found = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.find("category=\"struct\"") == std::string::npos || line.find("structextends=\"") == std::string::npos) continue;
    const size_t begin = line.find("name=\"") + 6;
    const std::string name = line.substr(begin, line.find('"', begin) - begin);
    if (!of11.contains(name) || line.find("VkPhysicalDeviceFeatures2") != std::string::npos ||
        line.find("VkPhysicalDeviceProperties2") != std::string::npos) {
      continue;
    }
    EXPECT_TRUE(kOtherChains.contains(name)) << name;
    ++found;
  }
  EXPECT_EQ(found, kOtherChains.size());
}

}  // namespace
}  // namespace pineda::test
