// The evaluator's machinery: masks, memory, control flow, environment. What each operation computes is in ops_test.cpp.
#include "compiler/eval/eval.h"

#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "compiler/ir/builder.h"

namespace pineda::eval {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;

// A kernel over waves of {mask, 16 words}: word l is lane l's cell.
struct WaveRecord {
  uint32_t mask = 0xffff;
  uint32_t cell[kLanes] = {};
};

struct Rig {
  Rig() { kernel.wave_stride_bytes = sizeof(WaveRecord); }
  Builder builder() { return Builder(kernel); }
  static Value cell(Builder& b, Type type = Type::kI32) {
    return b.load(type, {.base = b.wave_ptr(), .offset = b.i32(4), .lane_stride = 4});
  }
  static void put(Builder& b, Value v) { b.store({.base = b.wave_ptr(), .offset = b.i32(4), .lane_stride = 4}, v); }
  void run(Mode mode = Mode::kF32) {
    ASSERT_EQ(ir::verify(kernel), "");
    const PrimRecord prim{nullptr, 0, static_cast<uint32_t>(waves.size())};
    eval::run(kernel, mode, nullptr, nullptr, &prim, 1, waves.data());
  }
  ir::Kernel kernel;
  std::vector<WaveRecord> waves{1};
};

TEST(Eval, LoopRunsEachLaneItsOwnNumberOfTimes) {
  Rig rig;
  Builder b = rig.builder();
  const Value limit = b.lane();
  const auto out = b.loop({b.i32(0), b.i32(1)}, [&](std::span<const Value> c) {
    const Value n = b.iadd(c[0], b.i32(1));
    return Builder::LoopStep{b.ult(n, limit), {n, b.imul(c[1], n)}};
  });
  Rig::put(b, out[1]);
  rig.run();
  uint32_t factorial = 1;
  for (uint32_t l = 0; l < kLanes; ++l) {
    if (l > 0) factorial *= l;
    EXPECT_EQ(rig.waves[0].cell[l], factorial) << l;
  }
}

TEST(Eval, LoopCarriesValuesInParallel) {  // Fibonacci: next = {b, a + b}, both from before the step
  Rig rig;
  Builder b = rig.builder();
  const auto out = b.loop({b.i32(0), b.i32(1), b.i32(0)}, [&](std::span<const Value> c) {
    const Value n = b.iadd(c[2], b.i32(1));
    return Builder::LoopStep{b.ult(n, b.i32(10)), {c[1], b.iadd(c[0], c[1]), n}};
  });
  Rig::put(b, out[0]);
  rig.run();
  EXPECT_EQ(rig.waves[0].cell[3], 55u);
}

TEST(Eval, OnlyActiveLanesHaveEffects) {
  Rig rig;
  rig.waves[0].mask = 0x00f0;
  Builder b = rig.builder();
  b.if_(b.ult(b.lane(), b.i32(6)), [&] { Rig::put(b, b.ballot(b.b1(true))); });
  rig.run();
  for (uint32_t l = 0; l < kLanes; ++l) EXPECT_EQ(rig.waves[0].cell[l], l == 4 || l == 5 ? 0x30u : 0u) << l;
}

TEST(Eval, AllLanesStoreIgnoresTheMask) {
  Rig rig;
  rig.waves[0].mask = 1;
  Builder b = rig.builder();
  b.store({.base = b.wave_ptr(), .offset = b.i32(4), .lane_stride = 4}, b.lane(), ir::kAllLanes);
  rig.run();
  for (uint32_t l = 0; l < kLanes; ++l) EXPECT_EQ(rig.waves[0].cell[l], l);
}

TEST(Eval, IfMergesBothSides) {
  Rig rig;
  Builder b = rig.builder();
  const auto r = b.if_else(
      b.ult(b.lane(), b.i32(8)), {Type::kI32}, [&] { return std::vector{b.i32(1)}; }, [&] { return std::vector{b.lane()}; });
  Rig::put(b, r[0]);
  rig.run();
  EXPECT_EQ(rig.waves[0].cell[7], 1u);
  EXPECT_EQ(rig.waves[0].cell[8], 8u);
}

TEST(Eval, ChecksDoNotWrap) {
  uint32_t memory[2] = {7, 9};
  Rig rig;
  Builder b = rig.builder();
  const Value base = b.load(Type::kPtr, b.draw_ptr(), 0);
  const Value offset = Rig::cell(b);
  Rig::put(b, b.load(Type::kI32, {.base = base, .offset = offset, .limit = b.i32(8)}));
  ASSERT_EQ(ir::verify(rig.kernel), "");
  const uint32_t offsets[] = {0, 4, 5, 8, 0xfffffffc, 0xffffffff};
  std::copy(std::begin(offsets), std::end(offsets), rig.waves[0].cell);
  const void* draw = memory;
  const PrimRecord prim{nullptr, 0, 1};
  run(rig.kernel, Mode::kF32, &draw, nullptr, &prim, 1, rig.waves.data());
  const uint32_t expected[] = {7, 9, 0, 0, 0, 0};
  for (int l = 0; l < 6; ++l) EXPECT_EQ(rig.waves[0].cell[l], expected[l]) << l;
}

TEST(Eval, LocalsStartAtZeroInEachWave) {
  Rig rig;
  rig.waves.resize(2);
  Builder b = rig.builder();
  const Value array = b.local(Type::kI32, 4);
  const Value index = b.lane();  // 4 and above: reads give 0, writes vanish
  const Value old = b.local_load(array, index);
  b.local_store(array, index, b.iadd(old, b.i32(5)));
  Rig::put(b, b.local_load(array, index));
  rig.run();
  for (const WaveRecord& wave : rig.waves) {
    for (uint32_t l = 0; l < kLanes; ++l) EXPECT_EQ(wave.cell[l], l < 4 ? 5u : 0u) << l;
  }
}

TEST(Eval, SourcesGiveTheirPointers) {
  Rig rig;
  Builder b = rig.builder();
  Value sum = b.load(Type::kI32, b.draw_ptr(), 4);
  sum = b.iadd(sum, b.load(Type::kI32, b.thread_ptr(), 0));
  sum = b.iadd(sum, b.load(Type::kI32, b.prim_ptr(), 0));
  Rig::put(b, b.iadd(sum, b.lane()));
  rig.waves.resize(3);
  const uint32_t draw[2] = {0, 1000}, first = 10, second = 20;
  uint32_t thread = 100;
  const PrimRecord prims[] = {{&first, 0, 1}, {&second, 1, 2}};
  run(rig.kernel, Mode::kF32, draw, &thread, prims, 2, rig.waves.data());
  EXPECT_EQ(rig.waves[0].cell[15], 1125u);
  EXPECT_EQ(rig.waves[1].cell[0], 1120u);
  EXPECT_EQ(rig.waves[2].cell[0], 1120u);
}

TEST(Eval, QuadSwizzleStaysInItsQuad) {
  Rig rig;
  Builder b = rig.builder();
  Rig::put(b, b.quad_swizzle(b.lane(), 0b00'01'10'11));  // lane i gets lane 3 - i
  rig.run();
  for (uint32_t l = 0; l < kLanes; ++l) EXPECT_EQ(rig.waves[0].cell[l], (l & ~3u) + 3 - (l & 3));
}

TEST(Eval, UnpackMaskGivesEachLaneItsBit) {
  Rig rig;
  Builder b = rig.builder();
  Rig::put(b, b.convert(ir::Op::kZExt, Type::kI32, b.unpack_mask(b.i32(0xA5C3))));
  rig.run();
  for (uint32_t l = 0; l < kLanes; ++l) EXPECT_EQ(rig.waves[0].cell[l], 0xA5C3u >> l & 1);
}

TEST(Eval, AtomicsActLaneByLane) {
  struct {
    ir::AtomicOp op;
    uint32_t start, value, comparand, expected;  // lanes 0 and 1 apply `value` in turn
  } const cases[] = {
      {ir::AtomicOp::kAdd, 5, 3, 0, 11},
      {ir::AtomicOp::kAnd, 0xFF, 0x0F, 0, 0x0F},
      {ir::AtomicOp::kOr, 1, 6, 0, 7},
      {ir::AtomicOp::kXor, 1, 6, 0, 1},
      {ir::AtomicOp::kSMin, 5, 0xFFFFFFFF, 0, 0xFFFFFFFF},
      {ir::AtomicOp::kSMax, 5, 0xFFFFFFFF, 0, 5},
      {ir::AtomicOp::kUMin, 5, 0xFFFFFFFF, 0, 5},
      {ir::AtomicOp::kUMax, 5, 0xFFFFFFFF, 0, 0xFFFFFFFF},
      {ir::AtomicOp::kExchange, 5, 9, 0, 9},
      {ir::AtomicOp::kFAdd, 0x3f800000, 0x40000000, 0, 0x40a00000},
      {ir::AtomicOp::kFAdd, 0x7f800000, 0xff800000, 0, 0x7fc00000},
      {ir::AtomicOp::kCompareExchange, 5, 9, 5, 9},
      {ir::AtomicOp::kCompareExchange, 5, 9, 6, 5},
  };
  for (const auto& c : cases) {
    Rig rig;
    Builder b = rig.builder();
    const Value comparand = c.op == ir::AtomicOp::kCompareExchange ? b.i32(c.comparand) : Value{};
    const Value old = b.atomic(c.op, {.base = b.wave_ptr(), .offset = b.i32(4)}, b.i32(c.value), comparand);
    b.store({.base = b.wave_ptr(), .offset = b.i32(8), .lane_stride = 4}, old);
    rig.waves[0].mask = 3;
    rig.waves[0].cell[0] = c.start;
    rig.run();
    EXPECT_EQ(rig.waves[0].cell[0], c.expected) << static_cast<int>(c.op);
    EXPECT_EQ(rig.waves[0].cell[1], c.start);
  }
}

TEST(Eval, HighestLaneWinsWhereStoresMeet) {
  Rig rig;
  rig.waves[0].mask = 0x0fff;
  Builder b = rig.builder();
  b.store({.base = b.wave_ptr(), .offset = b.i32(4)}, b.lane());
  rig.run();
  EXPECT_EQ(rig.waves[0].cell[0], 11u);
}

TEST(Eval, DryRunTouchesNothingAndSeesItsOwnStores) {
  Rig rig;
  Builder b = rig.builder();
  Rig::put(b, b.iadd(b.lane(), b.i32(0x100)));
  Rig::put(b, b.iadd(Rig::cell(b), b.i32(1)));
  b.atomic(ir::AtomicOp::kAdd, {.base = b.wave_ptr(), .offset = b.i32(4)}, b.i32(2));
  const PrimRecord prim{nullptr, 0, 1};
  const auto written = dry_run(rig.kernel, nullptr, nullptr, &prim, 1, rig.waves.data());
  ASSERT_EQ(written.size(), 64u);
  EXPECT_EQ(rig.waves[0].cell[0], 0u);
  EXPECT_EQ(written[0].address, reinterpret_cast<uint64_t>(&rig.waves[0].cell[0]));
  rig.run();
  for (size_t i = 0; i < written.size(); ++i) {
    EXPECT_EQ(written[i].value, reinterpret_cast<const uint8_t*>(rig.waves[0].cell)[i]) << i;
  }
  EXPECT_EQ(rig.waves[0].cell[0], 0x101u + 32);
  EXPECT_EQ(rig.waves[0].cell[1], 0x102u);
}

TEST(Eval, FlushToZeroOfTheCallerDoesNotMatter) {
  Rig rig;
  Builder b = rig.builder();
  Rig::put(b, b.fmul(Rig::cell(b, Type::kF32), b.f32(0.5)));
  rig.waves[0].cell[0] = 0x00000004;  // a denormal
  const unsigned saved = _mm_getcsr();
  _mm_setcsr(saved | 0x8040);  // FTZ, DAZ
  rig.run();
  const unsigned after = _mm_getcsr();
  _mm_setcsr(saved);
  EXPECT_EQ(after & 0xffc0, (saved | 0x8040) & 0xffc0);
  EXPECT_EQ(rig.waves[0].cell[0], 0x00000002u);
}

TEST(Eval, TruthKeepsDoublesBetweenLoadAndStore) {
  Rig rig;
  Builder b = rig.builder();
  const Value big = b.f32(16777216);  // 2^24: adding 1 is lost in binary32
  const Value x = b.fsub(b.fadd(big, b.f32(1)), big);
  Rig::put(b, x);
  rig.run(Mode::kF32);
  EXPECT_EQ(rig.waves[0].cell[0], 0u);
  rig.run(Mode::kF64);
  EXPECT_EQ(rig.waves[0].cell[0], 0x3f800000u);
}

TEST(Eval, TruthKeepsNanPayloadsThatPassThrough) {
  Rig rig;
  Builder b = rig.builder();
  Rig::put(b, b.bitcast(Type::kF32, b.bitcast(Type::kI32, Rig::cell(b, Type::kF32))));
  rig.waves[0].cell[0] = 0x7f800001;
  rig.waves[0].cell[1] = 0xffc12345;
  rig.run(Mode::kF64);
  EXPECT_EQ(rig.waves[0].cell[0], 0x7f800001u);
  EXPECT_EQ(rig.waves[0].cell[1], 0xffc12345u);
}

// ---- subgroups and barriers -----------------------------------------------------------------------------------------------

TEST(Eval, ShuffleReadsActiveLanes) {
  Rig rig;
  rig.waves[0].mask = 0xfffb;  // not lane 2
  Builder b = rig.builder();
  Rig::put(b, b.shuffle(b.iadd(b.lane(), b.i32(100)), b.iadd(b.lane(), b.i32(1))));
  rig.run();
  for (uint32_t l = 0; l < kLanes; ++l) {
    const uint32_t from = (l + 1) % kLanes;
    EXPECT_EQ(rig.waves[0].cell[l], l == 2 || from == 2 ? 0 : 100 + from) << l;
  }
}

// The order that ir.h states, written out: sums of this series depend on it.
TEST(Eval, FloatReductionsHaveOneOrder) {
  const auto term = [](uint32_t l) { return 1.0f / static_cast<float>(3 * l + 1); };
  for (const ir::Scan scan : {ir::Scan::kReduce, ir::Scan::kInclusive, ir::Scan::kExclusive}) {
    Rig rig;
    rig.waves[0].mask = 0xffdf;
    Builder b = rig.builder();
    const Value x = b.op(ir::Op::kFDiv, Type::kF32,
                         {b.f32(1), b.convert(ir::Op::kUToF, Type::kF32, b.iadd(b.imul(b.lane(), b.i32(3)), b.i32(1)))});
    Rig::put(b, b.reduce(ir::ReduceOp::kFAdd, scan, x));
    rig.run();
    std::array<float, kLanes> v;
    for (uint32_t l = 0; l < kLanes; ++l) v[l] = l == 5 ? -0.0f : term(l);
    if (scan == ir::Scan::kReduce) {
      for (uint32_t s : {8u, 4u, 2u, 1u}) {
        for (uint32_t l = 0; l < s; ++l) v[l] += v[l + s];
      }
      v.fill(v[0]);
    } else {
      for (uint32_t s : {1u, 2u, 4u, 8u}) {
        for (uint32_t l = kLanes; l-- > s;) v[l] = v[l - s] + v[l];
      }
      if (scan == ir::Scan::kExclusive) {
        std::copy_backward(v.begin(), v.end() - 1, v.end());
        v[0] = 0;
      }
    }
    for (uint32_t l = 0; l < kLanes; ++l) {
      if (l == 5) continue;
      EXPECT_EQ(rig.waves[0].cell[l], std::bit_cast<uint32_t>(v[l])) << l;
    }
  }
}

// Each wave writes its number, and behind the barrier reads the next one's; a loop whose length only the waves know has one, too.
TEST(Eval, BarriersOrderWaves) {
  constexpr uint32_t kWaves = 4, kTurns = 3;
  struct Record {
    uint32_t mask = 0xffff, index;
  };
  std::array<Record, kWaves> waves;
  for (uint32_t w = 0; w < kWaves; ++w) waves[w].index = w;
  std::array<uint32_t, kWaves> shared{};
  std::array<uint32_t, kWaves * kTurns> out{};
  struct Draw {
    uint32_t *shared, *out;
  } draw{shared.data(), out.data()};
  ir::Kernel kernel{.wave_stride_bytes = sizeof(Record)};
  Builder b(kernel);
  const Value index = b.load(Type::kI32, b.wave_ptr(), 4), shared_ptr = b.load(Type::kPtr, b.draw_ptr(), 0),
              out_ptr = b.load(Type::kPtr, b.draw_ptr(), 8);
  const Value next_index = b.and_(b.iadd(index, b.i32(1)), b.i32(kWaves - 1));
  const auto word = [&](Value base, Value i) { return ir::Address{.base = base, .offset = b.shl(i, b.i32(2))}; };
  b.loop({b.i32(0)}, [&](std::span<const Value> c) {
    b.store(word(shared_ptr, index), b.iadd(b.imul(index, b.i32(10)), c[0]));
    b.barrier();
    b.store(word(out_ptr, b.iadd(b.imul(c[0], b.i32(kWaves)), index)), b.load(Type::kI32, word(shared_ptr, next_index)));
    b.barrier();
    const Value turn = b.iadd(c[0], b.i32(1));
    return Builder::LoopStep{b.ult(turn, b.i32(kTurns)), {turn}};
  });
  ASSERT_EQ(ir::verify(kernel), "");
  const PrimRecord prim{nullptr, 0, kWaves};
  run(kernel, Mode::kF32, &draw, nullptr, &prim, 1, waves.data());
  for (uint32_t t = 0; t < kTurns; ++t) {
    for (uint32_t w = 0; w < kWaves; ++w) EXPECT_EQ(out[t * kWaves + w], (w + 1) % kWaves * 10 + t);
  }
}

}  // namespace
}  // namespace pineda::eval
