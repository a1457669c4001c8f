#include "icd/wsi/surface.h"

#include "icd/api.h"
#include "icd/enumerate.h"
#include "icd/format_caps.h"
#include "icd/instance.h"
#include "icd/limits.h"

namespace pineda::icd {

// X11 and Wayland both show little-endian words of 0xAARRGGBB.
std::span<const VkSurfaceFormatKHR> surface_formats() {
  static constexpr VkSurfaceFormatKHR kFormats[] = {{VK_FORMAT_B8G8R8A8_UNORM, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR},
                                                    {VK_FORMAT_B8G8R8A8_SRGB, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR}};
  return kFormats;
}

// What an ordinary image of the formats can be used for.
VkImageUsageFlags presentable_usage() {
  VkImageUsageFlags usage = 0;
  for (const VkImageUsageFlagBits bit :
       {VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_USAGE_TRANSFER_DST_BIT, VK_IMAGE_USAGE_SAMPLED_BIT, VK_IMAGE_USAGE_STORAGE_BIT,
        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT}) {
    VkImageFormatProperties unused;
    bool in_all = true;
    for (const VkSurfaceFormatKHR& format : surface_formats()) {
      in_all &= image_format_properties({format.format, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL, VkImageUsageFlags(bit), 0},
                                        &unused) == VK_SUCCESS;
    }
    if (in_all) usage |= bit;
  }
  return usage;
}

VkResult Surface::capabilities(VkSurfaceCapabilitiesKHR* out) const {
  VkExtent2D extent;
  if (const VkResult result = current_extent(&extent); result != VK_SUCCESS) return result;
  const bool fixed = extent.width != kAnyExtent.width;
  const uint32_t max = kLimits.maxImageDimension2D;
  *out = {.minImageCount = 2,  // one on the screen, one in work
          .maxImageCount = 0,  // memory is the limit
          .currentExtent = extent,
          .minImageExtent = fixed ? extent : VkExtent2D{1, 1},
          .maxImageExtent = fixed ? extent : VkExtent2D{max, max},
          .maxImageArrayLayers = 1,
          .supportedTransforms = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR,
          .currentTransform = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR,
          .supportedCompositeAlpha = composite_alpha(),
          .supportedUsageFlags = presentable_usage()};
  return VK_SUCCESS;
}

void api::DestroySurfaceKHR(VkInstance instance, VkSurfaceKHR surface, const VkAllocationCallbacks* callbacks) {
  destroy_object(from(surface), callbacks, from(instance)->allocator);
}

VkResult api::GetPhysicalDeviceSurfaceSupportKHR(VkPhysicalDevice, uint32_t, VkSurfaceKHR, VkBool32* out) {
  *out = VK_TRUE;  // from every queue: presenting is done by the CPU too
  return VK_SUCCESS;
}

VkResult api::GetPhysicalDeviceSurfaceCapabilitiesKHR(VkPhysicalDevice, VkSurfaceKHR surface, VkSurfaceCapabilitiesKHR* out) {
  return guarded([&] { return from(surface)->capabilities(out); });
}

VkResult api::GetPhysicalDeviceSurfaceFormatsKHR(VkPhysicalDevice, VkSurfaceKHR, uint32_t* count, VkSurfaceFormatKHR* out) {
  return enumerate(surface_formats(), count, out);
}

VkResult api::GetPhysicalDeviceSurfacePresentModesKHR(VkPhysicalDevice, VkSurfaceKHR surface, uint32_t* count,
                                                      VkPresentModeKHR* out) {
  return enumerate(from(surface)->present_modes(), count, out);
}

VkResult api::GetPhysicalDeviceSurfaceCapabilities2KHR(VkPhysicalDevice, const VkPhysicalDeviceSurfaceInfo2KHR* info,
                                                       VkSurfaceCapabilities2KHR* out) {
  return guarded([&] { return from(info->surface)->capabilities(&out->surfaceCapabilities); });
}

VkResult api::GetPhysicalDeviceSurfaceFormats2KHR(VkPhysicalDevice, const VkPhysicalDeviceSurfaceInfo2KHR*, uint32_t* count,
                                                  VkSurfaceFormat2KHR* out) {
  return enumerate(surface_formats(), count, out,
                   [](VkSurfaceFormat2KHR& to, const VkSurfaceFormatKHR& format) { to.surfaceFormat = format; });
}

// The whole window: a group has one device.
VkResult api::GetPhysicalDevicePresentRectanglesKHR(VkPhysicalDevice, VkSurfaceKHR surface, uint32_t* count, VkRect2D* out) {
  VkExtent2D extent;
  if (const VkResult result = from(surface)->current_extent(&extent); result != VK_SUCCESS) return result;
  const VkRect2D rectangles[] = {{{0, 0}, extent}};
  return enumerate(std::span<const VkRect2D>(rectangles), count, out);
}

VkResult api::GetDeviceGroupPresentCapabilitiesKHR(VkDevice, VkDeviceGroupPresentCapabilitiesKHR* out) {
  for (uint32_t& mask : out->presentMask) mask = 0;
  out->presentMask[0] = 1;
  out->modes = VK_DEVICE_GROUP_PRESENT_MODE_LOCAL_BIT_KHR;
  return VK_SUCCESS;
}

VkResult api::GetDeviceGroupSurfacePresentModesKHR(VkDevice, VkSurfaceKHR, VkDeviceGroupPresentModeFlagsKHR* out) {
  *out = VK_DEVICE_GROUP_PRESENT_MODE_LOCAL_BIT_KHR;
  return VK_SUCCESS;
}

}  // namespace pineda::icd
