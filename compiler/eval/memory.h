// The two kinds of memory an evaluator runs on. Both give and take the low bytes of a word.
#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "compiler/eval/eval.h"

namespace pineda::eval {

// The sum of the floats that a and b are the bits of; NaN as FCanon has it.
template <class U>
U float_sum(U a, U b) {
  using F = std::conditional_t<sizeof(U) == 4, float, double>;
  const F sum = std::bit_cast<F>(a) + std::bit_cast<F>(b);
  return std::bit_cast<U>(sum == sum ? sum : std::numeric_limits<F>::quiet_NaN());
}

// What an atomic leaves in memory when it finds `old`. U is unsigned, of the access's width.
template <class U>
U atomic_result(ir::AtomicOp op, U old, U value, U comparand) {
  using S = std::make_signed_t<U>;
  switch (op) {
    case ir::AtomicOp::kAdd:
      return old + value;
    case ir::AtomicOp::kAnd:
      return old & value;
    case ir::AtomicOp::kOr:
      return old | value;
    case ir::AtomicOp::kXor:
      return old ^ value;
    case ir::AtomicOp::kSMin:
      return static_cast<S>(value) < static_cast<S>(old) ? value : old;
    case ir::AtomicOp::kSMax:
      return static_cast<S>(old) < static_cast<S>(value) ? value : old;
    case ir::AtomicOp::kUMin:
      return std::min(old, value);
    case ir::AtomicOp::kUMax:
      return std::max(old, value);
    case ir::AtomicOp::kExchange:
      return value;
    case ir::AtomicOp::kFAdd:
      return float_sum(old, value);
    case ir::AtomicOp::kCompareExchange:
      return old == comparand ? value : old;
  }
  return old;
}

// The process's memory. Atomics are atomic against other threads.
class DirectMemory {
 public:
  uint64_t load(uint64_t address, uint32_t size_bytes) const {
    uint64_t bits = 0;
    std::memcpy(&bits, pointer(address), size_bytes);
    return bits;
  }
  void store(uint64_t address, uint32_t size_bytes, uint64_t bits) { std::memcpy(pointer(address), &bits, size_bytes); }

  template <class U>
  U atomic(uint64_t address, ir::AtomicOp op, U value, U comparand) {
    U* place = static_cast<U*>(pointer(address));
    U old = __atomic_load_n(place, __ATOMIC_SEQ_CST);
    while (!__atomic_compare_exchange_n(place, &old, atomic_result(op, old, value, comparand), false, __ATOMIC_SEQ_CST,
                                        __ATOMIC_SEQ_CST)) {
    }
    return old;
  }

 private:
  static void* pointer(uint64_t address) { return reinterpret_cast<void*>(address); }
};

// Reads the process's memory, keeps what is written to itself.
class OverlayMemory {
 public:
  uint64_t load(uint64_t address, uint32_t size_bytes) const {
    uint64_t bits = DirectMemory().load(address, size_bytes);
    for (uint32_t i = 0; i < size_bytes && !bytes_.empty(); ++i) {
      const auto found = bytes_.find(address + i);
      if (found == bytes_.end()) continue;
      bits = (bits & ~(0xffull << (8 * i))) | static_cast<uint64_t>(found->second) << (8 * i);
    }
    return bits;
  }
  void store(uint64_t address, uint32_t size_bytes, uint64_t bits) {
    for (uint32_t i = 0; i < size_bytes; ++i) bytes_[address + i] = static_cast<uint8_t>(bits >> (8 * i));
  }

  template <class U>
  U atomic(uint64_t address, ir::AtomicOp op, U value, U comparand) {
    const auto old = static_cast<U>(load(address, sizeof(U)));
    store(address, sizeof(U), atomic_result(op, old, value, comparand));
    return old;
  }

  std::vector<WrittenByte> take() const {
    std::vector<WrittenByte> out;
    out.reserve(bytes_.size());
    for (const auto& [address, value] : bytes_) out.push_back({address, value});
    std::ranges::sort(out, {}, &WrittenByte::address);
    return out;
  }

 private:
  std::unordered_map<uint64_t, uint8_t> bytes_;
};

}  // namespace pineda::eval
