// VkAllocationCallbacks: whatever allocation fails, the command says VK_ERROR_OUT_OF_HOST_MEMORY, nothing leaks, nothing crashes.
#include <cstdlib>
#include <map>
#include <mutex>

#include "icd_client.h"
#include "icd_shaders.h"

namespace pineda::test {
namespace {

// Counts live allocations and fails one of them on demand.
class CountingAllocator {
 public:
  CountingAllocator() : callbacks{this, allocate, reallocate, release, nullptr, nullptr} {}

  VkAllocationCallbacks callbacks;
  int64_t fail_at = -1;  // index of the allocation that fails; -1: none
  int64_t allocations = 0;
  std::map<void*, size_t> live;
  int64_t bad_releases = 0;

 private:
  std::mutex mutex_;

  static void* allocate(void* self, size_t size_bytes, size_t alignment, VkSystemAllocationScope) {
    auto& counter = *static_cast<CountingAllocator*>(self);
    const std::scoped_lock lock(counter.mutex_);
    if (counter.allocations++ == counter.fail_at) return nullptr;
    void* memory = std::aligned_alloc(alignment, (size_bytes + alignment - 1) / alignment * alignment);
    if (memory) counter.live[memory] = size_bytes;
    return memory;
  }
  static void* reallocate(void*, void*, size_t, size_t, VkSystemAllocationScope) { return nullptr; }
  static void release(void* self, void* memory) {
    auto& counter = *static_cast<CountingAllocator*>(self);
    const std::scoped_lock lock(counter.mutex_);
    if (!memory) return;
    if (counter.live.erase(memory) == 0) ++counter.bad_releases;
    std::free(memory);
  }
};

// Creates one of everything with the callbacks and destroys it. Stops at the first failure, as an application would.
class Scenario {
 public:
  explicit Scenario(const VkAllocationCallbacks* callbacks)
      : c_(callbacks, {VK_EXT_DEBUG_UTILS_EXTENSION_NAME}), callbacks_(callbacks) {}

  VkResult run() {
    if (c_.result != VK_SUCCESS) return c_.result;
    for (const auto step : {&Scenario::sync, &Scenario::resources, &Scenario::views, &Scenario::descriptors, &Scenario::passes,
                            &Scenario::shaders, &Scenario::commands}) {
      if (const VkResult result = (this->*step)(); result != VK_SUCCESS) return result;
    }
    return VK_SUCCESS;
  }

 private:
  template <typename Info, typename Handle, typename Create, typename Destroy>
  VkResult make(Create create, Destroy destroy, const Info& info, Handle* out) {
    const VkResult result = create(c_.device, &info, callbacks_, out);
    if (result == VK_SUCCESS) {
      c_.defer([this, destroy, handle = *out] { destroy(c_.device, handle, callbacks_); });
    } else {
      EXPECT_EQ(*out, Handle(VK_NULL_HANDLE));
    }
    return result;
  }
#define MAKE(name, info, out)                                                           \
  do {                                                                                  \
    const VkResult made = make(VK(c_, Create##name), VK(c_, Destroy##name), info, out); \
    if (made != VK_SUCCESS) return made;                                                \
  } while (false)

  VkResult sync() {
    VkFence fence;
    VkSemaphore semaphore;
    VkEvent event;
    VkQueryPool queries;
    MAKE(Fence, VkFenceCreateInfo{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO}, &fence);
    MAKE(Semaphore, VkSemaphoreCreateInfo{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO}, &semaphore);
    MAKE(Event, VkEventCreateInfo{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO}, &event);
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 100;
    MAKE(QueryPool, info, &queries);
    return VK_SUCCESS;
  }

  VkResult resources() {
    VkBufferCreateInfo buffer{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    buffer.size = 4096;
    buffer.usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
    MAKE(Buffer, buffer, &buffer_);
    VkImageCreateInfo image{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    image.imageType = VK_IMAGE_TYPE_2D;
    image.format = VK_FORMAT_R8G8B8A8_UNORM;
    image.extent = {16, 16, 1};
    image.mipLevels = image.arrayLayers = 1;
    image.samples = VK_SAMPLE_COUNT_1_BIT;
    image.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    MAKE(Image, image, &image_);
    const VkMemoryAllocateInfo memory_info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, 8192, 0};
    VkDeviceMemory memory;
    const VkResult result = VK(c_, AllocateMemory)(c_.device, &memory_info, callbacks_, &memory);
    if (result != VK_SUCCESS) return result;
    c_.defer([this, memory] { VK(c_, FreeMemory)(c_.device, memory, callbacks_); });
    EXPECT_EQ(VK(c_, BindBufferMemory)(c_.device, buffer_, memory, 0), VK_SUCCESS);
    return VK(c_, BindImageMemory)(c_.device, image_, memory, 4096);
  }

  VkResult views() {
    VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = image_;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = VK_FORMAT_R8G8B8A8_UNORM;
    info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    MAKE(ImageView, info, &view_);
    MAKE(Sampler, VkSamplerCreateInfo{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO}, &sampler_);
    return VK_SUCCESS;
  }

  VkResult descriptors() {
    const VkDescriptorSetLayoutBinding bindings[] = {
        {1, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2, VK_SHADER_STAGE_ALL, nullptr},
        {0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_ALL, &sampler_}};
    VkDescriptorSetLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    layout_info.bindingCount = 2;
    layout_info.pBindings = bindings;
    VkDescriptorSetLayout layout;
    MAKE(DescriptorSetLayout, layout_info, &layout);
    VkPipelineLayoutCreateInfo pipeline_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    pipeline_info.setLayoutCount = 1;
    pipeline_info.pSetLayouts = &layout;
    VkPipelineLayout pipeline_layout;
    MAKE(PipelineLayout, pipeline_info, &pipeline_layout);
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 8}, {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 4}};
    const VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 4, 2, sizes};
    VkDescriptorPool pool;
    MAKE(DescriptorPool, pool_info, &pool);
    const VkDescriptorSetLayout layouts[] = {layout, layout, layout};
    const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool, 3, layouts};
    VkDescriptorSet sets[3];
    return VK(c_, AllocateDescriptorSets)(c_.device, &allocate, sets);
  }

  VkResult passes() {
    const VkAttachmentDescription attachment{0,
                                             VK_FORMAT_R8G8B8A8_UNORM,
                                             VK_SAMPLE_COUNT_1_BIT,
                                             VK_ATTACHMENT_LOAD_OP_CLEAR,
                                             VK_ATTACHMENT_STORE_OP_STORE,
                                             VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                             VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                             VK_IMAGE_LAYOUT_UNDEFINED,
                                             VK_IMAGE_LAYOUT_GENERAL};
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_GENERAL};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = info.subpassCount = 1;
    info.pAttachments = &attachment;
    info.pSubpasses = &subpass;
    VkRenderPass render_pass;
    MAKE(RenderPass, info, &render_pass);
    const VkFramebufferCreateInfo framebuffer_info{
        VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO, nullptr, 0, render_pass, 1, &view_, 16, 16, 1};
    VkFramebuffer framebuffer;
    MAKE(Framebuffer, framebuffer_info, &framebuffer);
    return VK_SUCCESS;
  }

  VkResult shaders() {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = sizeof(kColorVertex);
    info.pCode = kColorVertex;
    VkShaderModule module;
    MAKE(ShaderModule, info, &module);
    VkPipelineCache cache;
    MAKE(PipelineCache, VkPipelineCacheCreateInfo{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO}, &cache);
    return VK_SUCCESS;
  }

  // Enough commands for several arena blocks; the failure shows at vkEndCommandBuffer.
  VkResult commands() {
    const VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, c_.pool,
                                           VK_COMMAND_BUFFER_LEVEL_PRIMARY, 2};
    VkCommandBuffer command_buffers[2];
    VkResult result = VK(c_, AllocateCommandBuffers)(c_.device, &info, command_buffers);
    if (result != VK_SUCCESS) return result;
    const VkCommandBuffer cb = command_buffers[0];
    c_.begin(cb);
    const std::vector<uint32_t> data(4096 / 4, 3);
    for (int i = 0; i < 40; ++i) VK(c_, CmdUpdateBuffer)(cb, buffer_, 0, 4096, data.data());
    result = VK(c_, EndCommandBuffer)(cb);
    if (result != VK_SUCCESS) return result;
    return c_.submit(cb);
  }

  Client c_;
  const VkAllocationCallbacks* callbacks_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkImage image_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
  VkSampler sampler_ = VK_NULL_HANDLE;
};

TEST(IcdAllocation, EverythingIsReleasedThroughTheCallbacks) {
  CountingAllocator allocator;
  EXPECT_EQ(Scenario(&allocator.callbacks).run(), VK_SUCCESS);
  EXPECT_GT(allocator.allocations, 20);
  EXPECT_TRUE(allocator.live.empty()) << allocator.live.size() << " allocations leak";
  EXPECT_EQ(allocator.bad_releases, 0);
}

TEST(IcdAllocation, AnyAllocationMayFail) {
  int64_t total = 0;
  for (int64_t n = 0;; ++n) {
    CountingAllocator allocator;
    allocator.fail_at = n;
    const VkResult result = Scenario(&allocator.callbacks).run();
    ASSERT_TRUE(allocator.live.empty()) << allocator.live.size() << " allocations leak when number " << n << " fails";
    ASSERT_EQ(allocator.bad_releases, 0) << n;
    if (allocator.allocations <= n) break;  // nothing failed: all allocations were tried
    ASSERT_EQ(result, VK_ERROR_OUT_OF_HOST_MEMORY) << "allocation " << n;
    total = n;
  }
  EXPECT_GT(total, 20);
}

}  // namespace
}  // namespace pineda::test
