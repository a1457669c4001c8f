#include "icd/allocator.h"

#include <cstdlib>

namespace pineda::icd {
namespace {

void* malloc_callback(void*, size_t size_bytes, size_t alignment, VkSystemAllocationScope) {
  if (alignment <= alignof(std::max_align_t)) return std::malloc(size_bytes);
  return std::aligned_alloc(alignment, (size_bytes + alignment - 1) / alignment * alignment);
}

void* realloc_callback(void*, void* original, size_t size_bytes, size_t, VkSystemAllocationScope) {
  return std::realloc(original, size_bytes);  // never called by the driver; the structure wants one
}

void free_callback(void*, void* memory) { std::free(memory); }

}  // namespace

Allocator::Allocator() : callbacks_{nullptr, malloc_callback, realloc_callback, free_callback, nullptr, nullptr} {}

}  // namespace pineda::icd
