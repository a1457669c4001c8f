// VkAllocationCallbacks: whatever allocation fails, the command says VK_ERROR_OUT_OF_HOST_MEMORY, nothing leaks, nothing crashes.
#include <xcb/xcb.h>

#include <cstdlib>
#include <map>
#include <mutex>
#include <set>
#include <string>

#include "icd_client.h"
#include "icd_shaders.h"
// After vulkan.h:
#include <vulkan/vulkan_wayland.h>
#include <vulkan/vulkan_xcb.h>

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
      : c_(callbacks,
           {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_DEBUG_REPORT_EXTENSION_NAME, VK_KHR_SURFACE_EXTENSION_NAME,
            VK_EXT_HEADLESS_SURFACE_EXTENSION_NAME, VK_KHR_XCB_SURFACE_EXTENSION_NAME, VK_KHR_WAYLAND_SURFACE_EXTENSION_NAME},
           {VK_KHR_SWAPCHAIN_EXTENSION_NAME, VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME}, Enabled::kOnlyAsked),
        callbacks_(callbacks) {}

  // Every vkCreate* and vkAllocate* that run() has called.
  std::set<std::string> called{"CreateInstance", "CreateDevice", "CreateCommandPool"};  // by Client

  VkResult run() {
    if (c_.result != VK_SUCCESS) return c_.result;
    for (const auto step :
         {&Scenario::messengers, &Scenario::sync, &Scenario::resources, &Scenario::views, &Scenario::descriptors,
          &Scenario::passes, &Scenario::shaders, &Scenario::pipelines, &Scenario::windows, &Scenario::commands}) {
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
#define MAKE(name, info, out) MAKE_AS(name, name, info, out)
#define MAKE_AS(name, destroyer, info, out)                                                  \
  do {                                                                                       \
    called.insert("Create" #name);                                                           \
    const VkResult made = make(VK(c_, Create##name), VK(c_, Destroy##destroyer), info, out); \
    if (made != VK_SUCCESS) return made;                                                     \
  } while (false)
  // Of the instance.
#define MAKE_INSTANCE(name, destroyer, info, out)                                                     \
  do {                                                                                                \
    called.insert("Create" #name);                                                                    \
    const VkResult made = VK(c_, Create##name)(c_.instance, &info, callbacks_, out);                  \
    if (made != VK_SUCCESS) {                                                                         \
      EXPECT_FALSE(*out);                                                                             \
      return made;                                                                                    \
    }                                                                                                 \
    c_.defer([this, handle = *out] { VK(c_, Destroy##destroyer)(c_.instance, handle, callbacks_); }); \
  } while (false)

  VkResult messengers() {
    VkDebugUtilsMessengerCreateInfoEXT messenger_info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger_info.pfnUserCallback = [](VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                        const VkDebugUtilsMessengerCallbackDataEXT*, void*) -> VkBool32 { return VK_FALSE; };
    VkDebugUtilsMessengerEXT messenger;
    MAKE_INSTANCE(DebugUtilsMessengerEXT, DebugUtilsMessengerEXT, messenger_info, &messenger);
    VkDebugReportCallbackCreateInfoEXT callback_info{VK_STRUCTURE_TYPE_DEBUG_REPORT_CALLBACK_CREATE_INFO_EXT};
    callback_info.pfnCallback = [](VkDebugReportFlagsEXT, VkDebugReportObjectTypeEXT, uint64_t, size_t, int32_t, const char*,
                                   const char*, void*) -> VkBool32 { return VK_FALSE; };
    VkDebugReportCallbackEXT callback;
    MAKE_INSTANCE(DebugReportCallbackEXT, DebugReportCallbackEXT, callback_info, &callback);
    return VK_SUCCESS;
  }

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
    buffer.usage =
        VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    MAKE(Buffer, buffer, &buffer_);
    VkImageCreateInfo image{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    image.imageType = VK_IMAGE_TYPE_2D;
    image.format = VK_FORMAT_R8G8B8A8_UNORM;
    image.extent = {16, 16, 1};
    image.mipLevels = image.arrayLayers = 1;
    image.samples = VK_SAMPLE_COUNT_1_BIT;
    image.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    MAKE(Image, image, &image_);
    called.insert("AllocateMemory");
    const VkMemoryAllocateInfo memory_info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, 8192, 0};
    VkDeviceMemory memory;
    const VkResult result = VK(c_, AllocateMemory)(c_.device, &memory_info, callbacks_, &memory);
    if (result != VK_SUCCESS) return result;
    c_.defer([this, memory] { VK(c_, FreeMemory)(c_.device, memory, callbacks_); });
    EXPECT_EQ(VK(c_, BindBufferMemory)(c_.device, buffer_, memory, 0), VK_SUCCESS);
    EXPECT_EQ(VK(c_, BindImageMemory)(c_.device, image_, memory, 4096), VK_SUCCESS);
    VkBufferViewCreateInfo view{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    view.buffer = buffer_;
    view.format = VK_FORMAT_R8G8B8A8_UNORM;
    view.range = VK_WHOLE_SIZE;
    VkBufferView buffer_view;
    MAKE(BufferView, view, &buffer_view);
    return VK_SUCCESS;
  }

  VkResult views() {
    VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = image_;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = VK_FORMAT_R8G8B8A8_UNORM;
    info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    MAKE(ImageView, info, &view_);
    MAKE(Sampler, VkSamplerCreateInfo{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO}, &sampler_);
    VkSamplerYcbcrConversionCreateInfo conversion_info{VK_STRUCTURE_TYPE_SAMPLER_YCBCR_CONVERSION_CREATE_INFO};
    conversion_info.format = VK_FORMAT_G8_B8R8_2PLANE_420_UNORM;
    VkSamplerYcbcrConversion conversion;
    MAKE(SamplerYcbcrConversion, conversion_info, &conversion);
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
    called.insert("AllocateDescriptorSets");
    if (const VkResult result = VK(c_, AllocateDescriptorSets)(c_.device, &allocate, sets); result != VK_SUCCESS) return result;
    const VkDescriptorUpdateTemplateEntry entries[] = {{1, 0, 2, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 0, 64},
                                                       {0, 0, 1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 128, 64}};
    VkDescriptorUpdateTemplateCreateInfo template_info{VK_STRUCTURE_TYPE_DESCRIPTOR_UPDATE_TEMPLATE_CREATE_INFO};
    template_info.descriptorUpdateEntryCount = 2;
    template_info.pDescriptorUpdateEntries = entries;
    template_info.descriptorSetLayout = layout;
    VkDescriptorUpdateTemplate update;
    MAKE(DescriptorUpdateTemplate, template_info, &update);
    return VK_SUCCESS;
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
    MAKE(RenderPass, info, &render_pass_);
    VkAttachmentDescription2 attachment2{VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2};
    attachment2.format = VK_FORMAT_R8G8B8A8_UNORM;
    attachment2.samples = VK_SAMPLE_COUNT_1_BIT;
    attachment2.finalLayout = VK_IMAGE_LAYOUT_GENERAL;
    const VkAttachmentReference2 reference2{VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2, nullptr, 0, VK_IMAGE_LAYOUT_GENERAL,
                                            VK_IMAGE_ASPECT_COLOR_BIT};
    VkSubpassDescription2 subpass2{VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_2};
    subpass2.colorAttachmentCount = 1;
    subpass2.pColorAttachments = &reference2;
    VkRenderPassCreateInfo2 info2{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO_2};
    info2.attachmentCount = info2.subpassCount = 1;
    info2.pAttachments = &attachment2;
    info2.pSubpasses = &subpass2;
    VkRenderPass second;
    MAKE_AS(RenderPass2KHR, RenderPass, info2, &second);
    const VkFramebufferCreateInfo framebuffer_info{
        VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO, nullptr, 0, render_pass_, 1, &view_, 16, 16, 1};
    VkFramebuffer framebuffer;
    MAKE(Framebuffer, framebuffer_info, &framebuffer);
    return VK_SUCCESS;
  }

  VkResult shaders() {
    const std::span<const uint32_t> codes[] = {kColorVertex, kColorFragment, kScaleCompute};
    for (size_t i = 0; i < 3; ++i) {
      VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
      info.codeSize = codes[i].size_bytes();
      info.pCode = codes[i].data();
      MAKE(ShaderModule, info, &modules_[i]);
    }
    MAKE(PipelineCache, VkPipelineCacheCreateInfo{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO}, &cache_);
    return VK_SUCCESS;
  }

  // One pipeline of each kind; a failure leaves a null handle.
  template <typename Info>
  VkResult make_pipeline(const char* name, auto create, const Info& info) {
    called.insert(name);
    VkPipeline pipeline = VK_NULL_HANDLE;
    const VkResult result = create(c_.device, cache_, 1, &info, callbacks_, &pipeline);
    EXPECT_EQ(result == VK_SUCCESS, pipeline != VK_NULL_HANDLE);
    if (pipeline) c_.defer([this, pipeline] { VK(c_, DestroyPipeline)(c_.device, pipeline, callbacks_); });
    return result;
  }
  VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits bit, VkShaderModule module) {
    return {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, bit, module, "main", nullptr};
  }

  VkResult pipelines() {
    const VkDescriptorSetLayoutBinding bindings[] = {{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_ALL, nullptr},
                                                     {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_ALL, nullptr}};
    const VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0, 2, bindings};
    VkDescriptorSetLayout set_layout;
    MAKE(DescriptorSetLayout, set_info, &set_layout);
    const VkPushConstantRange range{VK_SHADER_STAGE_ALL, 0, 64};
    const VkPipelineLayoutCreateInfo layout_info{
        VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, nullptr, 0, 1, &set_layout, 1, &range};
    VkPipelineLayout layout;
    MAKE(PipelineLayout, layout_info, &layout);
    VkComputePipelineCreateInfo compute{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    compute.stage = stage(VK_SHADER_STAGE_COMPUTE_BIT, modules_[2]);
    compute.layout = layout;
    VkResult result = make_pipeline("CreateComputePipelines", VK(c_, CreateComputePipelines), compute);
    if (result != VK_SUCCESS) return result;
    const VkPipelineShaderStageCreateInfo stages[] = {stage(VK_SHADER_STAGE_VERTEX_BIT, modules_[0]),
                                                      stage(VK_SHADER_STAGE_FRAGMENT_BIT, modules_[1])};
    const VkVertexInputBindingDescription binding{0, 64, VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32_SFLOAT, 0},
                                                            {1, 0, VK_FORMAT_R32G32_SFLOAT, 16}};
    const VkPipelineVertexInputStateCreateInfo vertex_input{
        VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO, nullptr, 0, 1, &binding, 2, attributes};
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    const VkViewport viewport{0, 0, 16, 16, 0, 1};
    const VkRect2D scissor{{0, 0}, {16, 16}};
    const VkPipelineViewportStateCreateInfo viewports{
        VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, nullptr, 0, 1, &viewport, 1, &scissor};
    VkPipelineRasterizationStateCreateInfo rasterization{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    rasterization.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineColorBlendAttachmentState blend{};
    blend.colorWriteMask = 15;
    VkPipelineColorBlendStateCreateInfo blending{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blending.attachmentCount = 1;
    blending.pAttachments = &blend;
    VkGraphicsPipelineCreateInfo graphics{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    graphics.stageCount = 2;
    graphics.pStages = stages;
    graphics.pVertexInputState = &vertex_input;
    graphics.pInputAssemblyState = &assembly;
    graphics.pViewportState = &viewports;
    graphics.pRasterizationState = &rasterization;
    graphics.pMultisampleState = &samples;
    graphics.pColorBlendState = &blending;
    graphics.layout = layout;
    graphics.renderPass = render_pass_;
    return make_pipeline("CreateGraphicsPipelines", VK(c_, CreateGraphicsPipelines), graphics);
  }

  // Surfaces of window systems are only a connection and a window until somebody asks for more.
  VkResult windows() {
    int nobody = 0;
    VkXcbSurfaceCreateInfoKHR xcb{VK_STRUCTURE_TYPE_XCB_SURFACE_CREATE_INFO_KHR};
    xcb.connection = reinterpret_cast<xcb_connection_t*>(&nobody);
    VkSurfaceKHR surface;
    MAKE_INSTANCE(XcbSurfaceKHR, SurfaceKHR, xcb, &surface);
    VkWaylandSurfaceCreateInfoKHR wayland{VK_STRUCTURE_TYPE_WAYLAND_SURFACE_CREATE_INFO_KHR};
    wayland.display = reinterpret_cast<wl_display*>(&nobody);
    MAKE_INSTANCE(WaylandSurfaceKHR, SurfaceKHR, wayland, &surface);
    const VkHeadlessSurfaceCreateInfoEXT headless{VK_STRUCTURE_TYPE_HEADLESS_SURFACE_CREATE_INFO_EXT};
    MAKE_INSTANCE(HeadlessSurfaceEXT, SurfaceKHR, headless, &surface);
    VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
    info.surface = surface;
    info.minImageCount = 3;
    info.imageFormat = VK_FORMAT_B8G8R8A8_UNORM;
    info.imageExtent = {16, 16};
    info.imageArrayLayers = 1;
    info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    info.preTransform = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR;
    info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
    VkSwapchainKHR swapchain;
    MAKE(SwapchainKHR, info, &swapchain);
    return VK_SUCCESS;
  }

  // Enough commands for several arena blocks; the failure shows at vkEndCommandBuffer.
  VkResult commands() {
    const VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, c_.pool,
                                           VK_COMMAND_BUFFER_LEVEL_PRIMARY, 2};
    VkCommandBuffer command_buffers[2];
    called.insert("AllocateCommandBuffers");
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
  VkRenderPass render_pass_ = VK_NULL_HANDLE;
  VkShaderModule modules_[3] = {};  // vertex, fragment, compute
  VkPipelineCache cache_ = VK_NULL_HANDLE;
};

// Every command of the driver's table that makes something.
std::set<std::string> creating_commands() {
  std::set<std::string> names;
  const auto add = [&](std::string name) {
    if (name.starts_with("Create") || name.starts_with("Allocate")) names.insert(std::move(name));
  };
#define PINEDA_GLOBAL(name) add(#name);
#define PINEDA_INSTANCE(name, gate) add(#name);
#define PINEDA_PHYSICAL(name, gate) add(#name);
#define PINEDA_DEVICE(name, gate) add(#name);
#define PINEDA_PLATFORM_INSTANCE(name, gate) add(#name);
#include "icd/commands.inc"
  return names;
}

TEST(IcdAllocation, EverythingIsReleasedThroughTheCallbacks) {
  CountingAllocator allocator;
  {
    Scenario scenario(&allocator.callbacks);
    EXPECT_EQ(scenario.run(), VK_SUCCESS);
    std::set<std::string> expected = creating_commands();
    expected.erase("CreateXlibSurfaceKHR");  // asks the display for its connection, then does what CreateXcbSurfaceKHR does
    EXPECT_EQ(scenario.called, expected) << "every command that creates is tried here";
  }
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
