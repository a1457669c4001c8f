// VkAllocationCallbacks as RAII. Objects live in memory of the callbacks that the application passed for them (or for their
// device, their instance, or malloc), and so do the containers inside them (HostVector).
//
// Out of memory is std::bad_alloc between here and the API border, where guarded() turns it into VK_ERROR_OUT_OF_HOST_MEMORY;
// every constructor in between releases what it has by ordinary unwinding. No exception leaves an API command.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "icd/vulkan_api.h"

namespace pineda::icd {

class Allocator {
 public:
  Allocator();  // malloc
  // `callbacks` may be null: then as `fallback`.
  Allocator(const VkAllocationCallbacks* callbacks, const Allocator& fallback)
      : callbacks_(callbacks ? *callbacks : fallback.callbacks_) {}

  // Null when memory is exhausted.
  void* allocate(size_t size_bytes, size_t alignment, VkSystemAllocationScope scope) const {
    return callbacks_.pfnAllocation(callbacks_.pUserData, size_bytes, alignment, scope);
  }
  void release(void* memory) const {
    if (memory) callbacks_.pfnFree(callbacks_.pUserData, memory);
  }

 private:
  VkAllocationCallbacks callbacks_;
};

// For containers that are members of an object: `source` is the object's allocator.
template <typename T>
struct HostAllocator {
  using value_type = T;
  const Allocator* source;
  VkSystemAllocationScope scope;

  explicit HostAllocator(const Allocator* from, VkSystemAllocationScope s = VK_SYSTEM_ALLOCATION_SCOPE_OBJECT)
      : source(from), scope(s) {}
  template <typename U>
  HostAllocator(const HostAllocator<U>& other) : source(other.source), scope(other.scope) {}

  T* allocate(size_t count) {
    void* memory = source->allocate(count * sizeof(T), alignof(T), scope);
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t) { source->release(memory); }
  bool operator==(const HostAllocator& other) const { return source == other.source; }
};

template <typename T>
using HostVector = std::vector<T, HostAllocator<T>>;

// Base of everything with a handle. Never moves: containers point to `allocator`.
struct Object {
  Allocator allocator;
  explicit Object(const Allocator& from) : allocator(from) {}
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
};

template <typename T>
void release_object(T* object) {
  if (!object) return;
  const Allocator allocator = object->allocator;
  object->~T();
  allocator.release(object);
}

struct ObjectDeleter {
  template <typename T>
  void operator()(T* object) const {
    release_object(object);
  }
};
template <typename T>
using Owned = std::unique_ptr<T, ObjectDeleter>;

// Constructs T(allocator, args...) in the allocator's memory; throws std::bad_alloc.
template <typename T, typename... Args>
Owned<T> make_object(const Allocator& allocator, VkSystemAllocationScope scope, Args&&... args) {
  void* memory = allocator.allocate(sizeof(T), alignof(T), scope);
  if (!memory) throw std::bad_alloc();
  try {
    return Owned<T>(new (memory) T(allocator, std::forward<Args>(args)...));
  } catch (...) {
    allocator.release(memory);
    throw;
  }
}

// vkDestroy*: the callbacks given now release the memory (they are compatible with those of creation, but their pUserData may
// differ).
template <typename T>
void destroy_object(T* object, const VkAllocationCallbacks* callbacks, const Allocator& fallback) {
  if (!object) return;
  object->allocator = Allocator(callbacks, fallback);
  release_object(object);
}

}  // namespace pineda::icd
