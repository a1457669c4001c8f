#include "icd/buffer_view.h"

#include <algorithm>

#include "base/format.h"
#include "icd/api.h"
#include "icd/buffer.h"
#include "icd/device.h"
#include "icd/format_caps.h"
#include "icd/limits.h"

namespace pineda::icd {

VkResult BufferView::check(Device&, const VkBufferViewCreateInfo& info) {
  constexpr VkFormatFeatureFlags kTexels =
      VK_FORMAT_FEATURE_UNIFORM_TEXEL_BUFFER_BIT | VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_BIT;
  if (!(format_properties(info.format).bufferFeatures & kTexels)) {
    return not_supported("vkCreateBufferView: the format is not supported for texel buffers");
  }
  if (!from(info.buffer)->data()) return not_supported("vkCreateBufferView: the buffer has no memory bound");
  return VK_SUCCESS;
}

BufferView::BufferView(const Allocator& from_allocator, Device& device, const VkBufferViewCreateInfo& info)
    : Object(from_allocator) {
  const Buffer& buffer = *from(info.buffer);
  const uint32_t texel_bytes = find_format(info.format)->texel_bytes;
  const VkDeviceSize texels =
      std::min<VkDeviceSize>(buffer.clamp(info.offset, info.range) / texel_bytes, kLimits.maxTexelBufferElements);
  descriptor_.address = reinterpret_cast<uint64_t>(buffer.data()) + info.offset;
  descriptor_.size_bytes = static_cast<uint32_t>(texels * texel_bytes);
  descriptor_.width = static_cast<uint32_t>(texels);
  descriptor_.height = descriptor_.depth = descriptor_.level_count = descriptor_.layer_count = 1;
  descriptor_.format = static_cast<uint32_t>(info.format);
  compiler::TextureState state;
  state.format = info.format;
  state.view_type = VK_IMAGE_VIEW_TYPE_1D;
  state.single_level = true;
  descriptor_.state_id = device.texture_states.intern_view(state);
}

VkResult api::CreateBufferView(VkDevice device, const VkBufferViewCreateInfo* info, const VkAllocationCallbacks* callbacks,
                               VkBufferView* out) {
  return create_device_object<BufferView>(device, info, callbacks, out);
}

void api::DestroyBufferView(VkDevice device, VkBufferView view, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, view, callbacks);
}

}  // namespace pineda::icd
