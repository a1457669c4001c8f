// Owning Vulkan handles: a device object that destroys itself.
#pragma once

#include <vulkan/vulkan_core.h>

#include <utility>

namespace pineda::tools {

template <typename Handle, auto kDestroy>
class Owned {
 public:
  Owned() = default;
  Owned(VkDevice device, Handle handle) : device_(device), handle_(handle) {}
  Owned(Owned&& other) noexcept : device_(other.device_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Owned() {
    if (handle_ != VK_NULL_HANDLE) kDestroy(device_, handle_, nullptr);
  }

  Handle get() const { return handle_; }
  operator Handle() const { return handle_; }  // reads like the plain handle in Vulkan calls

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  Handle handle_ = VK_NULL_HANDLE;
};

using BufferHandle = Owned<VkBuffer, vkDestroyBuffer>;
using ImageHandle = Owned<VkImage, vkDestroyImage>;
using ImageViewHandle = Owned<VkImageView, vkDestroyImageView>;
using MemoryHandle = Owned<VkDeviceMemory, vkFreeMemory>;
using SamplerHandle = Owned<VkSampler, vkDestroySampler>;
using FenceHandle = Owned<VkFence, vkDestroyFence>;
using RenderPassHandle = Owned<VkRenderPass, vkDestroyRenderPass>;
using FramebufferHandle = Owned<VkFramebuffer, vkDestroyFramebuffer>;
using ShaderModuleHandle = Owned<VkShaderModule, vkDestroyShaderModule>;
using PipelineHandle = Owned<VkPipeline, vkDestroyPipeline>;
using PipelineCacheHandle = Owned<VkPipelineCache, vkDestroyPipelineCache>;
using PipelineLayoutHandle = Owned<VkPipelineLayout, vkDestroyPipelineLayout>;
using DescriptorSetLayoutHandle = Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using DescriptorPoolHandle = Owned<VkDescriptorPool, vkDestroyDescriptorPool>;
using CommandPoolHandle = Owned<VkCommandPool, vkDestroyCommandPool>;

}  // namespace pineda::tools
