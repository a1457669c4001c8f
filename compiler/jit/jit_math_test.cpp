// Transcendental functions at each precision: the machine code of every ISA gives the evaluator's bits, in binary16 and binary32.
#include <bit>

#include "compiler/jit/test_rig.h"
#include "compiler/passes/passes.h"

namespace pineda::jit::test {
namespace {

using ir::Op;
using ir::Type;

struct Wave {
  uint32_t mask, index;
};

constexpr uint32_t kCount = 4096, kSeed = 7;

struct Arrays {
  std::vector<uint32_t> x, y;
  std::vector<uint32_t> result = std::vector<uint32_t>(kCount);
};

// Every exponent and sign of both formats, special values first; leading mantissa bits and the rest are random. The low half is
// what a binary16 function reads.
Arrays make_arrays() {
  std::mt19937 random(kSeed);
  Arrays a;
  for (uint32_t i = 0; i < kCount; ++i) {
    const uint32_t exponent_and_sign = (i & 511) << 23, half = (i & 63) << 10;
    a.x.push_back(exponent_and_sign | (i < 1024 ? 0 : (random() & 0x7f0000) | half | (random() & 0x3ff)));
    a.y.push_back(random() % 2 ? std::bit_cast<uint32_t>(static_cast<float>(random() / 0x1p28 - 8)) : random());
  }
  return a;
}

ir::Kernel make_kernel(Op op, Type type, Precision precision) {
  ir::Kernel kernel;
  kernel.wave_stride_bytes = sizeof(Wave);
  ir::Builder b(kernel);
  const ir::Value first = b.shl(b.load(Type::kI32, b.wave_ptr(), offsetof(Wave, index)), b.i32(6));
  const auto array = [&](uint32_t i) {
    return ir::Address{.base = b.load(Type::kPtr, b.draw_ptr(), 8 * i, ir::kInvariant), .offset = first, .lane_stride = 4};
  };
  const ir::Value x = b.load(type, array(0)), y = b.load(type, array(1));
  b.store(array(2), ir::op_info(op).operands == 2 ? b.op(op, type, {x, y}) : b.op(op, type, {x}));
  passes::optimize(kernel, passes::Form::kMachine, precision);
  return kernel;
}

class JitMath : public testing::TestWithParam<Precision> {};

TEST_P(JitMath, EveryFunctionGivesTheEvaluatorsBits) {
  Arrays a = make_arrays();
  std::vector<Wave> waves;
  for (uint32_t i = 0; i < kCount / kLanes; ++i) waves.push_back({0xffff, i});
  const void* draw[3] = {a.x.data(), a.y.data(), a.result.data()};
  const Call call{.draw = draw,
                  .prims = {{nullptr, 0, static_cast<uint32_t>(waves.size())}},
                  .waves = waves.data(),
                  .memory = a.result.data(),
                  .memory_bytes = 4 * kCount};
  for (auto op = static_cast<uint8_t>(Op::kFSin); op <= static_cast<uint8_t>(Op::kFPow); ++op) {
    for (const Type type : {Type::kF32, Type::kF16}) {
      const char* name = ir::op_info(static_cast<Op>(op)).name;
      expect_same(make_kernel(static_cast<Op>(op), type, GetParam()), call, [&](size_t byte) {
        return std::string(name) + " of x = " + std::to_string(a.x[byte / 4]) + ", y = " + std::to_string(a.y[byte / 4]) +
               " (bits)";
      });
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, JitMath, testing::Values(Precision::kDefault, Precision::kFast, Precision::kExact));

}  // namespace
}  // namespace pineda::jit::test
