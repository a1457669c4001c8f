// The two-call idiom of vkEnumerate* and vkGet*: a null array asks for the count, a short one gets VK_INCOMPLETE.
#pragma once

#include <algorithm>
#include <span>

#include "icd/vulkan_api.h"

namespace pineda::icd {

template <typename T, typename Write>
VkResult enumerate(std::span<const T> items, uint32_t* count, auto* out, Write&& write) {
  const auto available = static_cast<uint32_t>(items.size());
  if (!out) {
    *count = available;
    return VK_SUCCESS;
  }
  const uint32_t written = std::min(*count, available);
  for (uint32_t i = 0; i < written; ++i) write(out[i], items[i]);
  *count = written;
  return written < available ? VK_INCOMPLETE : VK_SUCCESS;
}

template <typename T>
VkResult enumerate(std::span<const T> items, uint32_t* count, T* out) {
  return enumerate(items, count, out, [](T& to, const T& item) { to = item; });
}

}  // namespace pineda::icd
