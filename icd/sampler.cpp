#include "icd/sampler.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "icd/api.h"
#include "icd/chain.h"
#include "icd/device.h"
#include "icd/limits.h"
#include "icd/ycbcr.h"

namespace pineda::icd {
namespace {

bool is_integer(VkBorderColor color) {
  return color == VK_BORDER_COLOR_INT_TRANSPARENT_BLACK || color == VK_BORDER_COLOR_INT_OPAQUE_BLACK ||
         color == VK_BORDER_COLOR_INT_OPAQUE_WHITE;
}

bool uses_border(const VkSamplerCreateInfo& info) {
  constexpr VkSamplerAddressMode kBorder = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER;
  return info.addressModeU == kBorder || info.addressModeV == kBorder || info.addressModeW == kBorder;
}

bool is_custom(VkBorderColor color) {
  return color == VK_BORDER_COLOR_FLOAT_CUSTOM_EXT || color == VK_BORDER_COLOR_INT_CUSTOM_EXT;
}

// The words are kept as they come: the view's format says what kind of number they are.
void fill_custom_border(const VkSamplerCreateInfo& info, float (&to)[4]) {
  const auto* custom = find_in_chain<VkSamplerCustomBorderColorCreateInfoEXT>(
      info.pNext, VK_STRUCTURE_TYPE_SAMPLER_CUSTOM_BORDER_COLOR_CREATE_INFO_EXT);
  if (custom) std::memcpy(to, &custom->customBorderColor, sizeof(to));
}

void fill_border(VkBorderColor color, float (&to)[4]) {
  const float one = is_integer(color) ? std::bit_cast<float>(1u) : 1.0f;  // the words are read as the format's kind of number
  const bool white = color == VK_BORDER_COLOR_FLOAT_OPAQUE_WHITE || color == VK_BORDER_COLOR_INT_OPAQUE_WHITE;
  const bool transparent = color == VK_BORDER_COLOR_FLOAT_TRANSPARENT_BLACK || color == VK_BORDER_COLOR_INT_TRANSPARENT_BLACK;
  for (int i = 0; i < 3; ++i) to[i] = white ? one : 0.0f;
  to[3] = transparent ? 0.0f : one;
}

compiler::TextureState sampler_half(const VkSamplerCreateInfo& info) {
  compiler::TextureState state;
  state.mag_filter = info.magFilter;
  state.min_filter = info.minFilter;
  state.mipmap_mode = info.mipmapMode;
  state.address = {info.addressModeU, info.addressModeV, info.addressModeW};
  if (uses_border(info)) state.border = info.borderColor;  // otherwise one state for all border colours
  state.unnormalized = info.unnormalizedCoordinates;
  state.anisotropy = info.anisotropyEnable && info.maxAnisotropy > 1;
  state.compare_enable = info.compareEnable;
  if (info.compareEnable) state.compare = info.compareOp;
  const auto* reduction =
      find_in_chain<VkSamplerReductionModeCreateInfo>(info.pNext, VK_STRUCTURE_TYPE_SAMPLER_REDUCTION_MODE_CREATE_INFO);
  if (reduction) state.reduction = reduction->reductionMode;
  const auto* conversion =
      find_in_chain<VkSamplerYcbcrConversionInfo>(info.pNext, VK_STRUCTURE_TYPE_SAMPLER_YCBCR_CONVERSION_INFO);
  if (conversion) state.ycbcr = from(conversion->conversion)->state();
  return state;
}

}  // namespace

VkResult Sampler::check(Device&, const VkSamplerCreateInfo& info) {
  if (info.magFilter > VK_FILTER_LINEAR || info.minFilter > VK_FILTER_LINEAR)
    return not_supported("vkCreateSampler: unknown filter");
  for (const VkSamplerAddressMode mode : {info.addressModeU, info.addressModeV, info.addressModeW}) {
    if (mode > VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE) return not_supported("vkCreateSampler: unknown address mode");
  }
  if (uses_border(info) && info.borderColor > VK_BORDER_COLOR_INT_OPAQUE_WHITE && !is_custom(info.borderColor)) {
    return not_supported("vkCreateSampler: unknown border colour");
  }
  return VK_SUCCESS;
}

Sampler::Sampler(const Allocator& from, Device& device, const VkSamplerCreateInfo& info) : Object(from) {
  descriptor_.lod_bias = info.mipLodBias;
  descriptor_.min_lod = info.minLod;
  descriptor_.max_lod = info.maxLod;
  descriptor_.max_anisotropy = info.anisotropyEnable ? std::clamp(info.maxAnisotropy, 1.0f, kLimits.maxSamplerAnisotropy) : 1.0f;
  if (uses_border(info) && is_custom(info.borderColor)) {
    fill_custom_border(info, descriptor_.border);
  } else if (uses_border(info)) {
    fill_border(info.borderColor, descriptor_.border);
  }
  descriptor_.state_id = device.texture_states.intern_sampler(sampler_half(info));
}

VkResult api::CreateSampler(VkDevice device, const VkSamplerCreateInfo* info, const VkAllocationCallbacks* callbacks,
                            VkSampler* out) {
  return create_device_object<Sampler>(device, info, callbacks, out);
}

void api::DestroySampler(VkDevice device, VkSampler sampler, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, sampler, callbacks);
}

}  // namespace pineda::icd
