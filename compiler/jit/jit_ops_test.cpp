// Each operation on every ISA against the evaluator, over special values and seeded random ones; per lane, and uniform.
#include <bit>
#include <cmath>

#include "base/half.h"
#include "compiler/jit/test_rig.h"
#include "compiler/passes/passes.h"

namespace pineda::jit::test {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

constexpr uint32_t kSeed = 20240611;

struct OpWave {
  uint32_t mask = 0xffff;
  uint32_t reserved = 0;
  uint64_t out = 0;
  uint8_t in[3][kLanes * 8] = {};
};

constexpr Type kInts[] = {Type::kI8, Type::kI16, Type::kI32, Type::kI64};
constexpr Type kFloats[] = {Type::kF16, Type::kF32, Type::kF64};

std::vector<uint64_t> specials(Type t) {
  if (t == Type::kF32) {
    return {0x00000000, 0x80000000, 0x00000001, 0x80000001, 0x007fffff, 0x00800000, 0x3f800000, 0xbf800000, 0x3f7fffff,
            0x3f000000, 0xbf000000, 0x3fc00000, 0x40200000, 0x4b000001, 0xcb800001, 0x4effffff, 0x4f000000, 0xcf000000,
            0xcf000001, 0x4f7fffff, 0x4f800000, 0x7f7fffff, 0xff7fffff, 0x7f800000, 0xff800000, 0x7fc00000, 0xffc12345,
            0x7f800001, 0x33000000, 0x477ff000, 0x477fefff, 0x38800000, 0x387fffff, 0x33000001, 0x5f000000, 0xdf000000};
  }
  if (t == Type::kF16) {
    return {0x0000, 0x8000, 0x0001, 0x8001, 0x03ff, 0x0400, 0x3c00, 0xbc00, 0x3800, 0x3e00,
            0x7bff, 0xfbff, 0x7c00, 0xfc00, 0x7e00, 0x7c01, 0xfe55, 0x5bff, 0x57f8, 0xd801};
  }
  if (t == Type::kF64) {
    std::vector<uint64_t> out;
    for (double d : {0.0,
                     -0.0,
                     5e-324,
                     2.2250738585072014e-308,
                     1.0,
                     -1.0,
                     1.5,
                     2.5,
                     -0.5,
                     2147483647.0,
                     2147483648.0,
                     -2147483648.5,
                     4294967295.5,
                     4294967296.0,
                     9.3e18,
                     -9.3e18,
                     1.9e19,
                     1e300,
                     -1e-300,
                     INFINITY * 1.0,
                     -INFINITY * 1.0,
                     65519.99999999999,
                     65520.0,
                     5.960464477539063e-08,
                     2.98023223876953125e-08,
                     2.9802322387695316e-08,
                     1e-46,
                     1.7e38,
                     3.4028235677973366e38,
                     1.0000000596046448,
                     0.333251953125000111}) {
      out.push_back(std::bit_cast<uint64_t>(d));
    }
    out.push_back(0x7ff8000000000000);
    out.push_back(0xfff0000000000001);
    return out;
  }
  const uint32_t bits = 8 * ir::size_bytes(t);
  const uint64_t top = 1ull << (bits - 1), all = top | (top - 1);
  return {0,  1,  2,  3,   5,   7,       8,       10,  15,      16,      31,      32,
          33, 63, 64, 100, top, top - 1, top + 1, all, all - 1, all - 6, top / 2, 0x55555555aaaaaaaa & all};
}

// Random bits, but for floats half of them with exponents near each other, where rounding and cancellation happen.
uint64_t random_value(Type t, std::mt19937_64& rng) {
  const uint64_t bits = rng();
  if (t == Type::kF32 && (bits >> 63) != 0) return (bits & 0x807fffff) | (0x7au + (bits >> 40 & 15)) << 23;
  if (t == Type::kF64 && (bits & 1) != 0) return (bits & 0x800fffffffffffff) | (0x3e8ull + (rng() & 63)) << 52;
  if (ir::is_int(t) && (bits >> 62) == 0) return bits & 0xff;  // small: quotients that are not 0
  return bits;
}

// Every combination of the special values, then random ones, 16 to a wave.
std::vector<OpWave> inputs(const std::array<Type, 3>& types, uint32_t operands) {
  std::vector<OpWave> waves;
  uint32_t lane = kLanes;
  const auto put = [&](const std::array<uint64_t, 3>& values) {
    if (lane == kLanes) {
      waves.emplace_back();
      lane = 0;
    }
    for (uint32_t i = 0; i < operands; ++i) {
      const uint32_t size = ir::size_bytes(types[i]);
      std::memcpy(waves.back().in[i] + lane * size, &values[i], size);
    }
    ++lane;
  };
  std::array<std::vector<uint64_t>, 3> s;
  for (uint32_t i = 0; i < 3; ++i) s[i] = i < operands ? specials(types[i]) : std::vector<uint64_t>{0};
  for (uint64_t a : s[0]) {
    for (uint64_t b : s[1]) {
      for (uint64_t c : s[2]) put({a, b, c});
    }
  }
  std::mt19937_64 rng(kSeed);
  for (uint32_t n = 0; n < 4096; ++n)
    put({random_value(types[0], rng), random_value(types[1], rng), random_value(types[2], rng)});
  return waves;
}

struct Case {
  Op op;
  Type result;
  std::array<Type, 3> operand{};
};

// One kernel computes all cases that share operand types; the result of case i of wave w is at out[w][i].
class OpRig {
 public:
  OpRig(std::vector<Case> cases, bool uniform) : cases_(std::move(cases)), uniform_(uniform) {
    operands_ = ir::op_info(cases_[0].op).operands;
    waves_ = inputs(cases_[0].operand, operands_);
    if (uniform_ && waves_.size() > 400) waves_.resize(400);
    out_.resize(waves_.size() * wave_bytes());
    for (size_t w = 0; w < waves_.size(); ++w) waves_[w].out = reinterpret_cast<uint64_t>(out_.data() + w * wave_bytes());
    build();
  }

  void check() {
    const Call call{.prims = {{nullptr, 0, static_cast<uint32_t>(waves_.size())}},
                    .waves = waves_.data(),
                    .memory = out_.data(),
                    .memory_bytes = out_.size()};
    expect_same(kernel_, call, [&](size_t byte) { return describe(byte); });
  }

 private:
  static constexpr uint32_t kSlotBytes = kLanes * 8;
  size_t wave_bytes() const { return cases_.size() * kSlotBytes; }

  void build() {
    kernel_.name = "ops";
    kernel_.wave_stride_bytes = sizeof(OpWave);
    Builder b(kernel_);
    std::array<Value, 3> in{};
    for (uint32_t i = 0; i < operands_; ++i) {
      const Type t = cases_[0].operand[i];
      in[i] = t == Type::kB1
                  ? b.ult(b.lane(), b.i32(5))
                  : b.load(t, {.base = b.wave_ptr(),
                               .offset = b.i32(static_cast<uint32_t>(offsetof(OpWave, in) + i * sizeof(OpWave::in[0]))),
                               .lane_stride = uniform_ ? 0 : ir::size_bytes(t)});
    }
    const Value out = b.load(Type::kPtr, b.wave_ptr(), offsetof(OpWave, out));
    for (size_t i = 0; i < cases_.size(); ++i) {
      const Case& c = cases_[i];
      Value r = operands_ == 1   ? b.op(c.op, c.result, {in[0]})
                : operands_ == 2 ? b.op(c.op, c.result, {in[0], in[1]})
                                 : b.op(c.op, c.result, {in[0], in[1], in[2]});
      if (c.result == Type::kB1) r = b.convert(Op::kZExt, Type::kI8, r);
      b.store({.base = out, .offset = b.i32(static_cast<uint32_t>(i * kSlotBytes)), .lane_stride = ir::size_bytes(b.type(r))}, r);
    }
    if (uniform_) passes::rates(kernel_);
  }

  std::string describe(size_t byte) const {
    const size_t wave = byte / wave_bytes(), index = byte % wave_bytes() / kSlotBytes;
    const Case& c = cases_[index];
    const size_t size = std::max(1u, ir::size_bytes(c.result)), lane = byte % kSlotBytes / size;
    std::string text = std::string("in ") + ir::op_info(c.op).name + " -> " + ir::type_name(c.result) + ", wave " +
                       std::to_string(wave) + " lane " + std::to_string(lane) + ":";
    for (uint32_t i = 0; i < operands_; ++i) {
      const uint32_t bytes = ir::size_bytes(c.operand[i]);
      uint64_t bits = 0;
      std::memcpy(&bits, waves_[wave].in[i] + (uniform_ ? 0 : lane) * bytes, bytes);
      char hex[32];
      std::snprintf(hex, sizeof hex, " %s %llx", ir::type_name(c.operand[i]), static_cast<unsigned long long>(bits));
      text += hex;
    }
    return text;
  }

  std::vector<Case> cases_;
  bool uniform_;
  uint32_t operands_ = 0;
  std::vector<OpWave> waves_;
  std::vector<uint8_t> out_;
  ir::Kernel kernel_;
};

void check_cases(const std::vector<Case>& cases) {
  for (bool uniform : {false, true}) {
    SCOPED_TRACE(uniform ? "uniform" : "per lane");
    OpRig(cases, uniform).check();
  }
}

// The ops from first to last of ops.inc that take `operands` operands, all of type t.
std::vector<Case> same_type_cases(Op first, Op last, uint32_t operands, Type t) {
  std::vector<Case> cases;
  for (int i = static_cast<int>(first); i <= static_cast<int>(last); ++i) {
    const Op op = static_cast<Op>(i);
    if (ir::op_info(op).operands != operands || (op == Op::kMAdd16 && t != Type::kI32)) continue;
    const bool compare = ir::op_info(op).rule == ir::TypeRule::kCompare;
    cases.push_back({op, compare ? Type::kB1 : t, {t, t, t}});
  }
  return cases;
}

TEST(JitOps, Integers) {
  for (Type t : kInts) {
    SCOPED_TRACE(ir::type_name(t));
    check_cases(same_type_cases(Op::kIAdd, Op::kSLe, 2, t));
    check_cases(same_type_cases(Op::kIAdd, Op::kSLe, 1, t));
  }
}

TEST(JitOps, Floats) {
  for (Type t : kFloats) {
    SCOPED_TRACE(ir::type_name(t));
    check_cases(same_type_cases(Op::kFAdd, Op::kFLe, 2, t));
    check_cases(same_type_cases(Op::kFAdd, Op::kFLe, 1, t));
  }
}

TEST(JitOps, FusedMultiplyAdd) {
  for (Type t : kFloats) {
    SCOPED_TRACE(ir::type_name(t));
    check_cases(same_type_cases(Op::kFMa, Op::kFMa, 3, t));
  }
}

TEST(JitOps, FloatToInteger) {
  for (Type from : kFloats) {
    SCOPED_TRACE(ir::type_name(from));
    std::vector<Case> cases;
    for (Type to : kInts) {
      cases.push_back({Op::kFToS, to, {from}});
      cases.push_back({Op::kFToU, to, {from}});
    }
    check_cases(cases);
  }
}

TEST(JitOps, IntegerToFloat) {
  for (Type from : kInts) {
    SCOPED_TRACE(ir::type_name(from));
    std::vector<Case> cases;
    for (Type to : kFloats) {
      cases.push_back({Op::kSToF, to, {from}});
      cases.push_back({Op::kUToF, to, {from}});
    }
    check_cases(cases);
  }
}

TEST(JitOps, FloatToFloat) {
  for (Type from : kFloats) {
    SCOPED_TRACE(ir::type_name(from));
    std::vector<Case> cases;
    for (Type to : kFloats) {
      if (to != from) cases.push_back({Op::kFConvert, to, {from}});
    }
    check_cases(cases);
  }
}

TEST(JitOps, IntegerWidths) {
  for (Type from : kInts) {
    SCOPED_TRACE(ir::type_name(from));
    std::vector<Case> cases;
    for (Type to : kInts) {
      if (ir::size_bytes(to) < ir::size_bytes(from)) cases.push_back({Op::kTrunc, to, {from}});
      if (ir::size_bytes(to) <= ir::size_bytes(from)) continue;
      cases.push_back({Op::kZExt, to, {from}});
      cases.push_back({Op::kSExt, to, {from}});
    }
    check_cases(cases);
  }
}

TEST(JitOps, Booleans) {
  std::vector<Case> widen, logic;
  for (Type to : kInts) {
    widen.push_back({Op::kZExt, to, {Type::kB1}});
    widen.push_back({Op::kSExt, to, {Type::kB1}});
  }
  OpRig(widen, false).check();
  for (Op op : {Op::kAnd, Op::kOr, Op::kXor}) logic.push_back({op, Type::kB1, {Type::kB1, Type::kB1}});
  OpRig(logic, false).check();
  OpRig({{Op::kNot, Type::kB1, {Type::kB1}}}, false).check();
}

// Every binary16 value, and the neighbourhood of every rounding boundary, through the conversions that differ most between ISAs.
TEST(JitOps, EveryHalf) {
  std::vector<OpWave> waves(65536 / kLanes);
  std::vector<uint32_t> out(65536 * 4);
  for (uint32_t i = 0; i < 65536; ++i) {
    OpWave& wave = waves[i / kLanes];
    const uint32_t lane = i % kLanes;
    const auto half = static_cast<uint16_t>(i);
    std::memcpy(wave.in[0] + lane * 2, &half, 2);
    // 13 bits below binary16's last place: a tie or next to one
    const uint32_t float_bits = std::bit_cast<uint32_t>(half_to_float(half)) + 0x1000 + (i * 2654435761u >> 30) - 1;
    std::memcpy(wave.in[1] + lane * 4, &float_bits, 4);
    wave.out = reinterpret_cast<uint64_t>(out.data() + (i & ~15u) * 4);
  }
  ir::Kernel kernel;
  kernel.name = "halves";
  kernel.wave_stride_bytes = sizeof(OpWave);
  Builder b(kernel);
  const auto in = [&](Type t, uint32_t i) {
    return b.load(t, {.base = b.wave_ptr(),
                      .offset = b.i32(static_cast<uint32_t>(offsetof(OpWave, in) + i * 128)),
                      .lane_stride = ir::size_bytes(t)});
  };
  const Value base = b.load(Type::kPtr, b.wave_ptr(), offsetof(OpWave, out));
  const Value wide = b.convert(Op::kFConvert, Type::kF32, in(Type::kF16, 0));
  b.store({.base = base, .lane_stride = 4}, wide);
  b.store({.base = base, .offset = b.i32(64), .lane_stride = 2}, b.convert(Op::kFConvert, Type::kF16, wide));
  b.store({.base = base, .offset = b.i32(128), .lane_stride = 2}, b.convert(Op::kFConvert, Type::kF16, in(Type::kF32, 1)));
  const Call call{.prims = {{nullptr, 0, static_cast<uint32_t>(waves.size())}},
                  .waves = waves.data(),
                  .memory = out.data(),
                  .memory_bytes = out.size() * 4};
  expect_same(kernel, call);
}

TEST(JitOps, TranscendentalsAreRefused) {
  ir::Kernel kernel;
  kernel.name = "sine";
  kernel.wave_stride_bytes = sizeof(OpWave);
  Builder b(kernel);
  b.store({.base = b.wave_ptr(), .offset = b.i32(16), .lane_stride = 4}, b.fsin(b.f32(1)));
  const Compiled compiled(kernel, {});
  EXPECT_NE(compiled.code.error.find("fsin"), std::string::npos) << compiled.code.error;
}

}  // namespace
}  // namespace pineda::jit::test
