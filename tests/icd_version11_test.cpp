// What Vulkan 1.1 added beside drawing: chains of features and properties, groups of one, descriptor update templates, the second
// versions of commands.
#include <array>

#include "icd_pipeline_client.h"
#include "icd_shaders.h"
#include "icd_shaders_driver.h"

namespace pineda::test {
namespace {

TEST(IcdVersion11, VersionIsTheSameEverywhere) {
  uint32_t instance_version = 0;
  ASSERT_EQ(
      reinterpret_cast<PFN_vkEnumerateInstanceVersion>(driver_proc(nullptr, "vkEnumerateInstanceVersion"))(&instance_version),
      VK_SUCCESS);
  Client client;
  VkPhysicalDeviceProperties properties;
  VK(client, GetPhysicalDeviceProperties)(client.physical, &properties);
  EXPECT_EQ(properties.apiVersion, instance_version);
  EXPECT_GE(VK_API_VERSION_MINOR(properties.apiVersion), 1u);
}

// A structure that is all ones before: features of 1.1 are answered completely, whatever follows a structure stays.
template <typename Struct>
struct Guarded {
  Struct value;
  uint64_t guard = ~0ull;
  explicit Guarded(VkStructureType type) {
    std::memset(&value, 0xFF, sizeof(value));
    value.sType = type;
    value.pNext = nullptr;
  }
};

TEST(IcdVersion11, ChainsAreFilledAndNothingElse) {
  Client client;
  Guarded<VkPhysicalDeviceMultiviewFeatures> multiview(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES);
  Guarded<VkPhysicalDevice16BitStorageFeatures> storage(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_16BIT_STORAGE_FEATURES);
  Guarded<VkPhysicalDeviceMeshShaderFeaturesNV> unknown(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MESH_SHADER_FEATURES_NV);
  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &multiview.value};
  multiview.value.pNext = &unknown.value;
  unknown.value.pNext = &storage.value;
  VK(client, GetPhysicalDeviceFeatures2)(client.physical, &features);
  VkPhysicalDeviceFeatures plain;
  VK(client, GetPhysicalDeviceFeatures)(client.physical, &plain);
  EXPECT_EQ(std::memcmp(&plain, &features.features, sizeof(plain)), 0);
  EXPECT_LE(multiview.value.multiview, 1u);
  EXPECT_LE(multiview.value.multiviewTessellationShader, 1u);
  EXPECT_LE(storage.value.storageInputOutput16, 1u);
  EXPECT_EQ(unknown.value.meshShader, ~0u) << "structures of extensions that the driver lacks are ignored";
  EXPECT_EQ(multiview.guard & storage.guard, ~0ull);

  Guarded<VkPhysicalDeviceSubgroupProperties> subgroup(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES);
  Guarded<VkPhysicalDeviceIDProperties> id(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES);
  Guarded<VkPhysicalDeviceMaintenance3Properties> maintenance3(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES);
  Guarded<VkPhysicalDeviceDriverProperties> driver(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup.value};
  subgroup.value.pNext = &id.value;
  id.value.pNext = &maintenance3.value;
  maintenance3.value.pNext = &driver.value;
  VK(client, GetPhysicalDeviceProperties2)(client.physical, &properties);
  EXPECT_EQ(properties.properties.deviceType, VK_PHYSICAL_DEVICE_TYPE_CPU);
  EXPECT_EQ(subgroup.value.subgroupSize, 16u);
  EXPECT_TRUE(subgroup.value.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT);
  EXPECT_TRUE(subgroup.value.supportedOperations & VK_SUBGROUP_FEATURE_BASIC_BIT);
  EXPECT_EQ(id.value.deviceLUIDValid, VK_FALSE);
  EXPECT_GE(maintenance3.value.maxPerSetDescriptors, 1024u);
  EXPECT_GE(maintenance3.value.maxMemoryAllocationSize, 1ull << 30);
  EXPECT_STREQ(driver.value.driverName, "Pineda");
  EXPECT_EQ(driver.value.conformanceVersion.major, 0u);
  EXPECT_EQ(subgroup.guard & id.guard & maintenance3.guard & driver.guard, ~0ull);
}

// Applications of later headers chain structures that this driver's headers do not name.
TEST(IcdVersion11, StructuresOfUnknownTypesArePassedOver) {
  breaks_on_purpose({"VUID-VkDeviceCreateInfo-pNext-pNext", "VUID-VkPhysicalDeviceProperties2-pNext-pNext"});
  Client client;
  VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  VkBaseOutStructure unknown{};
  const int32_t number = 0x55555555;
  std::memcpy(&unknown.sType, &number, sizeof(number));
  VkPhysicalDeviceMultiviewFeatures multiview{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
  unknown.pNext = reinterpret_cast<VkBaseOutStructure*>(&multiview);
  core.pNext = &unknown;
  VK(client, GetPhysicalDeviceFeatures2)(client.physical, &core);
  EXPECT_EQ(multiview.multiview, VK_TRUE);
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  unknown.pNext = reinterpret_cast<VkBaseOutStructure*>(&subgroup);
  properties.pNext = &unknown;
  VK(client, GetPhysicalDeviceProperties2)(client.physical, &properties);
  EXPECT_NE(subgroup.subgroupSize, 0u);
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
  multiview.multiviewGeometryShader = VK_TRUE;  // not advertised: it is found behind the unknown one
  unknown.pNext = reinterpret_cast<VkBaseOutStructure*>(&multiview);
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &unknown};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  VkDevice device = VK_NULL_HANDLE;
  EXPECT_EQ(VK(client, CreateDevice)(client.physical, &info, nullptr, &device), VK_ERROR_FEATURE_NOT_PRESENT);
  multiview.multiviewGeometryShader = VK_FALSE;
  ASSERT_EQ(VK(client, CreateDevice)(client.physical, &info, nullptr, &device), VK_SUCCESS);
  VK(client, DestroyDevice)(device, nullptr);
}

// Each bit of a chain alone: what is advertised can be enabled, what is not is refused.
template <typename Struct>
void expect_bits_are_honest(Client& client, VkStructureType type, size_t count) {
  Struct have{type};
  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &have};
  VK(client, GetPhysicalDeviceFeatures2)(client.physical, &features);
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
  for (size_t i = 0; i < count; ++i) {
    Struct wanted;
    std::memset(&wanted, 0xFF, sizeof(wanted));  // the padding holds anything
    std::memset(reinterpret_cast<uint8_t*>(&wanted) + 16, 0, count * 4);
    wanted.sType = type;
    wanted.pNext = nullptr;
    const VkBool32 one = VK_TRUE;
    std::memcpy(reinterpret_cast<uint8_t*>(&wanted) + 16 + i * 4, &one, 4);
    VkBool32 available;
    std::memcpy(&available, reinterpret_cast<uint8_t*>(&have) + 16 + i * 4, 4);
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &wanted};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    VkDevice device = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreateDevice)(client.physical, &info, nullptr, &device),
              available ? VK_SUCCESS : VK_ERROR_FEATURE_NOT_PRESENT)
        << "structure " << type << " bit " << i;
    if (device) VK(client, DestroyDevice)(device, nullptr);
  }
}

TEST(IcdVersion11, ChainedFeaturesThatAreNotAdvertisedCannotBeEnabled) {
  breaks_on_purpose({"VUID-VkPhysicalDeviceMultiviewFeatures-multiviewGeometryShader-00580",
                     "VUID-VkPhysicalDeviceMultiviewFeatures-multiviewTessellationShader-00581",
                     "VUID-VkPhysicalDeviceVariablePointersFeatures-variablePointers-01431"});
  Client c;
  expect_bits_are_honest<VkPhysicalDevice16BitStorageFeatures>(c, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_16BIT_STORAGE_FEATURES, 4);
  expect_bits_are_honest<VkPhysicalDeviceMultiviewFeatures>(c, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES, 3);
  expect_bits_are_honest<VkPhysicalDeviceVariablePointersFeatures>(
      c, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VARIABLE_POINTERS_FEATURES, 2);
  expect_bits_are_honest<VkPhysicalDeviceProtectedMemoryFeatures>(c, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROTECTED_MEMORY_FEATURES,
                                                                  1);
  expect_bits_are_honest<VkPhysicalDeviceSamplerYcbcrConversionFeatures>(
      c, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SAMPLER_YCBCR_CONVERSION_FEATURES, 1);
  expect_bits_are_honest<VkPhysicalDeviceShaderDrawParametersFeatures>(
      c, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_DRAW_PARAMETERS_FEATURES, 1);
}

TEST(IcdVersion11, GroupsOfOne) {
  breaks_on_purpose({"VUID-VkDeviceQueueInfo2-flags-06225"});
  Client client;
  uint32_t count = 0;
  EXPECT_EQ(VK(client, EnumeratePhysicalDeviceGroups)(client.instance, &count, nullptr), VK_SUCCESS);
  ASSERT_EQ(count, 1u);
  VkPhysicalDeviceGroupProperties group{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_GROUP_PROPERTIES};
  EXPECT_EQ(VK(client, EnumeratePhysicalDeviceGroups)(client.instance, &count, &group), VK_SUCCESS);
  EXPECT_EQ(group.physicalDeviceCount, 1u);
  EXPECT_EQ(group.physicalDevices[0], client.physical);
  VkQueue queue = VK_NULL_HANDLE;
  VkDeviceQueueInfo2 info{VK_STRUCTURE_TYPE_DEVICE_QUEUE_INFO_2, nullptr, 0, 0, 0};
  VK(client, GetDeviceQueue2)(client.device, &info, &queue);
  EXPECT_EQ(queue, client.queue);
  info.flags = VK_DEVICE_QUEUE_CREATE_PROTECTED_BIT;
  VK(client, GetDeviceQueue2)(client.device, &info, &queue);
  EXPECT_EQ(queue, VkQueue(VK_NULL_HANDLE)) << "no queue was created with that flag";
}

TEST(IcdVersion11, NothingIsShared) {
  Client client;
  const VkPhysicalDeviceExternalBufferInfo buffer{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_BUFFER_INFO, nullptr, 0,
                                                  VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                                  VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT};
  VkExternalBufferProperties buffer_properties{VK_STRUCTURE_TYPE_EXTERNAL_BUFFER_PROPERTIES, nullptr, {~0u, ~0u, ~0u}};
  VK(client, GetPhysicalDeviceExternalBufferProperties)(client.physical, &buffer, &buffer_properties);
  EXPECT_EQ(buffer_properties.externalMemoryProperties.externalMemoryFeatures, 0u);
  const VkPhysicalDeviceExternalSemaphoreInfo semaphore{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_SEMAPHORE_INFO, nullptr,
                                                        VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT};
  VkExternalSemaphoreProperties semaphore_properties{VK_STRUCTURE_TYPE_EXTERNAL_SEMAPHORE_PROPERTIES, nullptr, ~0u, ~0u, ~0u};
  VK(client, GetPhysicalDeviceExternalSemaphoreProperties)(client.physical, &semaphore, &semaphore_properties);
  EXPECT_EQ(semaphore_properties.externalSemaphoreFeatures, 0u);
}

TEST(IcdVersion11, LayoutSupportAgreesWithCreation) {
  breaks_on_purpose({"VUID-VkDescriptorSetLayoutBinding-descriptorType-parameter"});
  Client client;
  for (int type = 0; type <= VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT + 1; ++type) {
    const VkDescriptorSetLayoutBinding binding{0, VkDescriptorType(type), 3, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    const VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0, 1, &binding};
    VkDescriptorSetLayoutSupport support{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_SUPPORT, nullptr, 7};
    VK(client, GetDescriptorSetLayoutSupport)(client.device, &info, &support);
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreateDescriptorSetLayout)(client.device, &info, nullptr, &layout) == VK_SUCCESS, support.supported == 1)
        << type;
    VK(client, DestroyDescriptorSetLayout)(client.device, layout, nullptr);
  }
}

// kScaleCompute with its buffers bound by vkBind*Memory2, written by a template with gaps between the descriptors, and dispatched
// in two parts by vkCmdDispatchBase.
TEST(IcdVersion11, TemplatesAndBasesReachTheShader) {
  PipelineClient client;
  const VkDescriptorSetLayout set_layout =
      client.set_layout({{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
                         {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 4);
  const VkDescriptorSet set = client.descriptor_set(set_layout);
  const auto in = client.buffer(1024);
  VkBufferCreateInfo buffer_info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  buffer_info.size = 1024;
  buffer_info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  VkBuffer out = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateBuffer)(client.device, &buffer_info, nullptr, &out), VK_SUCCESS);
  const VkBufferMemoryRequirementsInfo2 requirements_info{VK_STRUCTURE_TYPE_BUFFER_MEMORY_REQUIREMENTS_INFO_2, nullptr, out};
  VkMemoryDedicatedRequirements dedicated{VK_STRUCTURE_TYPE_MEMORY_DEDICATED_REQUIREMENTS, nullptr, 7, 7};
  VkMemoryRequirements2 requirements{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2, &dedicated};
  VK(client, GetBufferMemoryRequirements2)(client.device, &requirements_info, &requirements);
  EXPECT_EQ(dedicated.requiresDedicatedAllocation, VK_FALSE);
  EXPECT_GE(requirements.memoryRequirements.size, 1024u);
  void* mapped = nullptr;
  const VkBindBufferMemoryInfo bind{VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO, nullptr, out,
                                    client.memory(requirements.memoryRequirements.size, &mapped), 0};
  EXPECT_EQ(VK(client, BindBufferMemory2)(client.device, 1, &bind), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyBuffer)(client.device, out, nullptr); });

  const VkDescriptorUpdateTemplateEntry entry{0, 0, 2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 8, 40};  // goes on in binding 1
  VkDescriptorUpdateTemplateCreateInfo template_info{VK_STRUCTURE_TYPE_DESCRIPTOR_UPDATE_TEMPLATE_CREATE_INFO};
  template_info.descriptorUpdateEntryCount = 1;
  template_info.pDescriptorUpdateEntries = &entry;
  template_info.descriptorSetLayout = set_layout;
  VkDescriptorUpdateTemplate update = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateDescriptorUpdateTemplate)(client.device, &template_info, nullptr, &update), VK_SUCCESS);
  std::array<uint8_t, 80> data;
  data.fill(0xEE);
  const VkDescriptorBufferInfo infos[] = {{in.handle, 0, VK_WHOLE_SIZE}, {out, 0, VK_WHOLE_SIZE}};
  std::memcpy(data.data() + 8, &infos[0], sizeof(infos[0]));
  std::memcpy(data.data() + 48, &infos[1], sizeof(infos[1]));
  VK(client, UpdateDescriptorSetWithTemplate)(client.device, set, update, data.data());
  VK(client, DestroyDescriptorUpdateTemplate)(client.device, update, nullptr);

  for (uint32_t i = 0; i < 256; ++i) in.as<uint32_t>()[i] = i ^ 0x5A5A;
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(
      client.compute_pipeline(layout, client.module(kScaleCompute), nullptr, &pipeline, VK_PIPELINE_CREATE_DISPATCH_BASE_BIT),
      VK_SUCCESS);
  client.run([&](VkCommandBuffer cb) {
    const uint32_t scale = 3;
    VK(client, CmdSetDeviceMask)(cb, 1);
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
    VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 4, &scale);
    VK(client, CmdDispatchBase)(cb, 1, 0, 0, 2, 1, 1);
    VK(client, CmdDispatchBase)(cb, 5, 0, 0, 1, 1, 1);
  });
  for (uint32_t i = 0; i < 256; ++i) {
    const uint32_t group = i / 32;
    const bool ran = group == 1 || group == 2 || group == 5;
    ASSERT_EQ(static_cast<uint32_t*>(mapped)[i], ran ? in.as<uint32_t>()[i] * 3 + i + 5 : 0) << i;
  }
}

// VK_EXT_scalar_block_layout and VK_KHR_uniform_buffer_standard_layout: members at offsets that Vulkan 1.0 forbids.
TEST(IcdVersion11, BlocksMayBeLaidOutTightly) {
  PipelineClient client(nullptr, {},
                        {VK_EXT_SCALAR_BLOCK_LAYOUT_EXTENSION_NAME, VK_KHR_UNIFORM_BUFFER_STANDARD_LAYOUT_EXTENSION_NAME});
  ASSERT_EQ(client.result, VK_SUCCESS);
  const VkDescriptorSetLayout set_layout =
      client.set_layout({{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
                         {1, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 0);
  const VkDescriptorSet set = client.descriptor_set(set_layout);
  const auto storage = client.buffer(128), uniform = client.buffer(64);
  client.write_buffer(set, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, {storage.handle, 0, VK_WHOLE_SIZE});
  client.write_buffer(set, 1, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, {uniform.handle, 0, VK_WHOLE_SIZE});
  for (uint32_t i = 0; i < 13; ++i) storage.as<float>()[i] = float(i);
  for (uint32_t i = 0; i < 4; ++i) uniform.as<float>()[i] = 100.0f * float(i);
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(client.compute_pipeline(layout, client.module(kScalarLayoutCompute), nullptr, &pipeline), VK_SUCCESS);
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
    VK(client, CmdDispatch)(cb, 1, 1, 1);
  });
  for (uint32_t i = 0; i < 4; ++i) EXPECT_EQ(storage.as<float>()[13 + i], 100.0f * float(i) + float(1 + 3 * i + 1)) << i;
}

// What a process has allocated is the heap's usage.
TEST(IcdVersion11, MemoryBudgetFollowsAllocations) {
  Client client;
  const auto usage = [&] {
    VkPhysicalDeviceMemoryBudgetPropertiesEXT budget{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT};
    VkPhysicalDeviceMemoryProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2, &budget};
    VK(client, GetPhysicalDeviceMemoryProperties2)(client.physical, &properties);
    EXPECT_GT(budget.heapBudget[0], budget.heapUsage[0]);
    EXPECT_LE(budget.heapBudget[0], properties.memoryProperties.memoryHeaps[0].size);
    EXPECT_EQ(budget.heapBudget[1], 0u);
    return budget.heapUsage[0];
  };
  const VkDeviceSize before = usage();
  const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, 5u << 20, 0};
  VkDeviceMemory memory = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, AllocateMemory)(client.device, &info, nullptr, &memory), VK_SUCCESS);
  EXPECT_EQ(usage(), before + (5u << 20));
  VK(client, FreeMemory)(client.device, memory, nullptr);
  EXPECT_EQ(usage(), before);
}

}  // namespace
}  // namespace pineda::test
