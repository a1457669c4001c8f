#include "icd/ycbcr.h"

#include "base/format.h"
#include "icd/api.h"
#include "icd/device.h"
#include "icd/image_view.h"

namespace pineda::icd {

VkResult SamplerYcbcrConversion::check(Device&, const VkSamplerYcbcrConversionCreateInfo& info) {
  const FormatInfo* format = find_format(info.format);
  const bool planar = format && format->plane_count() > 1 && !format->is_depth_or_stencil();
  const bool plain = format && format->is_plain() && info.ycbcrModel == VK_SAMPLER_YCBCR_MODEL_CONVERSION_RGB_IDENTITY;
  if (!planar && !plain) return not_supported("vkCreateSamplerYcbcrConversion: the format has no conversion");
  if (info.forceExplicitReconstruction) return not_supported("vkCreateSamplerYcbcrConversion: reconstruction is implicit");
  return VK_SUCCESS;
}

SamplerYcbcrConversion::SamplerYcbcrConversion(const Allocator& from_allocator, Device&,
                                               const VkSamplerYcbcrConversionCreateInfo& info)
    : Object(from_allocator) {
  if (find_format(info.format)->plane_count() == 1) return;
  const auto component = [&](VkComponentSwizzle c, uint8_t identity) { return swizzle_source(c, identity); };
  state_ = compiler::YcbcrState{.format = info.format,
                                .model = info.ycbcrModel,
                                .range = info.ycbcrRange,
                                .chroma_offset = {info.xChromaOffset, info.yChromaOffset},
                                .chroma_filter = info.chromaFilter,
                                .swizzle = {component(info.components.r, 0), component(info.components.g, 1),
                                            component(info.components.b, 2), component(info.components.a, 3)}};
}

VkResult api::CreateSamplerYcbcrConversion(VkDevice device, const VkSamplerYcbcrConversionCreateInfo* info,
                                           const VkAllocationCallbacks* callbacks, VkSamplerYcbcrConversion* out) {
  return create_device_object<SamplerYcbcrConversion>(device, info, callbacks, out);
}

void api::DestroySamplerYcbcrConversion(VkDevice device, VkSamplerYcbcrConversion conversion,
                                        const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, conversion, callbacks);
}

}  // namespace pineda::icd
