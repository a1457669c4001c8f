// Chains of extending structures (pNext).
#pragma once

#include <cstdint>
#include <cstring>

#include "icd/vulkan_api.h"

namespace pineda::icd {

// Applications may chain structures whose types this driver's headers do not name: such a value is no value of the enumeration,
// so it is read as what it is in memory.
inline int32_t type_number(const void* structure) {
  int32_t number;
  std::memcpy(&number, structure, sizeof(number));  // sType is the first member
  return number;
}

// The structure of a type in an input chain; null when it is not there.
template <typename Struct>
const Struct* find_in_chain(const void* chain, VkStructureType type) {
  for (auto* next = static_cast<const VkBaseInStructure*>(chain); next; next = next->pNext) {
    if (type_number(next) == type) return reinterpret_cast<const Struct*>(next);
  }
  return nullptr;
}

// The same of an output chain.
template <typename Struct>
Struct* find_in_chain(void* chain, VkStructureType type) {
  for (auto* next = static_cast<VkBaseOutStructure*>(chain); next; next = next->pNext) {
    if (type_number(next) == type) return reinterpret_cast<Struct*>(next);
  }
  return nullptr;
}

}  // namespace pineda::icd
