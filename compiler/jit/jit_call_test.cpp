// Calls of other kernels: on every ISA and in the evaluator, whole waves and some lanes of one.
#include "compiler/jit/test_rig.h"
#include "compiler/passes/passes.h"

namespace pineda::jit::test {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;

struct Record {
  uint32_t mask = 0, calls = 0;
  uint32_t in[kLanes] = {}, out[kLanes] = {};
};
struct Wave {
  uint32_t mask = 0xffff, reserved = 0;
  const KernelHandle* handle = nullptr;
  uint32_t in[kLanes] = {}, out[kLanes] = {};
  Record record;
};

void square(const KernelHandle* self, const void*, void*, const PrimRecord* prims, uint32_t prim_count, const void* waves) {
  ASSERT_EQ(prim_count, 1u);
  ASSERT_EQ(prims[0].prim, nullptr);
  ASSERT_EQ(prims[0].first_wave, 0u);
  ASSERT_EQ(prims[0].wave_count, 1u);
  Record& record = *static_cast<Record*>(const_cast<void*>(waves));
  for (uint32_t l = 0; l < kLanes; ++l) {
    if (record.mask >> l & 1) record.out[l] = record.in[l] * record.in[l] + *static_cast<const uint32_t*>(self->self);
  }
  ++record.calls;
}

Value call_square(Builder& b, Value x) {
  const Value record = b.ptr_add(b.wave_ptr(), b.i32(offsetof(Wave, record)));
  const auto field = [&](size_t offset_bytes, uint32_t stride) {
    return ir::Address{.base = record, .offset = b.i32(static_cast<uint32_t>(offset_bytes)), .lane_stride = stride};
  };
  b.store(field(offsetof(Record, mask), 0), b.ballot(b.b1(true)));
  b.store(field(offsetof(Record, in), 4), x);
  b.call(b.load(Type::kPtr, b.wave_ptr(), offsetof(Wave, handle)), record, sizeof(Record));
  return b.load(Type::kI32, field(offsetof(Record, out), 4));
}

TEST(JitCall, CalleesSeeTheActiveLanesAndTheirResultsComeBack) {
  const uint32_t addend = 7;
  const KernelHandle handle{&square, &addend};
  std::mt19937 rng(5);
  std::vector<Wave> waves(24);
  for (Wave& w : waves) {
    w.mask = rng() % 3 == 0 ? 0xffff : rng();
    w.handle = &handle;
    for (uint32_t& x : w.in) x = rng() % 12;
  }
  ir::Kernel kernel;
  kernel.name = "call";
  kernel.wave_stride_bytes = sizeof(Wave);
  Builder b(kernel);
  const auto lanes = [&](size_t offset_bytes) {
    return ir::Address{.base = b.wave_ptr(), .offset = b.i32(static_cast<uint32_t>(offset_bytes)), .lane_stride = 4};
  };
  const Value x = b.load(Type::kI32, lanes(offsetof(Wave, in)));
  const Value first = call_square(b, x);
  const std::vector<Value> second = b.if_else(
      b.ult(x, b.i32(5)), {Type::kI32}, [&] { return std::vector{call_square(b, b.iadd(x, first))}; },
      [&] { return std::vector{first}; });
  b.store(lanes(offsetof(Wave, out)), second[0]);
  passes::optimize(kernel, passes::Form::kMachine);
  expect_same(kernel, {.prims = {{nullptr, 0, static_cast<uint32_t>(waves.size())}},
                       .waves = waves.data(),
                       .memory = waves.data(),
                       .memory_bytes = waves.size() * sizeof(Wave)});
  const PrimRecord prim{nullptr, 0, static_cast<uint32_t>(waves.size())};
  eval::run(kernel, eval::Mode::kF32, nullptr, nullptr, &prim, 1, waves.data());
  for (const Wave& w : waves) {
    for (uint32_t l = 0; l < kLanes; ++l) {
      if (!(w.mask >> l & 1)) continue;
      const uint32_t once = w.in[l] * w.in[l] + 7, sum = w.in[l] + once;
      EXPECT_EQ(w.out[l], w.in[l] < 5 ? sum * sum + 7 : once);
    }
  }
}

}  // namespace
}  // namespace pineda::jit::test
