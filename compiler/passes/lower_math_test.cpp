// Error of the transcendental functions: the lowered IR, run by the evaluator in binary32, against the C library in double
// precision, which is exact beside a binary32 ULP.
#include "compiler/passes/lower_math.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>

#include "compiler/eval/eval.h"
#include "compiler/ir/semantics.h"
#include "compiler/passes/passes.h"

namespace pineda::passes {
namespace {

using ir::Op;
using ir::Type;

struct Wave {
  uint32_t mask;
  uint32_t index;
};

// y[i] = op(x[i], z[i]): one kernel over arrays, 16 elements a wave.
class Function {
 public:
  // `type`: the operation's; the arrays are binary32.
  explicit Function(Op op, Precision precision = Precision::kDefault, Type type = Type::kF32) {
    kernel_.wave_stride_bytes = sizeof(Wave);
    ir::Builder b(kernel_);
    const ir::Value first = b.shl(b.load(Type::kI32, b.wave_ptr(), offsetof(Wave, index)), b.i32(6));
    const auto array = [&](uint32_t i) {
      return ir::Address{.base = b.load(Type::kPtr, b.draw_ptr(), 8 * i, ir::kInvariant), .offset = first, .lane_stride = 4};
    };
    const auto convert = [&](ir::Value v, Type to) { return b.type(v) == to ? v : b.convert(Op::kFConvert, to, v); };
    const ir::Value x = convert(b.load(Type::kF32, array(0)), type), z = convert(b.load(Type::kF32, array(1)), type);
    const ir::Value result = ir::op_info(op).operands == 2 ? b.op(op, type, {x, z}) : b.op(op, type, {x});
    b.store(array(2), convert(result, Type::kF32));
    lower_math(kernel_, precision);
    const std::string fault = ir::verify(kernel_);
    EXPECT_EQ(fault, "");
  }

  std::vector<float> operator()(std::vector<float> x, std::vector<float> z = {}) const {
    const size_t count = x.size();
    x.resize((count + 15) / 16 * 16);
    z.resize(x.size());
    std::vector<float> y(x.size());
    std::vector<Wave> waves;
    for (uint32_t i = 0; i < x.size() / 16; ++i) waves.push_back({0xffff, i});
    const void* draw[3] = {x.data(), z.data(), y.data()};
    const PrimRecord prim{nullptr, 0, static_cast<uint32_t>(waves.size())};
    eval::run(kernel_, eval::Mode::kF32, draw, nullptr, &prim, 1, waves.data());
    y.resize(count);
    return y;
  }

 private:
  ir::Kernel kernel_;
};

// Distance in units of the last place that the exact result has as a binary32; 0 when both are NaN or the same infinity.
double ulp_error(float got, double exact) {
  if (std::isnan(exact) || std::isnan(got)) return std::isnan(exact) && std::isnan(got) ? 0 : INFINITY;
  const float rounded = static_cast<float>(exact);
  if (got == rounded)
    return std::isinf(rounded) ? 0 : std::fabs(got - exact) / std::ldexp(1.0, std::max(std::ilogb(exact), -126) - 23);
  if (std::isinf(got)) return std::fabs(exact) > 0x1.fffffdp127 ? 1 : INFINITY;
  if (std::isinf(rounded)) return 0x1p128 - std::fabs(got) < 0x1p105 ? 1 : INFINITY;
  const int exponent = exact == 0 ? -126 : std::max(std::ilogb(exact), -126);
  return std::fabs(got - exact) / std::ldexp(1.0, exponent - 23);
}

float from_bits(uint32_t bits) { return std::bit_cast<float>(bits); }

// 2^18 values that cover every sign, exponent and leading mantissa bits; the low bits are random.
std::vector<float> all_floats(uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> x;
  for (uint32_t i = 0; i < 1u << 18; ++i) x.push_back(from_bits(i << 14 | (random() & 0x3fff)));
  return x;
}

std::vector<float> range(double low, double high, uint32_t count) {
  std::vector<float> x;
  for (uint32_t i = 0; i < count; ++i) x.push_back(static_cast<float>(low + (high - low) * i / (count - 1)));
  return x;
}

constexpr uint32_t kSeed = 20240501;

struct Case {
  const char* name;
  Op op;
  double (*exact)(double);
  double low, high;                          // a range sampled densely as well
  double fast_ulp, default_ulp;              // limits; `exact` has one for all: kExactUlp
  double (*fast_allowed)(double) = nullptr;  // another measure for `fast`: absolute error in units of 2^-24
};

// Half an ULP, and the error of binary64 arithmetic before the rounding.
constexpr double kExactUlp = 0.50001;

constexpr const char* kPrecisionNames[] = {"default", "fast", "exact"};

class Unary : public testing::TestWithParam<std::tuple<Precision, Case>> {};

// `fast` may flush: denormal operands and results do not count.
bool counts(Precision precision, float x, double exact) {
  if (precision != Precision::kFast) return true;
  const auto is_denormal = [](double v) { return v != 0 && std::fabs(v) < 0x1p-126; };
  return !is_denormal(x) && !is_denormal(exact);
}

TEST_P(Unary, ErrorIsBelowItsLimit) {
  const auto& [precision, c] = GetParam();
  std::vector<float> x = all_floats(kSeed);
  for (const float v : range(c.low, c.high, 1u << 18)) x.push_back(v);
  const std::vector<float> y = Function(c.op, precision)(x);
  double worst = 0;
  float where = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double exact = c.exact(x[i]);
    if (!counts(precision, x[i], exact)) continue;
    const bool absolute = precision == Precision::kFast && c.fast_allowed;
    const double error = absolute && std::fabs(exact) < 0x1.fffffep127 && std::isfinite(y[i])
                             ? std::fabs(y[i] - exact) / c.fast_allowed(exact)
                             : ulp_error(y[i], exact);
    if (error > worst) worst = error, where = x[i];
  }
  std::printf("%s %s: %.6f ULP at %a (seed %u)\n", c.name, kPrecisionNames[static_cast<int>(precision)], worst, where, kSeed);
  const double limit = precision == Precision::kFast ? c.fast_ulp : precision == Precision::kExact ? kExactUlp : c.default_ulp;
  EXPECT_LE(worst, limit) << c.name << "(" << where << ")";
}

// sin and cos: 2^-11; log2 and log: 3 ULP outside [0.5, 2] and 2^-21 there, where their results are below 1.
double within_2_to_11(double) { return 0x1p-11; }
double log_allowed(double exact) { return std::max(0x1p-21, 3 * std::ldexp(1.0, std::ilogb(exact) - 23)); }
double exp2_allowed(double exact) { return (3 + 2 * std::fabs(std::log2(exact))) * std::ldexp(1.0, std::ilogb(exact) - 23); }
double exp_allowed(double exact) { return (3 + 2 * std::fabs(std::log(exact))) * std::ldexp(1.0, std::ilogb(exact) - 23); }

INSTANTIATE_TEST_SUITE_P(
    LowerMath, Unary,
    testing::Combine(
        testing::Values(Precision::kFast, Precision::kDefault, Precision::kExact),
        testing::Values(
            Case{"exp2", Op::kFExp2, std::exp2, -150, 129, 1, 1.0, exp2_allowed},
            Case{"exp", Op::kFExp, std::exp, -104, 89, 1, 1.0, exp_allowed},
            Case{"log2", Op::kFLog2, std::log2, 0.25, 4, 1, 1.0, log_allowed},
            Case{"log", Op::kFLog, std::log, 0.25, 4, 1, 1.0, log_allowed},
            Case{"sin", Op::kFSin, std::sin, -400, 400, 1, 2.1, within_2_to_11},
            Case{"cos", Op::kFCos, std::cos, -400, 400, 1, 2.1, within_2_to_11},
            Case{"tan", Op::kFTan, std::tan, -400, 400, 1e9, 3.5}, Case{"asin", Op::kFAsin, std::asin, -1, 1, 4096, 2.5},
            Case{"acos", Op::kFAcos, std::acos, -1, 1, 4096, 2.0}, Case{"atan", Op::kFAtan, std::atan, -4, 4, 4096, 1.5},
            Case{"sinh", Op::kFSinh, std::sinh, -90, 90, 2.5, 2.5}, Case{"cosh", Op::kFCosh, std::cosh, -90, 90, 2.0, 2.0},
            Case{"tanh", Op::kFTanh, std::tanh, -10, 10, 2.0, 2.0}, Case{"asinh", Op::kFAsinh, std::asinh, -4, 4, 3.0, 3.0},
            Case{"acosh", Op::kFAcosh, std::acosh, 1, 4, 3.5, 3.5}, Case{"atanh", Op::kFAtanh, std::atanh, -1, 1, 3.0, 3.0},
            Case{"rsqrt", Op::kFRsqrt, [](double x) { return 1 / std::sqrt(x); }, 0, 4, 1.5, 1.5})),
    [](const auto& info) {
      return std::string(std::get<1>(info.param).name) + "_" + kPrecisionNames[static_cast<int>(std::get<0>(info.param))];
    });

TEST(LowerMath, CoarseLog2) {
  const std::vector<float> x = all_floats(kSeed);
  const std::vector<float> y = Function(Op::kFLog2Coarse)(x);
  double worst = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    if (std::isinf(x[i]) && x[i] > 0) continue;
    const double want = x[i] > 0x1p-126 ? std::log2(static_cast<double>(x[i])) : -126;  // NaN too
    worst = std::max(worst, std::fabs(y[i] - want));
  }
  EXPECT_LE(worst, 0x1p-13);
}

// All 65,536 operands of binary16: half an ULP, and a thousandth for the error of binary32 before the rounding; fast has fewer
// bits.
TEST_P(Unary, Binary16) {
  const auto& [precision, c] = GetParam();
  std::vector<float> x;
  for (uint32_t bits = 0; bits < 65536; ++bits)
    x.push_back(static_cast<float>(ir::double_from_half(static_cast<uint16_t>(bits))));
  const std::vector<float> y = Function(c.op, precision, Type::kF16)(x);
  double worst = 0;
  float where = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double exact = c.exact(x[i]), got = y[i];
    ASSERT_EQ(std::isnan(got), std::isnan(exact)) << x[i];
    const double nearest = ir::double_from_half(ir::half_from_double(exact));
    if (std::isnan(exact) || got == nearest) continue;
    ASSERT_TRUE(std::isfinite(got) && std::isfinite(nearest)) << c.name << "(" << x[i] << ") = " << got;
    const double error = std::fabs(got - exact) / std::ldexp(1.0, std::max(std::ilogb(exact), -14) - 10);
    if (error > worst) worst = error, where = x[i];
  }
  std::printf("%s, binary16, %s: %.5f ULP at %a\n", c.name, kPrecisionNames[static_cast<int>(precision)], worst, where);
  EXPECT_LE(worst, precision == Precision::kFast ? 0.6 : precision == Precision::kExact ? kExactUlp : 0.501);
}

class EachPrecision : public testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(LowerMath, EachPrecision, testing::Values(Precision::kFast, Precision::kDefault, Precision::kExact),
                         [](const auto& info) { return std::string(kPrecisionNames[static_cast<int>(info.param)]); });

TEST_P(EachPrecision, Pow) {
  std::mt19937 random(kSeed);
  std::vector<float> x, y;
  // Bases of every size, exponents that bring the result anywhere between underflow and overflow; then bases near one.
  for (uint32_t i = 0; i < 1u << 18; ++i) {
    const double base = i % 2 ? from_bits(random() % 0x7f800000)
                              : 1 + std::ldexp(static_cast<double>(random()) - 0x1p31, -32 - static_cast<int>(random() % 20));
    const double target = (random() / 0x1p32 - 0.5) * 300;
    x.push_back(static_cast<float>(base));
    y.push_back(static_cast<float>(target / std::log2(std::max(base, 1e-45) == 1 ? 2 : base)));
  }
  const std::vector<float> z = Function(Op::kFPow, GetParam())(x, y);
  const bool fast = GetParam() == Precision::kFast;
  double worst = 0;
  size_t where = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double exact = std::pow(double{x[i]}, double{y[i]});
    if (!counts(GetParam(), x[i], exact) || !counts(GetParam(), y[i], exact)) continue;
    double error = ulp_error(z[i], exact);
    // Inherited from exp2(y log2 x): the error of the logarithm, |y| times 3 ULP or 2^-21, and of the product, through exp2.
    const double log = std::log2(double{x[i]}), product = y[i] * log;
    if (fast) {
      const double log_error = std::max(0x1p-21, 3 * std::ldexp(1.0, std::ilogb(log) - 23));
      const double inherited = std::fabs(y[i]) * log_error + std::fabs(product) * 0x1p-24;
      error /= 3 + 2 * std::fabs(product) + inherited * 0x1p24 * std::numbers::ln2;
    }
    if (error > worst) worst = error, where = i;
  }
  std::printf("pow: %.6f %s at (%a, %a)\n", worst, fast ? "of what is allowed" : "ULP", x[where], y[where]);
  EXPECT_LE(worst, fast ? 1 : GetParam() == Precision::kExact ? kExactUlp : 2.1) << x[where] << " " << y[where];
}

TEST_P(EachPrecision, PowOfSpecialValues) {
  const float inf = INFINITY;
  const std::vector<float> x{0, 0, 0, inf, inf, inf, 1, 1, 2, 2, 0.5, 0.5, 3, NAN, 2, 7},
      y{0, 2, -2, 0, 2, -2, inf, NAN, inf, -inf, inf, -inf, 0, 2, NAN, 1};
  const std::vector<float> z = Function(Op::kFPow, GetParam())(x, y);
  for (size_t i = 0; i < x.size(); ++i) {
    const double want = std::pow(static_cast<double>(x[i]), static_cast<double>(y[i]));
    EXPECT_EQ(ulp_error(z[i], want) <= 1, true) << "pow(" << x[i] << ", " << y[i] << ") = " << z[i] << ", not " << want;
  }
  EXPECT_TRUE(std::isnan(Function(Op::kFPow, GetParam())({-2}, {2})[0]));
}

TEST_P(EachPrecision, Atan2) {
  std::mt19937 random(kSeed);
  std::vector<float> y, x;
  for (uint32_t i = 0; i < 1u << 18; ++i) {
    y.push_back(i % 2 ? from_bits(random()) : static_cast<float>(random() / 0x1p31 - 1));
    x.push_back(i % 2 ? from_bits(random()) : static_cast<float>(random() / 0x1p31 - 1));
  }
  for (const float a : {0.0f, -0.0f, 1.0f, -1.0f, INFINITY, -INFINITY, NAN}) {
    for (const float c : {0.0f, -0.0f, 1.0f, -1.0f, INFINITY, -INFINITY, NAN}) y.push_back(a), x.push_back(c);
  }
  const std::vector<float> z = Function(Op::kFAtan2, GetParam())(y, x);
  double worst = 0;
  size_t where = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double exact = std::atan2(static_cast<double>(y[i]), static_cast<double>(x[i]));
    if (!counts(GetParam(), y[i], exact) || !counts(GetParam(), x[i], exact)) continue;
    const double error = ulp_error(z[i], exact);
    if (error > worst) worst = error, where = i;
    if (!std::isnan(exact)) {
      ASSERT_EQ(std::signbit(z[i]), std::signbit(exact)) << y[i] << " " << x[i];
    }
  }
  std::printf("atan2: %.6f ULP at (%a, %a)\n", worst, y[where], x[where]);
  const double limit = GetParam() == Precision::kFast ? 4096 : GetParam() == Precision::kExact ? kExactUlp : 2.0;
  EXPECT_LE(worst, limit) << y[where] << " " << x[where];
}

TEST_P(EachPrecision, KeepsSignedZeros) {
  for (const Op op : {Op::kFSin, Op::kFTan, Op::kFAsin, Op::kFAtan, Op::kFSinh, Op::kFTanh, Op::kFAsinh, Op::kFAtanh}) {
    const std::vector<float> y = Function(op, GetParam())({0.0f, -0.0f});
    EXPECT_EQ(std::bit_cast<uint32_t>(y[0]), 0u) << ir::op_info(op).name;
    EXPECT_EQ(std::bit_cast<uint32_t>(y[1]), 0x80000000u) << ir::op_info(op).name;
  }
}

TEST_P(EachPrecision, IsIdempotent) {
  ir::Kernel kernel;
  ir::Builder b(kernel);
  b.store({.base = b.draw_ptr()}, b.fsin(b.flog2(b.load(Type::kF32, b.draw_ptr(), 0))));
  lower_math(kernel, GetParam());
  const std::string once = ir::print(kernel);
  EXPECT_EQ(once.find("fsin"), std::string::npos);
  lower_math(kernel, GetParam());
  EXPECT_EQ(ir::print(kernel), once);
}

TEST(LowerMath, Binary16GoesThroughBinary32) {
  ir::Kernel kernel;
  ir::Builder b(kernel);
  b.store({.base = b.draw_ptr()}, b.fexp2(b.load(Type::kF16, b.draw_ptr(), 2)));
  lower_math(kernel);
  EXPECT_EQ(ir::verify(kernel), "");
  EXPECT_EQ(ir::print(kernel).find("fexp2"), std::string::npos);
}

}  // namespace
}  // namespace pineda::passes
