// Chains of extending structures (pNext).
#pragma once

#include "icd/vulkan_api.h"

namespace pineda::icd {

// The structure of a type in an input chain; null when it is not there.
template <typename Struct>
const Struct* find_in_chain(const void* chain, VkStructureType type) {
  for (auto* next = static_cast<const VkBaseInStructure*>(chain); next; next = next->pNext) {
    if (next->sType == type) return reinterpret_cast<const Struct*>(next);
  }
  return nullptr;
}

// The same of an output chain.
template <typename Struct>
Struct* find_in_chain(void* chain, VkStructureType type) {
  for (auto* next = static_cast<VkBaseOutStructure*>(chain); next; next = next->pNext) {
    if (next->sType == type) return reinterpret_cast<Struct*>(next);
  }
  return nullptr;
}

}  // namespace pineda::icd
