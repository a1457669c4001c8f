// A bump allocator of plain data: recorded commands, draw contexts. reset() keeps the blocks for the next use.
#pragma once

#include <cstring>
#include <span>
#include <type_traits>

#include "icd/allocator.h"

namespace pineda::icd {

class Arena {
 public:
  explicit Arena(const Allocator& from, VkSystemAllocationScope scope)
      : blocks_(HostAllocator<Block>(&from, scope)), from_(from), scope_(scope) {}
  ~Arena() { release(); }
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  // Throws std::bad_alloc.
  void* allocate(size_t size_bytes, size_t alignment) {
    size_t start = (used_ + alignment - 1) / alignment * alignment;  // blocks are aligned to 64
    if (current_ == blocks_.size() || start + size_bytes > blocks_[current_].size_bytes) {
      next_block(size_bytes);
      start = 0;
    }
    used_ = start + size_bytes;
    return blocks_[current_].memory + start;
  }

  template <typename T>
  T* make(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return new (allocate(sizeof(T), alignof(T))) T(value);
  }

  template <typename T>
  std::span<const T> copy(const T* data, size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count == 0) return {};
    void* to = allocate(count * sizeof(T), alignof(T));
    std::memcpy(to, data, count * sizeof(T));
    return {static_cast<const T*>(to), count};
  }

  void reset() {
    current_ = 0;
    used_ = 0;
  }

  // Gives the memory back.
  void release() {
    for (const Block& block : blocks_) from_.release(block.memory);
    blocks_.clear();
    reset();
  }

 private:
  static constexpr size_t kBlockBytes = 16 * 1024;
  static constexpr size_t kAlignment = 64;

  struct Block {
    uint8_t* memory;
    size_t size_bytes;
  };

  // Moves to the next kept block that is large enough, or inserts a new one.
  void next_block(size_t size_bytes) {
    size_t next = blocks_.empty() ? 0 : current_ + (used_ > 0 ? 1 : 0);
    if (next < blocks_.size() && blocks_[next].size_bytes >= size_bytes) {
      current_ = next;
      return;
    }
    const size_t bytes = size_bytes > kBlockBytes ? size_bytes : kBlockBytes;
    if (blocks_.size() == blocks_.capacity()) blocks_.reserve(blocks_.size() * 2 + 4);  // before: insert() must not throw
    auto* memory = static_cast<uint8_t*>(from_.allocate(bytes, kAlignment, scope_));
    if (!memory) throw std::bad_alloc();
    blocks_.insert(blocks_.begin() + ptrdiff_t(next), {memory, bytes});
    current_ = next;
  }

  HostVector<Block> blocks_;
  const Allocator& from_;
  const VkSystemAllocationScope scope_;
  size_t current_ = 0;  // block in use
  size_t used_ = 0;     // bytes of it
};

}  // namespace pineda::icd
