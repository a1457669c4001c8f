// Memory: lazily allocated, sub-allocated, aliased.
#include <random>

#include "icd_pipeline_client.h"
#include "icd_shaders.h"

namespace pineda::test {
namespace {

uint32_t lazy_type(Client& client) {
  VkPhysicalDeviceMemoryProperties memory;
  VK(client, GetPhysicalDeviceMemoryProperties)(client.physical, &memory);
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    if (memory.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT) return i;
  }
  return ~0u;
}

VkDeviceMemory allocate(Client& client, VkDeviceSize size_bytes, uint32_t type) {
  const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, size_bytes, type};
  VkDeviceMemory out = VK_NULL_HANDLE;
  EXPECT_EQ(VK(client, AllocateMemory)(client.device, &info, nullptr, &out), VK_SUCCESS);
  client.defer([&client, out] { VK(client, FreeMemory)(client.device, out, nullptr); });
  return out;
}

VkImage unbound_image(Client& client, VkFormat format, VkExtent3D extent, VkImageUsageFlags usage, VkImageCreateFlags flags = 0,
                      VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT) {
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.flags = flags;
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = extent;
  info.mipLevels = info.arrayLayers = 1;
  info.samples = samples;
  info.usage = usage;
  VkImage out = VK_NULL_HANDLE;
  EXPECT_EQ(VK(client, CreateImage)(client.device, &info, nullptr, &out), VK_SUCCESS);
  client.defer([&client, out] { VK(client, DestroyImage)(client.device, out, nullptr); });
  return out;
}

VkMemoryRequirements requirements_of(Client& client, VkImage image) {
  VkMemoryRequirements out;
  VK(client, GetImageMemoryRequirements)(client.device, image, &out);
  return out;
}

VkDeviceSize commitment(Client& client, VkDeviceMemory memory) {
  VkDeviceSize out = ~VkDeviceSize{0};
  VK(client, GetDeviceMemoryCommitment)(client.device, memory, &out);
  return out;
}

TEST(IcdMemory, LazyMemoryIsForTransientAttachmentsOnly) {
  Client client;
  const uint32_t lazy = lazy_type(client);
  ASSERT_NE(lazy, ~0u);
  constexpr VkExtent3D kExtent{64, 64, 1};
  const VkImage ordinary = unbound_image(client, VK_FORMAT_R8G8B8A8_UNORM, kExtent, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  const VkImage transient = unbound_image(client, VK_FORMAT_R8G8B8A8_UNORM, kExtent,
                                          VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT);
  EXPECT_EQ(requirements_of(client, ordinary).memoryTypeBits >> lazy & 1, 0u);
  EXPECT_EQ(requirements_of(client, transient).memoryTypeBits >> lazy & 1, 1u);
  EXPECT_NE(requirements_of(client, transient).memoryTypeBits & ~(1u << lazy), 0u) << "ordinary memory serves too";
  const VkBuffer buffer = client.buffer(64).handle;
  VkMemoryRequirements requirements;
  VK(client, GetBufferMemoryRequirements)(client.device, buffer, &requirements);
  EXPECT_EQ(requirements.memoryTypeBits >> lazy & 1, 0u);
}

// A 4-sample colour and a depth attachment whose contents nobody keeps: the picture is right, the memory is committed only as far
// as something was written, and never beyond its size.
TEST(IcdMemory, TransientAttachmentsAreDrawnToInLazyMemory) {
  breaks_on_purpose({"VUID-vkMapMemory-memory-00682"});
  PipelineClient client;
  const uint32_t lazy = lazy_type(client);
  ASSERT_NE(lazy, ~0u);
  constexpr VkExtent3D kExtent{512, 512, 1};
  constexpr VkDeviceSize kPage = 4096;
  const VkImage transient =
      unbound_image(client, VK_FORMAT_R8G8B8A8_UNORM, kExtent,
                    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT, 0, VK_SAMPLE_COUNT_4_BIT);
  const VkDeviceSize size_bytes = requirements_of(client, transient).size;
  const VkDeviceMemory memory = allocate(client, size_bytes, lazy);
  EXPECT_EQ(commitment(client, memory), 0u) << "nothing has needed it yet";
  void* mapped = nullptr;
  EXPECT_EQ(VK(client, MapMemory)(client.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), VK_ERROR_MEMORY_MAP_FAILED);
  ASSERT_EQ(VK(client, BindImageMemory)(client.device, transient, memory, 0), VK_SUCCESS);
  const VkImage resolved = client.image(VK_FORMAT_R8G8B8A8_UNORM, kExtent, 1, 1, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);

  VkAttachmentDescription attachments[2]{};
  attachments[0].format = attachments[1].format = VK_FORMAT_R8G8B8A8_UNORM;
  attachments[0].samples = VK_SAMPLE_COUNT_4_BIT;
  attachments[0].loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
  attachments[0].storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  attachments[0].finalLayout = attachments[1].finalLayout = VK_IMAGE_LAYOUT_GENERAL;
  attachments[1].samples = VK_SAMPLE_COUNT_1_BIT;
  attachments[1].loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  attachments[1].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  for (auto& attachment : attachments) {
    attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachment.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  }
  const VkAttachmentReference references[] = {{0, VK_IMAGE_LAYOUT_GENERAL}, {1, VK_IMAGE_LAYOUT_GENERAL}};
  VkSubpassDescription subpass{};
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &references[0];
  subpass.pResolveAttachments = &references[1];
  VkRenderPassCreateInfo pass_info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  pass_info.attachmentCount = 2;
  pass_info.pAttachments = attachments;
  pass_info.subpassCount = 1;
  pass_info.pSubpasses = &subpass;
  const std::vector<VkSubpassDependency> dependencies = dependencies_of(1);
  pass_info.dependencyCount = static_cast<uint32_t>(dependencies.size());
  pass_info.pDependencies = dependencies.data();
  VkRenderPass pass = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateRenderPass)(client.device, &pass_info, nullptr, &pass), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyRenderPass)(client.device, pass, nullptr); });
  VkImageView views[2];
  for (int i = 0; i < 2; ++i) {
    VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = i ? resolved : transient;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = VK_FORMAT_R8G8B8A8_UNORM;
    info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    ASSERT_EQ(VK(client, CreateImageView)(client.device, &info, nullptr, &views[i]), VK_SUCCESS);
    client.defer([&client, view = views[i]] { VK(client, DestroyImageView)(client.device, view, nullptr); });
  }
  const VkFramebufferCreateInfo framebuffer_info{
      VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO, nullptr, 0, pass, 2, views, 512, 512, 1};
  VkFramebuffer framebuffer = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateFramebuffer)(client.device, &framebuffer_info, nullptr, &framebuffer), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyFramebuffer)(client.device, framebuffer, nullptr); });
  const auto read = client.buffer(512 * 512 * 4);
  client.run([&](VkCommandBuffer cb) {
    VkClearValue clear{};
    clear.color = {{1, 0, 0.2f, 1}};
    const VkRenderPassBeginInfo begin{
        VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO, nullptr, pass, framebuffer, {{0, 0}, {512, 512}}, 1, &clear};
    VK(client, CmdBeginRenderPass)(cb, &begin, VK_SUBPASS_CONTENTS_INLINE);
    VkClearAttachment patch{VK_IMAGE_ASPECT_COLOR_BIT, 0, {}};
    patch.clearValue.color = {{0, 1, 0, 1}};
    const VkClearRect rect{{{100, 100}, {200, 200}}, 0, 1};
    VK(client, CmdClearAttachments)(cb, 1, &patch, 1, &rect);
    VK(client, CmdEndRenderPass)(cb);
    const VkBufferImageCopy copy{0, 0, 0, color_layers(), {}, kExtent};
    VK(client, CmdCopyImageToBuffer)(cb, resolved, VK_IMAGE_LAYOUT_GENERAL, read.handle, 1, &copy);
  });
  EXPECT_EQ(read.as<uint32_t>()[0], 0xFF3300FFu);
  EXPECT_EQ(read.as<uint32_t>()[150 * 512 + 150], 0xFF00FF00u);
  const VkDeviceSize committed = commitment(client, memory);
  EXPECT_LE(committed, size_bytes);
  EXPECT_EQ(committed % kPage, 0u);
  RecordProperty("committed_bytes", int(committed));
  printf("committed %llu of %llu bytes\n", (unsigned long long)committed, (unsigned long long)size_bytes);
}

// Many buffers and images in one allocation, at random places that the requirements allow: none disturbs another.
TEST(IcdMemory, ManyResourcesShareAnAllocation) {
  Client client;
  constexpr uint32_t kCount = 40, kSeed = 6;
  std::mt19937 random(kSeed);
  struct Resource {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkImage image = VK_NULL_HANDLE;
    uint32_t width = 0;
    VkDeviceSize offset = 0;
  };
  std::vector<Resource> resources(kCount);
  VkDeviceSize end = 0;
  for (Resource& resource : resources) {
    VkMemoryRequirements requirements;
    resource.width = 1 + random() % 40;
    if (random() % 2) {
      VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
      info.size = resource.width * 4;
      info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
      ASSERT_EQ(VK(client, CreateBuffer)(client.device, &info, nullptr, &resource.buffer), VK_SUCCESS);
      client.defer([&client, handle = resource.buffer] { VK(client, DestroyBuffer)(client.device, handle, nullptr); });
      VK(client, GetBufferMemoryRequirements)(client.device, resource.buffer, &requirements);
    } else {
      resource.image = unbound_image(client, VK_FORMAT_R32_UINT, {resource.width, 3, 1},
                                     VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
      requirements = requirements_of(client, resource.image);
    }
    end = (end + requirements.alignment - 1) / requirements.alignment * requirements.alignment;
    resource.offset = end + requirements.alignment * (random() % 3);
    end = resource.offset + requirements.size;
  }
  const VkDeviceMemory memory = client.memory(end);
  const auto read = client.buffer(kCount * 40 * 3 * 4);
  client.run([&](VkCommandBuffer cb) {
    for (uint32_t i = 0; i < kCount; ++i) {
      const Resource& resource = resources[i];
      if (resource.buffer) {
        ASSERT_EQ(VK(client, BindBufferMemory)(client.device, resource.buffer, memory, resource.offset), VK_SUCCESS);
        VK(client, CmdFillBuffer)(cb, resource.buffer, 0, VK_WHOLE_SIZE, 1000 + i);
      } else {
        ASSERT_EQ(VK(client, BindImageMemory)(client.device, resource.image, memory, resource.offset), VK_SUCCESS);
        client.to_general(resource.image, VK_FORMAT_R32_UINT);
        VkClearColorValue color{};
        color.uint32[0] = 1000 + i;
        const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        VK(client, CmdClearColorImage)(cb, resource.image, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
      }
    }
    client.barrier(cb);
    for (uint32_t i = 0; i < kCount; ++i) {
      const Resource& resource = resources[i];
      if (resource.buffer) {
        const VkBufferCopy copy{0, i * 480, resource.width * 4};
        VK(client, CmdCopyBuffer)(cb, resource.buffer, read.handle, 1, &copy);
      } else {
        const VkBufferImageCopy copy{i * 480, 0, 0, color_layers(), {}, {resource.width, 3, 1}};
        VK(client, CmdCopyImageToBuffer)(cb, resource.image, VK_IMAGE_LAYOUT_GENERAL, read.handle, 1, &copy);
      }
    }
  });
  for (uint32_t i = 0; i < kCount; ++i) {
    const uint32_t words = resources[i].width * (resources[i].buffer ? 1 : 3);
    for (uint32_t w = 0; w < words; ++w) ASSERT_EQ(read.as<uint32_t>()[i * 120 + w], 1000 + i) << "word " << w;
  }
}

// "Memory Aliasing": two buffers see the same bytes; two images with VK_IMAGE_CREATE_ALIAS_BIT and equal parameters interpret
// them consistently; a linear image and a buffer too.
TEST(IcdMemory, AliasesSeeTheSameBytes) {
  Client client;
  void* mapped = nullptr;
  const VkDeviceMemory memory = client.memory(65536, &mapped);
  constexpr VkImageUsageFlags kUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  VkImage images[2];
  for (VkImage& image : images) {
    image = unbound_image(client, VK_FORMAT_R8G8B8A8_UNORM, {64, 64, 1}, kUsage, VK_IMAGE_CREATE_ALIAS_BIT);
    ASSERT_EQ(VK(client, BindImageMemory)(client.device, image, memory, 4096), VK_SUCCESS);
    client.to_general(image, VK_FORMAT_R8G8B8A8_UNORM);
  }
  VkBuffer buffers[2];
  for (VkBuffer& buffer : buffers) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = 32768;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    ASSERT_EQ(VK(client, CreateBuffer)(client.device, &info, nullptr, &buffer), VK_SUCCESS);
    client.defer([&client, buffer] { VK(client, DestroyBuffer)(client.device, buffer, nullptr); });
    ASSERT_EQ(VK(client, BindBufferMemory)(client.device, buffer, memory, 32768), VK_SUCCESS);
  }
  const auto read = client.buffer(64 * 64 * 4);
  client.run([&](VkCommandBuffer cb) {
    const VkClearColorValue color{{0, 1, 1, 0}};
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VK(client, CmdClearColorImage)(cb, images[0], VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
    client.barrier(cb);
    const VkBufferImageCopy copy{0, 0, 0, color_layers(), {}, {64, 64, 1}};
    VK(client, CmdCopyImageToBuffer)(cb, images[1], VK_IMAGE_LAYOUT_GENERAL, read.handle, 1, &copy);
    VK(client, CmdFillBuffer)(cb, buffers[0], 0, 16384, 0xABCD1234);
    client.barrier(cb);
    const VkBufferCopy move{0, 16384, 16384};
    VK(client, CmdCopyBuffer)(cb, buffers[1], buffers[0], 1, &move);
  });
  EXPECT_EQ(read.as<uint32_t>()[64 * 63 + 63], 0x00FFFF00u);
  const auto* words = static_cast<const uint32_t*>(mapped) + 32768 / 4;
  EXPECT_EQ(words[0], 0xABCD1234u);
  EXPECT_EQ(words[8191], 0xABCD1234u);
}

}  // namespace
}  // namespace pineda::test
