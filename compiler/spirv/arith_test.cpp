// Scalar operations of SPIR-V and GLSL.std.450, table against oracle: each row is a GLSL expression over a, b, c and the same in
// double (or 32-bit integers). + - * / sqrt of floats, computed in double and rounded to float, are what binary32 gives directly
// (double has more than twice the bits plus two), so rows made of one operation must agree exactly.
#include <cmath>
#include <limits>
#include <random>

#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

constexpr uint32_t kSeed = 4711;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct FloatRow {
  const char* text;
  double (*oracle)(double a, double b, double c);
  double ulps = 0;  // allowed, of the larger of the result and 1
};

double clamp(double x, double low, double high) { return std::min(std::max(x, low), high); }

// One operation each: exact in both modes, special values included.
const FloatRow kExact[] = {
    {"a + b", [](double a, double b, double) { return a + b; }},
    {"a - b", [](double a, double b, double) { return a - b; }},
    {"a * b", [](double a, double b, double) { return a * b; }},
    {"a / b", [](double a, double b, double) { return a / b; }},
    {"-a", [](double a, double, double) { return -a; }},
    {"abs(a)", [](double a, double, double) { return std::fabs(a); }},
    {"sqrt(a)", [](double a, double, double) { return std::sqrt(a); }},
    {"floor(a)", [](double a, double, double) { return std::floor(a); }},
    {"ceil(a)", [](double a, double, double) { return std::ceil(a); }},
    {"trunc(a)", [](double a, double, double) { return std::trunc(a); }},
    {"roundEven(a)", [](double a, double, double) { return std::nearbyint(a); }},
    {"round(a)", [](double a, double, double) { return std::nearbyint(a); }},
    {"sign(a)", [](double a, double, double) { return double(a > 0) - double(a < 0); }},
    {"step(a, b)", [](double a, double b, double) { return b < a ? 0.0 : 1.0; }},
    {"isnan(a) ? 1.0 : 0.0", [](double a, double, double) { return std::isnan(a) ? 1.0 : 0.0; }},
    {"isinf(a) ? 1.0 : 0.0", [](double a, double, double) { return std::isinf(a) ? 1.0 : 0.0; }},
    {"a < b ? 1.0 : 0.0", [](double a, double b, double) { return a < b ? 1.0 : 0.0; }},
    {"a <= b ? 1.0 : 0.0", [](double a, double b, double) { return a <= b ? 1.0 : 0.0; }},
    {"a > b ? 1.0 : 0.0", [](double a, double b, double) { return a > b ? 1.0 : 0.0; }},
    {"a >= b ? 1.0 : 0.0", [](double a, double b, double) { return a >= b ? 1.0 : 0.0; }},
    {"a == b ? 1.0 : 0.0", [](double a, double b, double) { return a == b ? 1.0 : 0.0; }},
    {"a != b ? 1.0 : 0.0", [](double a, double b, double) { return a != b ? 1.0 : 0.0; }},
    {"fma(a, b, c)", [](double a, double b, double c) { return static_cast<double>(std::fma(float(a), float(b), float(c))); },
     0.5},
};

// Several operations: in f32 each rounds once, so the bound is about the number of operations.
const FloatRow kRounded[] = {
    {"fract(a)", [](double a, double, double) { return a - std::floor(a); }, 1},
    {"mod(a, b)", [](double a, double b, double) { return a - b * std::floor(a / b); }, 4},
    {"min(a, b)", [](double a, double b, double) { return b < a ? b : a; }},
    {"max(a, b)", [](double a, double b, double) { return a < b ? b : a; }},
    {"clamp(a, -b, b)", [](double a, double b, double) { return clamp(a, -b, b); }},
    {"mix(a, b, c)", [](double a, double b, double c) { return a * (1 - c) + b * c; }, 4},
    {"smoothstep(0.0, b, a)",
     [](double a, double b, double) {
       const double t = clamp(a / b, 0, 1);
       return t * t * (3 - 2 * t);
     },
     8},
    {"inversesqrt(b)", [](double, double b, double) { return 1 / std::sqrt(b); }, 2},
    {"radians(a)", [](double a, double, double) { return a * M_PI / 180; }, 2},
    {"degrees(c)", [](double, double, double c) { return c * 180 / M_PI; }, 100},
    {"ldexp(a, int(b))", [](double a, double b, double) { return std::ldexp(a, int(b)); }},
    {"modf(a, temp) + temp * 64.0", [](double a, double, double) { return a - std::trunc(a) + std::trunc(a) * 64; }, 600},
    {"frexp(a, n) + float(n)",
     [](double a, double, double) {
       int n;
       const double m = std::frexp(a, &n);
       return m + n;
     },
     4},
    {"length(a)", [](double a, double, double) { return std::fabs(a); }},
    {"distance(a, b)", [](double a, double b, double) { return std::fabs(a - b); }, 10},
};

// Compared in f64 only; how close the f32 polynomials come is tested where they are (passes/lower_math). Domains suit a in (-9,
// 9), b in (0, 9), c in (-1, 1).
const FloatRow kTranscendental[] = {
    {"sin(a)", [](double a, double, double) { return std::sin(a); }, 1},
    {"cos(a)", [](double a, double, double) { return std::cos(a); }, 1},
    {"tan(a)", [](double a, double, double) { return std::tan(a); }, 20},
    {"asin(c)", [](double, double, double c) { return std::asin(c); }, 1},
    {"acos(c)", [](double, double, double c) { return std::acos(c); }, 2},
    {"atan(a)", [](double a, double, double) { return std::atan(a); }, 1},
    {"atan(a, b)", [](double a, double b, double) { return std::atan2(a, b); }, 1},
    {"sinh(c)", [](double, double, double c) { return std::sinh(c); }, 1},
    {"cosh(c)", [](double, double, double c) { return std::cosh(c); }, 1},
    {"tanh(a)", [](double a, double, double) { return std::tanh(a); }, 1},
    {"tanh(a * 100.0)", [](double a, double, double) { return std::tanh(a * 100); }, 1},
    {"asinh(a)", [](double a, double, double) { return std::asinh(a); }, 2},
    {"acosh(b + 1.0)", [](double, double b, double) { return std::acosh(b + 1); }, 2},
    {"atanh(c)", [](double, double, double c) { return std::atanh(c); }, 2},
    {"pow(b, a)", [](double a, double b, double) { return std::pow(b, a); }, 1},
    {"exp(c)", [](double, double, double c) { return std::exp(c); }, 1},
    {"exp2(c)", [](double, double, double c) { return std::exp2(c); }, 1},
    {"log(b)", [](double, double b, double) { return std::log(b); }, 1},
    {"log2(b)", [](double, double b, double) { return std::log2(b); }, 2},
};

using Triple = std::array<float, 3>;

void check_floats(std::span<const FloatRow> rows, const std::vector<Triple>& inputs, eval::Mode mode) {
  ASSERT_EQ(inputs.size() % 16, 0u);
  std::string body;
  for (size_t i = 0; i < rows.size(); ++i) {
    body += "d[16u * " + std::to_string(i + 3) + "u + lane] = " + rows[i].text + ";\n";
  }
  body = "float a = d[lane], b = d[16u + lane], c = d[32u + lane], temp; int n;\n" + body;
  const Words words = compute_words(body, "float");
  for (size_t first = 0; first < inputs.size(); first += 16) {
    FakeStage stage;
    stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
    Words& data = stage.buffers[0].words;
    data.resize(16 * (rows.size() + 3));
    for (uint32_t lane = 0; lane < 16; ++lane) {
      for (uint32_t k = 0; k < 3; ++k) data[16 * k + lane] = word(inputs[first + lane][k]);
    }
    ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, words, {.mode = mode}), "");
    for (size_t i = 0; i < rows.size(); ++i) {
      for (uint32_t lane = 0; lane < 16; ++lane) {
        const Triple& in = inputs[first + lane];
        const float want = static_cast<float>(rows[i].oracle(in[0], in[1], in[2]));
        const float got = real(data[16 * (i + 3) + lane]);
        const auto where = [&] {
          return testing::Message() << rows[i].text << " of " << in[0] << ", " << in[1] << ", " << in[2] << " in f"
                                    << (mode == eval::Mode::kF64 ? 64 : 32);
        };
        if (std::isnan(want) || std::isinf(want) || rows[i].ulps == 0) {
          if (std::isnan(want))
            EXPECT_TRUE(std::isnan(got)) << where();
          else
            EXPECT_EQ(got, want) << where();
        } else {
          EXPECT_NEAR(got, want, rows[i].ulps * 0x1p-23 * std::max(1.0f, std::fabs(want))) << where();
        }
      }
    }
  }
}

std::vector<Triple> ordinary_inputs(uint32_t count) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> a(-9, 9), b(0.01f, 9), c(-0.99f, 0.99f);
  std::vector<Triple> out;
  for (uint32_t i = 0; i < count; ++i) out.push_back({a(random), b(random), c(random)});
  return out;
}

std::vector<Triple> special_inputs() {
  const float values[] = {0.0f,       -0.0f,   1.0f,     -1.5f,       2.5f,         0x1p-149f,
                          -0x1p-127f, 3.4e38f, -3.4e38f, float(kInf), -float(kInf), kNan};
  std::vector<Triple> out;
  for (float a : values) {
    for (float b : values) out.push_back({a, b, 1.25f});
  }
  return out;
}

TEST(SpirvArith, FloatOperationsAreExact) {
  const std::span<const FloatRow> single(kExact);
  for (eval::Mode mode : {eval::Mode::kF32, eval::Mode::kF64}) {
    check_floats(single, ordinary_inputs(16), mode);
    check_floats(single.first(single.size() - 1), special_inputs(), mode);  // fma of infinities: see kernels' tests
  }
}

TEST(SpirvArith, FloatFunctions) {
  for (eval::Mode mode : {eval::Mode::kF32, eval::Mode::kF64}) check_floats(kRounded, ordinary_inputs(32), mode);
}

TEST(SpirvArith, Transcendentals) { check_floats(kTranscendental, ordinary_inputs(32), eval::Mode::kF64); }

TEST(SpirvArith, LdexpAndFrexpOfExtremes) {
  const FloatRow rows[] = {
      {"ldexp(a, int(b))", [](double a, double b, double) { return std::ldexp(a, int(b)); }},
      {"frexp(a, n)",
       [](double a, double, double) {
         int n;
         return std::frexp(a, &n);
       }},
      {"float((temp = frexp(a, n)) * 0.0) + float(n)",
       [](double a, double, double) {
         int n;
         std::frexp(a, &n);
         return double(n);
       }},
  };
  std::vector<Triple> in;
  for (float a : {1.0f, 0x1.8p-149f, 0x1.fffffep127f, -0x1.23456p-130f}) {
    for (float n : {-300.f, -150.f, -149.f, -126.f, -24.f, 23.f, 127.f, 280.f}) in.push_back({a, n, 0});
  }
  check_floats(rows, in, eval::Mode::kF32);
}

// ---- integers ----

struct IntRow {
  const char* text;
  uint32_t (*oracle)(uint32_t a, uint32_t b);
};
int32_t s(uint32_t v) { return static_cast<int32_t>(v); }
uint32_t u(int64_t v) { return static_cast<uint32_t>(v); }

const IntRow kInts[] = {
    {"a + b", [](uint32_t a, uint32_t b) { return a + b; }},
    {"a - b", [](uint32_t a, uint32_t b) { return a - b; }},
    {"a * b", [](uint32_t a, uint32_t b) { return a * b; }},
    {"a / b", [](uint32_t a, uint32_t b) { return b ? a / b : ~0u; }},  // division by zero: compiler/ir/ops.inc
    {"a % b", [](uint32_t a, uint32_t b) { return b ? a % b : a; }},
    {"uint(int(a) / int(b))", [](uint32_t a, uint32_t b) { return b ? u(int64_t{s(a)} / s(b)) : ~0u; }},
    {"uint(-int(a))", [](uint32_t a, uint32_t) { return 0u - a; }},
    {"a << (b & 31u)", [](uint32_t a, uint32_t b) { return a << (b & 31); }},
    {"a >> (b & 31u)", [](uint32_t a, uint32_t b) { return a >> (b & 31); }},
    {"uint(int(a) >> (b & 31u))", [](uint32_t a, uint32_t b) { return u(s(a) >> (b & 31)); }},
    {"a & b", [](uint32_t a, uint32_t b) { return a & b; }},
    {"a | b", [](uint32_t a, uint32_t b) { return a | b; }},
    {"a ^ b", [](uint32_t a, uint32_t b) { return a ^ b; }},
    {"~a", [](uint32_t a, uint32_t) { return ~a; }},
    {"uint(abs(int(a)))", [](uint32_t a, uint32_t) { return s(a) < 0 ? 0u - a : a; }},
    {"uint(sign(int(a)))", [](uint32_t a, uint32_t) { return u((s(a) > 0) - (s(a) < 0)); }},
    {"min(a, b)", [](uint32_t a, uint32_t b) { return std::min(a, b); }},
    {"max(a, b)", [](uint32_t a, uint32_t b) { return std::max(a, b); }},
    {"uint(min(int(a), int(b)))", [](uint32_t a, uint32_t b) { return u(std::min(s(a), s(b))); }},
    {"uint(max(int(a), int(b)))", [](uint32_t a, uint32_t b) { return u(std::max(s(a), s(b))); }},
    {"clamp(a, 5u, 100u)", [](uint32_t a, uint32_t) { return std::min(std::max(a, 5u), 100u); }},
    {"uint(clamp(int(a), -5, 100))", [](uint32_t a, uint32_t) { return u(std::min(std::max(s(a), -5), 100)); }},
    {"uint(a < b)", [](uint32_t a, uint32_t b) { return uint32_t{a < b}; }},
    {"uint(a >= b)", [](uint32_t a, uint32_t b) { return uint32_t{a >= b}; }},
    {"uint(int(a) < int(b))", [](uint32_t a, uint32_t b) { return uint32_t{s(a) < s(b)}; }},
    {"uint(int(a) <= int(b))", [](uint32_t a, uint32_t b) { return uint32_t{s(a) <= s(b)}; }},
    {"uint(int(a) > int(b))", [](uint32_t a, uint32_t b) { return uint32_t{s(a) > s(b)}; }},
    {"uint(a == b)", [](uint32_t a, uint32_t b) { return uint32_t{a == b}; }},
    {"uint(bitCount(a))", [](uint32_t a, uint32_t) { return u(std::popcount(a)); }},
    {"uint(findLSB(a))", [](uint32_t a, uint32_t) { return a ? u(std::countr_zero(a)) : ~0u; }},
    {"uint(findMSB(a))", [](uint32_t a, uint32_t) { return u(31 - std::countl_zero(a)); }},
    {"uint(findMSB(int(a)))", [](uint32_t a, uint32_t) { return u(31 - std::countl_zero(s(a) < 0 ? ~a : a)); }},
    {"bitfieldReverse(a)",
     [](uint32_t a, uint32_t) {
       uint32_t r = 0;
       for (int i = 0; i < 32; ++i) r |= (a >> i & 1) << (31 - i);
       return r;
     }},
    {"bitfieldExtract(a, int(b & 15u), int(b >> 4u & 15u))",
     [](uint32_t a, uint32_t b) { return a >> (b & 15) & ((1u << (b >> 4 & 15)) - 1); }},
    {"uint(bitfieldExtract(int(a), int(b & 15u), int(b >> 4u & 15u)))",
     [](uint32_t a, uint32_t b) {
       const uint32_t count = b >> 4 & 15;
       if (count == 0) return 0u;
       const uint32_t field = a >> (b & 15) & ((1u << count) - 1);
       return field >> (count - 1) & 1 ? field | ~0u << count : field;
     }},
    {"bitfieldExtract(a, 0, 32)", [](uint32_t a, uint32_t) { return a; }},
    {"bitfieldInsert(a, b, 7, 11)", [](uint32_t a, uint32_t b) { return (a & ~(0x7ffu << 7)) | (b & 0x7ff) << 7; }},
    {"bitfieldInsert(a, b, 0, 32)", [](uint32_t, uint32_t b) { return b; }},
    {"uaddCarry(a, b, t) ^ (t << 31u)", [](uint32_t a, uint32_t b) { return (a + b) ^ uint32_t { a + b < a } << 31; }},
    {"usubBorrow(a, b, t) ^ (t << 31u)", [](uint32_t a, uint32_t b) { return (a - b) ^ uint32_t { a < b } << 31; }},
    {"(umulExtended(a, b, t, w), t ^ w)",
     [](uint32_t a, uint32_t b) {
       const uint64_t p = uint64_t{a} * b;
       return u(p >> 32) ^ u(p);
     }},
    {"(imulExtended(int(a), int(b), ti, wi), uint(ti ^ wi))",
     [](uint32_t a, uint32_t b) {
       const int64_t p = int64_t{s(a)} * s(b);
       return u(p >> 32) ^ u(p);
     }},
    {"floatBitsToUint(uintBitsToFloat(a & 0x7f7fffffu))", [](uint32_t a, uint32_t) { return a & 0x7f7fffff; }},
    {"uint(float(a & 0xffffffu))", [](uint32_t a, uint32_t) { return a & 0xffffff; }},
    {"uint(int(float(int(a) >> 8)))", [](uint32_t a, uint32_t) { return u(s(a) >> 8); }},
    {"floatBitsToUint(float(a))", [](uint32_t a, uint32_t) { return word(static_cast<float>(a)); }},
    {"floatBitsToUint(float(int(a)))", [](uint32_t a, uint32_t) { return word(static_cast<float>(s(a))); }},
};

TEST(SpirvArith, Integers) {
  std::mt19937 random(kSeed);
  std::string body = "uint a = d[lane], b = d[16u + lane], t, w; int ti, wi;\n";
  for (size_t i = 0; i < std::size(kInts); ++i) {
    body += "d[16u * " + std::to_string(i + 2) + "u + lane] = " + kInts[i].text + ";\n";
  }
  const Words words = compute_words(body);
  for (int round = 0; round < 8; ++round) {
    FakeStage stage;
    stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
    Words& data = stage.buffers[0].words;
    data.resize(16 * (std::size(kInts) + 2));
    const uint32_t special[] = {0, 1, ~0u, 0x80000000, 0x7fffffff, 31, 255, 0xffff};
    for (uint32_t i = 0; i < 32; ++i) data[i] = round == 0 ? special[i % 16 / (i < 16 ? 1 : 2) % 8] : random() >> random() % 32;
    if (round == 1) data[3] = 0x80000000, data[19] = ~0u;  // INT_MIN / -1
    ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, words), "");
    for (size_t i = 0; i < std::size(kInts); ++i) {
      for (uint32_t lane = 0; lane < 16; ++lane) {
        EXPECT_EQ(data[16 * (i + 2) + lane], kInts[i].oracle(data[lane], data[16 + lane]))
            << kInts[i].text << " of " << data[lane] << ", " << data[16 + lane] << ", seed " << kSeed;
      }
    }
  }
}

TEST(SpirvArith, NoContractionKeepsRoundings) {  // a * b + c with `precise` rounds twice, without it is fused
  const Words data{word(1 + 0x1p-12f), word(1 + 0x1p-12f), word(-1 - 0x1p-11f), 0};
  const Words twice = compute("if (lane == 0u) { precise float r = d[0] * d[1] + d[2]; d[3] = r; }", data, "float");
  const Words fused = compute("if (lane == 0u) { float r = d[0] * d[1] + d[2]; d[3] = r; }", data, "float");
  EXPECT_EQ(real(twice[3]), 0.0f);
  EXPECT_EQ(real(fused[3]), 0x1p-24f);
}

}  // namespace
}  // namespace pineda::spirv::test
