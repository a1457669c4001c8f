// Every lane-wise operation of ops.inc against expected values that were written down by hand from its definition, run by the
// evaluator and by passes/fold. The last test makes sure that no operation is forgotten.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <span>

#include "base/half.h"
#include "compiler/eval/eval.h"
#include "compiler/ir/builder.h"
#include "compiler/ir/semantics.h"
#include "compiler/passes/passes.h"

namespace pineda::eval {
namespace {

using ir::Op;
using ir::Type;
using ir::Value;

constexpr Type I8 = Type::kI8, I16 = Type::kI16, I32 = Type::kI32, I64 = Type::kI64, B1 = Type::kB1;
constexpr Type F16 = Type::kF16, F32 = Type::kF32, F64 = Type::kF64;

constexpr uint64_t f(float v) { return std::bit_cast<uint32_t>(v); }
constexpr uint64_t d(double v) { return std::bit_cast<uint64_t>(v); }
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr uint64_t kNan = 0x7FC00000, kSignedNan = 0xFFC12345, kAnyNan = ~0ull;  // kAnyNan: expected, whatever the payload

struct Case {
  Op op;
  Type result, operand;
  std::vector<uint64_t> in;  // bits in memory
  uint64_t expected;
};

const Case kIntegerCases[] = {
    {Op::kIAdd, I8, I8, {200, 100}, 44},
    {Op::kIAdd, I64, I64, {~0ull, 2}, 1},
    {Op::kISub, I16, I16, {3, 5}, 0xFFFE},
    {Op::kIMul, I32, I32, {0x10001, 0x10001}, 0x20001},
    {Op::kIMul, I8, I8, {0xFF, 0xFF}, 1},
    {Op::kUMulHi, I32, I32, {0xFFFFFFFF, 0xFFFFFFFF}, 0xFFFFFFFE},
    {Op::kUMulHi, I64, I64, {1ull << 63, 6}, 3},
    {Op::kUMulHi, I8, I8, {0xFF, 2}, 1},
    {Op::kSMulHi, I32, I32, {0xFFFFFFFF, 0xFFFFFFFF}, 0},
    {Op::kSMulHi, I32, I32, {0x80000000, 2}, 0xFFFFFFFF},
    {Op::kSMulHi, I64, I64, {1ull << 63, 1ull << 63}, 1ull << 62},
    {Op::kMAdd16, I32, I32, {0x0003FFFE, 0x00050007}, 1},
    {Op::kMAdd16, I32, I32, {0x80008000, 0x80008000}, 0x80000000},
    {Op::kUDiv, I32, I32, {7, 2}, 3},
    {Op::kUDiv, I32, I32, {7, 0}, 0xFFFFFFFF},
    {Op::kUDiv, I8, I8, {7, 0}, 0xFF},
    {Op::kSDiv, I32, I32, {0xFFFFFFF9, 2}, 0xFFFFFFFD},  // -7 / 2 = -3
    {Op::kSDiv, I32, I32, {5, 0}, 0xFFFFFFFF},
    {Op::kSDiv, I32, I32, {0x80000000, 0xFFFFFFFF}, 0x80000000},
    {Op::kSDiv, I16, I16, {0x8000, 0xFFFF}, 0x8000},
    {Op::kSDiv, I64, I64, {1ull << 63, ~0ull}, 1ull << 63},
    {Op::kURem, I32, I32, {7, 4}, 3},
    {Op::kURem, I32, I32, {7, 0}, 7},
    {Op::kSRem, I32, I32, {0xFFFFFFF9, 4}, 0xFFFFFFFD},  // -7 % 4 = -3
    {Op::kSRem, I32, I32, {7, 0xFFFFFFFC}, 3},           // 7 % -4 = 3
    {Op::kSRem, I32, I32, {0x80000000, 0xFFFFFFFF}, 0},
    {Op::kSRem, I32, I32, {0xFFFFFFF9, 0}, 0xFFFFFFF9},
    {Op::kShl, I32, I32, {1, 33}, 2},
    {Op::kShl, I8, I8, {0x81, 1}, 2},
    {Op::kLShr, I32, I32, {0x80000000, 31}, 1},
    {Op::kLShr, I32, I32, {0x80000000, 32}, 0x80000000},
    {Op::kAShr, I32, I32, {0x80000000, 31}, 0xFFFFFFFF},
    {Op::kAShr, I16, I16, {0x8000, 20}, 0xF800},
    {Op::kAnd, I32, I32, {0xF0F0, 0xFF00}, 0xF000},
    {Op::kOr, I32, I32, {0xF0F0, 0xFF00}, 0xFFF0},
    {Op::kXor, I32, I32, {0xF0F0, 0xFF00}, 0x0FF0},
    {Op::kAnd, B1, B1, {1, 0}, 0},
    {Op::kOr, B1, B1, {1, 0}, 1},
    {Op::kXor, B1, B1, {1, 1}, 0},
    {Op::kNot, I8, I8, {0x0F}, 0xF0},
    {Op::kNot, B1, B1, {1}, 0},
    {Op::kSMin, I32, I32, {0xFFFFFFFF, 1}, 0xFFFFFFFF},
    {Op::kSMax, I32, I32, {0xFFFFFFFF, 1}, 1},
    {Op::kUMin, I32, I32, {0xFFFFFFFF, 1}, 1},
    {Op::kUMax, I32, I32, {0xFFFFFFFF, 1}, 0xFFFFFFFF},
    {Op::kClz, I32, I32, {1}, 31},
    {Op::kClz, I16, I16, {0}, 16},
    {Op::kCtz, I32, I32, {8}, 3},
    {Op::kCtz, I64, I64, {0}, 64},
    {Op::kPopCount, I32, I32, {0xF00F}, 8},
    {Op::kBitReverse, I32, I32, {0x00000006}, 0x60000000},
    {Op::kBitReverse, I8, I8, {0x01}, 0x80},
    {Op::kIEq, B1, I32, {5, 5}, 1},
    {Op::kINe, B1, I32, {5, 5}, 0},
    {Op::kULt, B1, I32, {1, 0xFFFFFFFF}, 1},
    {Op::kULe, B1, I32, {2, 2}, 1},
    {Op::kSLt, B1, I32, {1, 0xFFFFFFFF}, 0},
    {Op::kSLe, B1, I16, {0xFFFF, 1}, 1},
    {Op::kZExt, I64, I32, {0x80000000}, 0x80000000},
    {Op::kZExt, I32, B1, {1}, 1},
    {Op::kSExt, I64, I32, {0x80000000}, 0xFFFFFFFF80000000},
    {Op::kSExt, I16, I8, {0x7F}, 0x7F},
    {Op::kSExt, I32, B1, {1}, 0xFFFFFFFF},
    {Op::kTrunc, I8, I32, {0x1234}, 0x34},
    {Op::kUnpackMask, B1, I32, {1}, 1},  // lane 0; the other lanes are in UnpackMaskGivesEachLaneItsBit
};

const Case kFloatCases[] = {
    {Op::kFAdd, F32, F32, {f(16777216), f(1)}, f(16777216)},  // tie to even
    {Op::kFAdd, F32, F32, {f(16777218), f(1)}, f(16777220)},
    {Op::kFAdd, F32, F32, {f(kInf), f(-kInf)}, kAnyNan},
    {Op::kFAdd, F32, F32, {1, 1}, 2},  // denormals
    {Op::kFAdd, F64, F64, {d(0.1), d(0.2)}, 0x3FD3333333333334},
    {Op::kFAdd, F16, F16, {0x6800, 0x3C00}, 0x6800},  // 2048 + 1 ties to 2048
    {Op::kFSub, F32, F32, {f(0), f(0)}, 0},
    {Op::kFSub, F32, F32, {f(-0.0f), f(0)}, 0x80000000},
    {Op::kFMul, F32, F32, {f(3.4028235e38f), f(2)}, f(kInf)},
    {Op::kFMul, F32, F32, {f(0), f(kInf)}, kAnyNan},
    {Op::kFMul, F32, F32, {f(0.1f), f(0.1f)}, 0x3C23D70B},
    {Op::kFDiv, F32, F32, {f(1), f(3)}, 0x3EAAAAAB},
    {Op::kFDiv, F32, F32, {f(-1), f(0)}, f(-kInf)},
    {Op::kFDiv, F16, F16, {0x3C00, 0x4200}, 0x3555},
    {Op::kFMa, F32, F32, {0x3F800003, 0x3F800003, f(-1)}, 0x35400002},  // (1 + 3e)^2 - 1 = 6e + 9e^2, e = 2^-23
    {Op::kFMa, F64, F64, {d(0.1), d(10), d(-1)}, d(0x1p-54)},           // 10 * 0.1's error
    {Op::kFMa, F16, F16, {0x3C03, 0x3C03, 0xBC00}, 0x1E02},
    {Op::kFSqrt, F32, F32, {f(2)}, 0x3FB504F3},
    {Op::kFSqrt, F32, F32, {f(-0.0f)}, 0x80000000},
    {Op::kFSqrt, F32, F32, {f(-1)}, kAnyNan},
    {Op::kFNeg, F32, F32, {0}, 0x80000000},
    {Op::kFNeg, F16, F16, {0x3C00}, 0xBC00},
    {Op::kFAbs, F32, F32, {f(-2)}, f(2)},
    {Op::kFMin, F32, F32, {f(1), f(2)}, f(1)},
    {Op::kFMin, F32, F32, {f(1), kNan}, f(1)},
    {Op::kFMin, F32, F32, {kNan, f(1)}, kAnyNan},
    {Op::kFMin, F32, F32, {0, 0x80000000}, 0},
    {Op::kFMax, F32, F32, {f(1), f(2)}, f(2)},
    {Op::kFMax, F32, F32, {f(1), kNan}, f(1)},
    {Op::kFMax, F32, F32, {0x80000000, 0}, 0x80000000},
    {Op::kFFloor, F32, F32, {f(-1.5f)}, f(-2)},
    {Op::kFCeil, F32, F32, {f(-0.5f)}, 0x80000000},
    {Op::kFTrunc, F32, F32, {f(-1.5f)}, f(-1)},
    {Op::kFTrunc, F32, F32, {f(1e30f)}, f(1e30f)},
    {Op::kFRoundEven, F32, F32, {f(2.5f)}, f(2)},
    {Op::kFRoundEven, F32, F32, {f(3.5f)}, f(4)},
    {Op::kFRoundEven, F16, F16, {0x3E00}, 0x4000},
    {Op::kFCanon, F32, F32, {kSignedNan}, kNan},
    {Op::kFCanon, F32, F32, {0x7F800001}, kNan},
    {Op::kFCanon, F32, F32, {f(-1)}, f(-1)},
    {Op::kFCanon, F16, F16, {0xFE01}, 0x7E00},
    {Op::kFCanon, F64, F64, {0xFFF8000000000001}, 0x7FF8000000000000},
    {Op::kFEq, B1, F32, {0, 0x80000000}, 1},
    {Op::kFEq, B1, F32, {kNan, kNan}, 0},
    {Op::kFNe, B1, F32, {kNan, kNan}, 1},
    {Op::kFNe, B1, F32, {f(1), f(1)}, 0},
    {Op::kFLt, B1, F32, {f(1), f(2)}, 1},
    {Op::kFLt, B1, F32, {f(1), kNan}, 0},
    {Op::kFLe, B1, F32, {f(2), f(2)}, 1},
    {Op::kFLe, B1, F64, {d(-1), d(-2)}, 0},
};

const Case kConversionCases[] = {
    {Op::kFToS, I32, F32, {f(-1.9f)}, 0xFFFFFFFF},
    {Op::kFToS, I32, F32, {f(3e9f)}, 0x7FFFFFFF},
    {Op::kFToS, I32, F32, {f(-kInf)}, 0x80000000},
    {Op::kFToS, I32, F32, {kSignedNan}, 0},
    {Op::kFToS, I8, F32, {f(200)}, 0x7F},
    {Op::kFToS, I64, F64, {d(-9.3e18)}, 1ull << 63},
    {Op::kFToS, I16, F16, {0xC900}, 0xFFF6},  // -10
    {Op::kFToU, I32, F32, {f(-1)}, 0},
    {Op::kFToU, I32, F32, {f(4294967040.0f)}, 0xFFFFFF00},
    {Op::kFToU, I32, F32, {f(4294967296.0f)}, 0xFFFFFFFF},
    {Op::kFToU, I32, F32, {kNan}, 0},
    {Op::kFToU, I8, F32, {f(255.9f)}, 0xFF},
    {Op::kFToU, I64, F32, {f(9223372036854775808.0f)}, 1ull << 63},
    {Op::kFToU, I64, F32, {f(kInf)}, ~0ull},
    {Op::kSToF, F32, I32, {0xFFFFFFFF}, f(-1)},
    {Op::kSToF, F32, I32, {0x7FFFFFFF}, f(2147483648.0f)},
    {Op::kSToF, F32, I64, {0x8000008000000001}, 0xDEFFFFFF},  // -(2^63 - 2^39 - 1): above the midpoint
    {Op::kSToF, F64, I8, {0x80}, d(-128)},
    {Op::kSToF, F16, I32, {0xFFFF0000}, 0xFC00},  // -65536 overflows
    {Op::kUToF, F32, I32, {0xFFFFFFFF}, f(4294967296.0f)},
    {Op::kUToF, F32, I64, {0x8000008000000001}, 0x5F000001},  // just above the midpoint of two floats: one rounding, up
    {Op::kUToF, F64, I64, {~0ull}, d(18446744073709551616.0)},
    {Op::kUToF, F16, I16, {2049}, 0x6800},
    {Op::kFConvert, F16, F32, {f(65519.996f)}, 0x7BFF},
    {Op::kFConvert, F16, F32, {f(65520)}, 0x7C00},
    {Op::kFConvert, F16, F64, {d(1.0004882812500003)}, 0x3C01},  // above the midpoint in double, on it in binary32
    {Op::kFConvert, F32, F16, {0x0001}, 0x33800000},
    {Op::kFConvert, F32, F64, {d(1e300)}, f(kInf)},
    {Op::kFConvert, F32, F64, {d(1e-46)}, 0},
    {Op::kFConvert, F64, F32, {f(0.1f)}, 0x3FB99999A0000000},
    {Op::kBitcast, I32, F32, {0x7F800001}, 0x7F800001},
    {Op::kBitcast, F32, I32, {0xFFC12345}, 0xFFC12345},
    {Op::kBitcast, F64, I64, {d(1)}, d(1)},
    {Op::kBitcast, I16, F16, {0x3C00}, 0x3C00},
    {Op::kPtrAdd, Type::kPtr, Type::kPtr, {0x1000, ~0ull}, 0xFFF},  // second operand: I64, see make()
};

// Correctly rounded to binary32 from at least 20 digits.
const Case kTranscendentalCases[] = {
    {Op::kFSin, F32, F32, {f(0.5f)}, f(0.47942553860420300027f)},
    {Op::kFCos, F32, F32, {f(0.5f)}, f(0.87758256189037271612f)},
    {Op::kFTan, F32, F32, {f(0.5f)}, f(0.54630248984379051326f)},
    {Op::kFAsin, F32, F32, {f(0.5f)}, f(0.52359877559829887308f)},
    {Op::kFAcos, F32, F32, {f(0.5f)}, f(1.0471975511965977462f)},
    {Op::kFAtan, F32, F32, {f(0.5f)}, f(0.46364760900080611621f)},
    {Op::kFAtan2, F32, F32, {f(1), f(-1)}, f(2.3561944901923449288f)},
    {Op::kFSinh, F32, F32, {f(0.5f)}, f(0.52109530549374736162f)},
    {Op::kFCosh, F32, F32, {f(0.5f)}, f(1.1276259652063807852f)},
    {Op::kFTanh, F32, F32, {f(0.5f)}, f(0.46211715726000975850f)},
    {Op::kFAsinh, F32, F32, {f(0.5f)}, f(0.48121182505960344750f)},
    {Op::kFAcosh, F32, F32, {f(1.5f)}, f(0.96242365011920689500f)},
    {Op::kFAtanh, F32, F32, {f(0.5f)}, f(0.54930614433405484570f)},
    {Op::kFRsqrt, F32, F32, {f(0.25f)}, f(2)},
    {Op::kFExp2, F32, F32, {f(0.5f)}, f(1.4142135623730950488f)},
    {Op::kFLog2, F32, F32, {f(3)}, f(1.5849625007211561815f)},
    {Op::kFLog2Coarse, F32, F32, {f(3)}, f(1.5849625007211561815f)},
    {Op::kFExp, F32, F32, {f(1)}, f(2.7182818284590452354f)},
    {Op::kFLog, F32, F32, {f(2)}, f(0.69314718055994530942f)},
    {Op::kFPow, F32, F32, {f(2), f(0.5f)}, f(1.4142135623730950488f)},
};

struct Record {
  uint32_t mask = 1;
  uint32_t reserved = 0;
  uint64_t in[3] = {};
  uint64_t out = 0;
};

// Loads the operands from the wave's record, or takes them as constants, and stores the result there.
ir::Kernel make(const Case& c, bool constants) {
  ir::Kernel kernel;
  kernel.wave_stride_bytes = sizeof(Record);
  ir::Builder b(kernel);
  const auto operand = [&](uint32_t i) {
    const Type type = c.op == Op::kPtrAdd && i == 1 ? I64 : c.operand;
    const Type stored = type == B1 ? I8 : type;
    const auto offset = static_cast<uint32_t>(offsetof(Record, in) + 8 * i);
    Value v;
    if (constants) {
      v = ir::is_float(type) ? b.fconst(type, std::bit_cast<double>(ir::const_imm(type, c.in[i], ir::Floats::kNative)))
                             : b.constant(stored, c.in[i]);
    } else {
      v = b.load(stored, b.wave_ptr(), offset);
    }
    return type == B1 ? b.ine(v, b.constant(I8, 0)) : v;
  };
  std::array<Value, 3> in;
  for (uint32_t i = 0; i < c.in.size(); ++i) in[i] = operand(i);
  Value out = c.in.size() == 1   ? b.op(c.op, c.result, {in[0]})
              : c.in.size() == 2 ? b.op(c.op, c.result, {in[0], in[1]})
                                 : b.op(c.op, c.result, {in[0], in[1], in[2]});
  if (c.result == B1) out = b.convert(Op::kZExt, I8, out);
  // not Builder::store(), which would canonicalise
  b.op(Op::kStore, Type::kVoid, {b.wave_ptr(), b.i32(offsetof(Record, out)), out});
  return kernel;
}

void expect_result(const Case& c, const ir::Kernel& kernel, Mode mode, const char* how) {
  ASSERT_EQ(ir::verify(kernel), "");
  Record record;
  std::copy(c.in.begin(), c.in.end(), record.in);
  const PrimRecord prim{nullptr, 0, 1};
  run(kernel, mode, nullptr, nullptr, &prim, 1, &record);
  const std::string what = std::string(ir::op_info(c.op).name) + " " + ir::type_name(c.result) + " " + how;
  if (c.expected == kAnyNan && ir::is_float(c.result)) {
    EXPECT_TRUE(std::isnan(std::bit_cast<float>(static_cast<uint32_t>(record.out)))) << what;
  } else {
    EXPECT_EQ(record.out, c.expected) << what << std::hex << " in " << c.in[0] << " out " << record.out << " not " << c.expected;
  }
}

bool holds_nan_payload(const Case& c) {  // constants hold only the canonical NaN
  return c.operand == F32 && (c.in[0] == 0x7F800001 || c.expected == 0xFFC12345);
}

void expect_all(std::span<const Case> cases) {
  for (const Case& c : cases) {
    expect_result(c, make(c, false), Mode::kF32, "evaluated");
    if (holds_nan_payload(c) || c.result == Type::kPtr) continue;
    ir::Kernel folded = make(c, true);
    passes::fold(folded);
    passes::dce(folded);
    const Value stored = folded.at(folded.regions[folded.wave].insts.back()).operand[2];
    const bool is_folded = folded.at(stored).op == Op::kConst || c.op == Op::kUnpackMask || c.expected == 0xFFC12345;
    EXPECT_TRUE(is_folded) << ir::op_info(c.op).name;
    expect_result(c, folded, Mode::kF32, "folded");
  }
}

TEST(Ops, Integers) { expect_all(kIntegerCases); }
TEST(Ops, Floats) { expect_all(kFloatCases); }
TEST(Ops, Conversions) { expect_all(kConversionCases); }

TEST(Ops, TranscendentalsOfTheTruth) {
  for (const Case& c : kTranscendentalCases) expect_result(c, make(c, false), Mode::kF64, "evaluated");
}

TEST(Ops, TranscendentalsAreNotDefinedInF32) {
  for (const Case& c : kTranscendentalCases) EXPECT_EQ(ir::lane_fn(c.op, F32, F32, ir::Floats::kNative), nullptr);
}

TEST(Ops, SelectTakesTheWholeValue) {
  for (const uint8_t cond : {0, 1}) {
    ir::Kernel kernel;
    kernel.wave_stride_bytes = sizeof(Record);
    ir::Builder b(kernel);
    const Value c = b.ine(b.load(I8, b.wave_ptr(), offsetof(Record, in)), b.constant(I8, 0));
    b.op(Op::kStore, Type::kVoid,
         {b.wave_ptr(), b.i32(offsetof(Record, out)), b.select(c, b.load(F64, b.wave_ptr(), 16), b.fconst(F64, 2))});
    Record record;
    record.in[0] = cond;
    record.in[1] = 0x7FF0000000000001;  // a signalling NaN passes as it is
    const PrimRecord prim{nullptr, 0, 1};
    run(kernel, Mode::kF32, nullptr, nullptr, &prim, 1, &record);
    EXPECT_EQ(record.out, cond != 0 ? 0x7FF0000000000001 : d(2));
  }
}

// ---- binary16 -------------------------------------------------------------------------------------------------------------

TEST(Half, EveryValueSurvivesTheRoundTrip) {
  for (uint32_t bits = 0; bits < 0x10000; ++bits) {
    const auto half = static_cast<uint16_t>(bits);
    const double v = ir::double_from_half(half);
    if (std::isnan(v)) continue;
    EXPECT_EQ(v, half_to_float(half));
    EXPECT_EQ(ir::half_from_double(v), half);
  }
}

TEST(Half, RoundsAsBaseDoes) {  // base/half.h rounds in integers
  for (uint64_t bits = 0; bits < 1ull << 32; bits += 9973) {
    const float v = std::bit_cast<float>(static_cast<uint32_t>(bits));
    if (std::isnan(v)) continue;
    ASSERT_EQ(ir::half_from_double(v), float_to_half(v)) << v;
  }
}

// |sum| * 2^-48 to binary16, nearest even, in integers.
uint16_t round_scaled(unsigned __int128 magnitude) {
  constexpr int kUnit = 48 - 24;  // a denormal half's unit is 2^-24
  int shift = kUnit;
  while ((magnitude >> shift) >= 2048) ++shift;
  const auto kept = static_cast<uint64_t>(magnitude >> shift);
  const unsigned __int128 rest = magnitude & ((static_cast<unsigned __int128>(1) << shift) - 1);
  const unsigned __int128 tie = static_cast<unsigned __int128>(1) << (shift - 1);
  const uint64_t rounded = kept + (rest > tie || (rest == tie && (kept & 1)) ? 1 : 0);
  const uint64_t bits = (static_cast<uint64_t>(shift - kUnit) << 10) + rounded;
  return static_cast<uint16_t>(bits < 0x7C00 ? bits : 0x7C00);
}

TEST(Half, FmaRoundsOnce) {
  constexpr uint64_t kSeed = 20240607;
  uint64_t state = kSeed;
  const auto random = [&] {
    return static_cast<uint32_t>((state = state * 6364136223846793005ull + 1442695040888963407ull) >> 33);
  };
  const ir::LaneFn fma = ir::lane_fn(Op::kFMa, F16, F16, ir::Floats::kNative);
  const auto scaled = [](uint64_t bits) {  // * 2^24: an integer
    return static_cast<__int128>(static_cast<int64_t>(ir::double_from_half(static_cast<uint16_t>(bits)) * 16777216));
  };
  for (int i = 0; i < 20000; ++i) {
    uint64_t a[kLanes], b[kLanes], c[kLanes], out[kLanes];
    for (uint32_t l = 0; l < kLanes; ++l) {
      a[l] = (random() % 0x7C00) | (random() & 1) << 15;
      b[l] = (random() % 0x7C00) | (random() & 1) << 15;
      c[l] = (random() % 0x7C00) | (random() & 1) << 15;
    }
    fma(out, a, b, c);
    for (uint32_t l = 0; l < kLanes; ++l) {
      const __int128 sum = scaled(a[l]) * scaled(b[l]) + scaled(c[l]) * 16777216;
      if (sum == 0) continue;  // the sign of a zero is IEEE's, not this oracle's
      const uint16_t expected = round_scaled(static_cast<unsigned __int128>(sum < 0 ? -sum : sum)) | (sum < 0 ? 0x8000 : 0);
      ASSERT_EQ(out[l], expected) << "seed " << kSeed << std::hex << " fma(" << a[l] << ", " << b[l] << ", " << c[l] << ")";
    }
  }
}

// ---- completeness ---------------------------------------------------------------------------------------------------------

TEST(Ops, NoneIsForgotten) {
  std::set<Op> tested = {// eval_test.cpp
                         Op::kConst, Op::kDrawPtr, Op::kThreadPtr, Op::kPrimPtr, Op::kWavePtr, Op::kLane, Op::kBallot,
                         Op::kShuffle, Op::kReduce, Op::kBarrier, Op::kQuadSwizzle, Op::kLoad, Op::kStore, Op::kAtomic,
                         Op::kLocal, Op::kLocalLoad, Op::kLocalStore, Op::kIf, Op::kLoop, Op::kLoopArg, Op::kYield, Op::kResult,
                         // jit_call_test.cpp
                         Op::kCall,
                         // above
                         Op::kSelect};
  for (const Case& c : kIntegerCases) tested.insert(c.op);
  for (const Case& c : kFloatCases) tested.insert(c.op);
  for (const Case& c : kConversionCases) tested.insert(c.op);
  for (const Case& c : kTranscendentalCases) tested.insert(c.op);
  for (uint32_t i = 1; i < static_cast<uint32_t>(Op::kCount); ++i) {
    EXPECT_TRUE(tested.contains(static_cast<Op>(i))) << ir::op_info(static_cast<Op>(i)).name;
  }
}

}  // namespace
}  // namespace pineda::eval
