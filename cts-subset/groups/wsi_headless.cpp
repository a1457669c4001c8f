// wsi.headless: surfaces without a window, and swapchains on them.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

struct Surface {
  VkInstance instance = VK_NULL_HANDLE;
  VkSurfaceKHR handle = VK_NULL_HANDLE;
  explicit Surface(Device& device) : instance(device.instance()) {
    const auto create =
        reinterpret_cast<PFN_vkCreateHeadlessSurfaceEXT>(vkGetInstanceProcAddr(instance, "vkCreateHeadlessSurfaceEXT"));
    require(create, "VK_EXT_headless_surface");
    require(device.has_extension(VK_KHR_SWAPCHAIN_EXTENSION_NAME), "VK_KHR_swapchain");
    const VkHeadlessSurfaceCreateInfoEXT info{VK_STRUCTURE_TYPE_HEADLESS_SURFACE_CREATE_INFO_EXT};
    check(create(instance, &info, nullptr, &handle), "vkCreateHeadlessSurfaceEXT");
    VkBool32 supported = VK_FALSE;
    check(vkGetPhysicalDeviceSurfaceSupportKHR(device.physical(), device.queue_family(), handle, &supported),
          "vkGetPhysicalDeviceSurfaceSupportKHR");
    require(supported, "presenting to headless surfaces");
  }
  ~Surface() {
    if (handle) vkDestroySurfaceKHR(instance, handle, nullptr);
  }
  Surface(const Surface&) = delete;
};

template <typename T>
std::vector<T> all_of(Device& device, const Surface& surface, VkResult (*query)(VkPhysicalDevice, VkSurfaceKHR, uint32_t*, T*),
                      const char* call) {
  uint32_t count = 0;
  check(query(device.physical(), surface.handle, &count, nullptr), call);
  std::vector<T> all(count);
  check(query(device.physical(), surface.handle, &count, all.data()), call);
  return all;
}

std::vector<VkSurfaceFormatKHR> formats_of(Device& device, const Surface& surface) {
  return all_of(device, surface, vkGetPhysicalDeviceSurfaceFormatsKHR, "vkGetPhysicalDeviceSurfaceFormatsKHR");
}

std::vector<VkPresentModeKHR> modes_of(Device& device, const Surface& surface) {
  return all_of(device, surface, vkGetPhysicalDeviceSurfacePresentModesKHR, "vkGetPhysicalDeviceSurfacePresentModesKHR");
}

void run_queries(Device& device) {
  const Surface surface(device);
  VkSurfaceCapabilitiesKHR caps;
  check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device.physical(), surface.handle, &caps),
        "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  expect(caps.minImageCount >= 1, "minImageCount is 0");
  expect(caps.maxImageCount == 0 || caps.maxImageCount >= caps.minImageCount, "maxImageCount is below minImageCount");
  expect(caps.maxImageExtent.width >= caps.minImageExtent.width && caps.maxImageExtent.height >= caps.minImageExtent.height,
         "extents");
  expect(caps.maxImageArrayLayers >= 1, "maxImageArrayLayers is 0");
  expect(caps.supportedUsageFlags & VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, "colour attachments must be supported");
  expect(caps.supportedTransforms & caps.currentTransform, "currentTransform is not supported");
  expect(caps.supportedCompositeAlpha != 0, "no composite alpha mode");
  const auto formats = formats_of(device, surface);
  expect(!formats.empty(), "no format");
  for (const VkSurfaceFormatKHR& f : formats) {
    expect(f.format != VK_FORMAT_UNDEFINED, "an undefined format");
    expect(device.format(f.format).optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT,
           "a format that cannot be rendered to");
  }
  const auto modes = modes_of(device, surface);
  expect(std::ranges::find(modes, VK_PRESENT_MODE_FIFO_KHR) != modes.end(), "FIFO is required");
}

struct SwapchainCase {
  VkPresentModeKHR mode;
  uint32_t images, frames;
  VkExtent2D extent;
  bool recreate;
};

VkSwapchainKHR create_swapchain(Device& device, const Surface& surface, const SwapchainCase& c, VkSwapchainKHR old) {
  VkSurfaceCapabilitiesKHR caps;
  check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device.physical(), surface.handle, &caps),
        "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  require(
      caps.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT && caps.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
      "transfers with swapchain images");
  const auto modes = modes_of(device, surface);
  require(std::ranges::find(modes, c.mode) != modes.end(), "the present mode");
  VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  info.surface = surface.handle;
  info.minImageCount = std::max(c.images, caps.minImageCount);
  if (caps.maxImageCount) info.minImageCount = std::min(info.minImageCount, caps.maxImageCount);
  const VkSurfaceFormatKHR format = formats_of(device, surface)[0];
  info.imageFormat = format.format;
  info.imageColorSpace = format.colorSpace;
  info.imageExtent = c.extent;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  info.preTransform = caps.currentTransform;
  info.compositeAlpha = static_cast<VkCompositeAlphaFlagBitsKHR>(caps.supportedCompositeAlpha & -caps.supportedCompositeAlpha);
  info.presentMode = c.mode;
  info.oldSwapchain = old;
  VkSwapchainKHR swapchain = VK_NULL_HANDLE;
  check(vkCreateSwapchainKHR(device.handle(), &info, nullptr, &swapchain), "vkCreateSwapchainKHR");
  return swapchain;
}

// Clears each image to its frame's number, reads it back, presents.
void run_frames(Device& device, const SwapchainCase& c) {
  const Surface surface(device);
  VkSwapchainKHR swapchain = create_swapchain(device, surface, c, VK_NULL_HANDLE);
  const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  const auto fence = make<VkFence, vkDestroyFence>(device, vkCreateFence, fence_info, "vkCreateFence");
  const VkFence fence_handle = fence;
  for (uint32_t frame = 0; frame < c.frames; ++frame) {
    if (c.recreate && frame == c.frames / 2) {
      const VkSwapchainKHR old = swapchain;
      swapchain = create_swapchain(device, surface, c, old);
      vkDestroySwapchainKHR(device.handle(), old, nullptr);
    }
    uint32_t count = 0, index = ~0u;
    check(vkGetSwapchainImagesKHR(device.handle(), swapchain, &count, nullptr), "vkGetSwapchainImagesKHR");
    std::vector<VkImage> images(count);
    check(vkGetSwapchainImagesKHR(device.handle(), swapchain, &count, images.data()), "vkGetSwapchainImagesKHR");
    expect(count >= c.images, fmt::format("{} images, asked for {}", count, c.images));
    check(vkAcquireNextImageKHR(device.handle(), swapchain, 10'000'000'000, VK_NULL_HANDLE, fence, &index),
          "vkAcquireNextImageKHR");
    check(vkWaitForFences(device.handle(), 1, &fence_handle, VK_TRUE, ~0ull), "vkWaitForFences");
    check(vkResetFences(device.handle(), 1, &fence_handle), "vkResetFences");
    expect(index < count, fmt::format("image {} of {}", index, count));
    const Buffer out = create_buffer(device, VkDeviceSize{c.extent.width} * c.extent.height * 4);
    device.run([&](VkCommandBuffer commands) {
      const auto barrier = [&](VkImageLayout from, VkImageLayout to) {
        VkImageMemoryBarrier b{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
        b.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
        b.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
        b.oldLayout = from;
        b.newLayout = to;
        b.srcQueueFamilyIndex = b.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        b.image = images[index];
        b.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0,
                             nullptr, 1, &b);
      };
      const float value = static_cast<float>(frame % 2);
      const VkClearColorValue clear{.float32 = {value, value, value, value}};
      const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
      barrier(VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
      vkCmdClearColorImage(commands, images[index], VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &clear, 1, &whole);
      barrier(VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
      const VkBufferImageCopy copy{
          0, 0, 0, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, {0, 0, 0}, {c.extent.width, c.extent.height, 1}};
      vkCmdCopyImageToBuffer(commands, images[index], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, out.handle, 1, &copy);
      barrier(VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
      full_barrier(commands);
    });
    for (const uint32_t word : out.as<uint32_t>())
      expect(word == (frame % 2 ? ~0u : 0u), fmt::format("frame {} holds {:#x}", frame, word));
    VkPresentInfoKHR present{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
    present.swapchainCount = 1;
    present.pSwapchains = &swapchain;
    present.pImageIndices = &index;
    check(vkQueuePresentKHR(device.queue(), &present), "vkQueuePresentKHR");
  }
  check(vkQueueWaitIdle(device.queue()), "vkQueueWaitIdle");
  vkDestroySwapchainKHR(device.handle(), swapchain, nullptr);
}

// None is presented in between. One more than imageCount - minImageCount images can be acquired by waiting for them ("WSI
// Swapchain": forward progress); more only if they happen to be free. No image comes twice.
void run_acquire_all(Device& device) {
  const Surface surface(device);
  VkSurfaceCapabilitiesKHR caps;
  check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device.physical(), surface.handle, &caps),
        "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  const VkSwapchainKHR swapchain =
      create_swapchain(device, surface, {VK_PRESENT_MODE_FIFO_KHR, 2, 0, {16, 16}, false}, VK_NULL_HANDLE);
  uint32_t count = 0, index = 0;
  check(vkGetSwapchainImagesKHR(device.handle(), swapchain, &count, nullptr), "vkGetSwapchainImagesKHR");
  const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  std::set<uint32_t> seen;
  for (uint32_t i = 0; i < count; ++i) {
    const bool promised = i <= count - caps.minImageCount;
    const auto fence = make<VkFence, vkDestroyFence>(device, vkCreateFence, fence_info, "vkCreateFence");
    const VkFence handle = fence;
    const VkResult result =
        vkAcquireNextImageKHR(device.handle(), swapchain, promised ? ~0ull : 0, VK_NULL_HANDLE, fence, &index);
    if (!promised && (result == VK_NOT_READY || result == VK_TIMEOUT)) break;
    if (result != VK_SUBOPTIMAL_KHR) check(result, "vkAcquireNextImageKHR");
    check(vkWaitForFences(device.handle(), 1, &handle, VK_TRUE, ~0ull), "vkWaitForFences");
    expect(seen.insert(index).second, fmt::format("image {} was acquired twice", index));
  }
  vkDestroySwapchainKHR(device.handle(), swapchain, nullptr);
}

}  // namespace

void register_wsi_headless() {
  constexpr const char* kSection = "34.10 WSI Swapchain";
  add_case("wsi.headless", "surface_queries", "34.5 Surface Queries", run_queries);
  add_case("wsi.headless", "acquire_all", kSection, run_acquire_all);
  static constexpr std::pair<VkPresentModeKHR, const char*> kModes[] = {{VK_PRESENT_MODE_FIFO_KHR, "fifo"},
                                                                        {VK_PRESENT_MODE_MAILBOX_KHR, "mailbox"},
                                                                        {VK_PRESENT_MODE_IMMEDIATE_KHR, "immediate"},
                                                                        {VK_PRESENT_MODE_FIFO_RELAXED_KHR, "fifo_relaxed"}};
  for (const auto& [mode, name] : kModes) {
    for (const uint32_t images : {2u, 4u}) {
      for (const VkExtent2D extent : {VkExtent2D{16, 16}, VkExtent2D{129, 67}}) {
        for (const bool recreate : {false, true}) {
          const SwapchainCase c{mode, images, 6, extent, recreate};
          add_case("wsi.headless",
                   fmt::format("{}_{}_images_{}x{}{}", name, images, extent.width, extent.height, recreate ? "_recreate" : ""),
                   kSection, [c](Device& device) { run_frames(device, c); });
        }
      }
    }
  }
}

}  // namespace pineda::cts
