// Random kernels for differential tests: whoever runs or rewrites kernels must leave the same bytes behind as the evaluator does.
//
//     for (uint64_t seed = 1; seed <= 200; ++seed) {
//       ir::RandomKernel random(seed);
//       const auto expected = random.run([&](auto... args) { eval::run(random.kernel(), eval::Mode::kF32, args...); });
//       const auto actual = random.run([&](auto... args) { code.fn(nullptr, args...); });
//     }
//
// A kernel holds arithmetic on every type with special values, selects, nested Ifs, bounded loops, Locals, checked loads and
// stores with offsets that are partly out of range, lane strides, atomics, conversions, subgroup operations, and QuadSwizzle
// where all lanes run. It runs over five waves of three primitives (one of them empty), with values of every rate. A seed gives
// one kernel in every build by one compiler.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/abi.h"
#include "compiler/ir/ir.h"

namespace pineda::ir {

struct RandomKernelOptions {
  uint32_t statements = 40;      // at the top level; nested ones come on top
  bool other_widths = true;      // I8, I16, I64, F16, F64 beside I32 and F32
  bool transcendentals = false;  // needs lower_math, which defines their bits
  bool atomics = true;
  bool barriers = false;  // and memory that the waves of a primitive share
};

class RandomKernel {
 public:
  explicit RandomKernel(uint64_t seed, const RandomKernelOptions& options = {});
  ~RandomKernel();

  const Kernel& kernel() const { return kernel_; }  // verified

  // Runs over the same initial memory each time; gives all bytes that the kernel may write.
  using Run =
      std::function<void(const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count, const void* waves)>;
  std::vector<uint8_t> run(const Run& run);

 private:
  struct Memory;
  Kernel kernel_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace pineda::ir
