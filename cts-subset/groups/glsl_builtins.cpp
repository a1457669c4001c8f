// glsl.builtin.precision: the float functions of GLSL within the bounds of "Precision and Operation of SPIR-V Instructions".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/evaluate.h"
#include "cts-subset/reference/float32.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

struct Range {
  double low, high;
  bool logarithmic = false;  // magnitudes spread over the exponents; low > 0
};

using Exact = std::function<double(double, double, double)>;

struct Function {
  const char* name;
  const char* expression;  // of x, y, z: vectors of the case's size
  Exact exact;
  std::function<Tolerance(double x, double y, double z, double exact)> allowed;
  Range x, y{0, 1}, z{0, 1};
};

constexpr double kPi = std::numbers::pi;

std::function<Tolerance(double, double, double, double)> ulps(double count, double absolute = 0) {
  return [=](double, double, double, double) { return Tolerance{count, absolute}; };
}

// x and y carry the error of one operation each: that of the sum is relative to the larger term.
Tolerance of_sum(double first_term, double second_term, double count = 1) {
  return {count, ulp32(first_term) * count + ulp32(second_term) * count};
}

const std::vector<Function>& functions() {
  static const std::vector<Function> table = {
      {"add", "x + y", [](double x, double y, double) { return x + y; }, ulps(1), {-1e6, 1e6}, {-1e6, 1e6}},
      {"subtract", "x - y", [](double x, double y, double) { return x - y; }, ulps(1), {-1e6, 1e6}, {-1e6, 1e6}},
      {"multiply", "x * y", [](double x, double y, double) { return x * y; }, ulps(1), {1e-15, 1e15, true}, {1e-15, 1e15, true}},
      {"divide", "x / y", [](double x, double y, double) { return x / y; }, ulps(2.5), {1e-15, 1e15, true}, {1e-15, 1e15, true}},
      {"fma",
       "fma(x, y, z)",
       [](double x, double y, double z) { return x * y + z; },
       [](double x, double y, double z, double) { return of_sum(x * y, z); },
       {-100, 100},
       {-100, 100},
       {-1e4, 1e4}},
      {"mod",
       "mod(x, y)",
       [](double x, double y, double) { return x - y * std::floor(x / y); },
       // from x - y * floor(x / y): the quotient may fall on the wrong side of an integer only within its 2.5 ULP; inputs avoid
       // that
       [](double x, double y, double, double) {
         return Tolerance{1, 4 * ulp32(x) + 4 * ulp32(y)};
       },
       {-1000, 1000},
       {3.2, 3.7}},
      {"exp",
       "exp(x)",
       [](double x, double, double) { return std::exp(x); },
       [](double x, double, double, double) { return Tolerance{3 + 2 * std::abs(x)}; },
       {-80, 80}},
      {"exp2",
       "exp2(x)",
       [](double x, double, double) { return std::exp2(x); },
       [](double x, double, double, double) { return Tolerance{3 + 2 * std::abs(x)}; },
       {-120, 120}},
      {"log",
       "log(x)",
       [](double x, double, double) { return std::log(x); },
       [](double x, double, double, double) {
         return x >= 0.5 && x <= 2 ? Tolerance{0, 0x1p-21} : Tolerance{3};
       },
       {1e-30, 1e30, true}},
      {"log2",
       "log2(x)",
       [](double x, double, double) { return std::log2(x); },
       [](double x, double, double, double) {
         return x >= 0.5 && x <= 2 ? Tolerance{0, 0x1p-21} : Tolerance{3};
       },
       {1e-30, 1e30, true}},
      {"log2_near_one", "log2(x)", [](double x, double, double) { return std::log2(x); }, ulps(0, 0x1p-21), {0.5, 2}},
      {"pow",
       "pow(x, y)",
       [](double x, double y, double) { return std::pow(x, y); },
       [](double x, double y, double, double exact) {  // inherited from exp2(y * log2(x))
         const double product = y * std::log2(x);
         const double log_error = x >= 0.5 && x <= 2 ? 0x1p-21 : 3 * ulp32(std::log2(x));
         const double argument_error = std::abs(y) * log_error + ulp32(product);
         return Tolerance{3 + 2 * std::abs(product) + 4, std::abs(exact) * (std::exp2(argument_error) - 1)};
       },
       {1e-3, 1e3, true},
       {-8, 8}},
      {"sqrt", "sqrt(x)", [](double x, double, double) { return std::sqrt(x); }, ulps(2.5 + 2 + 1), {1e-30, 1e30, true}},
      {"inversesqrt", "inversesqrt(x)", [](double x, double, double) { return 1 / std::sqrt(x); }, ulps(2), {1e-30, 1e30, true}},
      {"sin", "sin(x)", [](double x, double, double) { return std::sin(x); }, ulps(0, 0x1p-11), {-kPi, kPi}},
      {"cos", "cos(x)", [](double x, double, double) { return std::cos(x); }, ulps(0, 0x1p-11), {-kPi, kPi}},
      {"tan",
       "tan(x)",
       [](double x, double, double) { return std::tan(x); },
       [](double x, double, double, double exact) {  // inherited from sin(x) / cos(x)
         const double c = std::abs(std::cos(x));
         return Tolerance{2.5, c > 0x1p-10 ? (0x1p-11 + std::abs(exact) * 0x1p-11) / (c - 0x1p-11) : 1e30};
       },
       {-1.5, 1.5}},
      {"asin", "asin(x)", [](double x, double, double) { return std::asin(x); }, ulps(4096, 0x1p-11), {-1, 1}},
      {"acos", "acos(x)", [](double x, double, double) { return std::acos(x); }, ulps(4096, 0x1p-11), {-1, 1}},
      {"atan", "atan(x)", [](double x, double, double) { return std::atan(x); }, ulps(4096), {1e-6, 1e6, true}},
      {"atan2", "atan(x, y)", [](double x, double y, double) { return std::atan2(x, y); }, ulps(4096), {-100, 100}, {-100, 100}},
      {"sinh",
       "sinh(x)",
       [](double x, double, double) { return std::sinh(x); },
       [](double x, double, double, double) { return of_sum(std::exp(x), std::exp(-x), 3 + 2 * std::abs(x)); },
       {-20, 20}},
      {"cosh",
       "cosh(x)",
       [](double x, double, double) { return std::cosh(x); },
       [](double x, double, double, double) { return of_sum(std::exp(x), std::exp(-x), 3 + 2 * std::abs(x)); },
       {-20, 20}},
      {"tanh",
       "tanh(x)",
       [](double x, double, double) { return std::tanh(x); },
       [](double x, double, double, double exact) {  // from sinh(x) / cosh(x)
         const double count = 3 + 2 * std::abs(x), c = std::cosh(x);
         const double term = count * (ulp32(std::exp(x)) + ulp32(std::exp(-x)));
         return Tolerance{2.5 + count, term / c * (1 + std::abs(exact))};
       },
       {-15, 15}},
      {"asinh",
       "asinh(x)",
       [](double x, double, double) { return std::asinh(x); },
       [](double x, double, double, double) {  // from log(x + sqrt(x * x + 1))
         const double root = std::sqrt(x * x + 1), sum = x + root;
         return Tolerance{3, 0x1p-21 + (6 * ulp32(root) + ulp32(sum)) / std::max(sum, 1e-9)};
       },
       {-50, 50}},
      {"acosh",
       "acosh(x)",
       [](double x, double, double) { return std::acosh(x); },
       [](double x, double, double, double) {  // from log(x + sqrt(x * x - 1))
         const double root = std::sqrt(x * x - 1), sum = x + root;
         const double root_error = 6 * ulp32(root) + ulp32(x * x) / std::max(root, 1e-9);
         return Tolerance{3, 0x1p-21 + (root_error + ulp32(sum)) / sum};
       },
       {1.01, 50}},
      {"atanh",
       "atanh(x)",
       [](double x, double, double) { return std::atanh(x); },
       [](double x, double, double, double) {  // from log((1 + x) / (1 - x)) * 0.5
         return Tolerance{4, 0x1p-21 + 4 * (ulp32(1 + x) / (1 + x) + ulp32(1 - x) / (1 - x))};
       },
       {-0.98, 0.98}},
      {"radians", "radians(x)", [](double x, double, double) { return x * kPi / 180; }, ulps(2.5), {-1e4, 1e4}},
      {"degrees", "degrees(x)", [](double x, double, double) { return x * 180 / kPi; }, ulps(2.5), {-1e3, 1e3}},
      {"fract", "fract(x)", [](double x, double, double) { return x - std::floor(x); }, ulps(1), {-1e4, 1e4}},
      {"round",
       "round(x)",
       [](double x, double, double) { return std::round(x); },
       // halves may go either way
       [](double x, double, double, double) {
         return Tolerance{0, x - std::floor(x) == 0.5 ? 1.0 : 0.0};
       },
       {-1e4, 1e4}},
      {"sign", "sign(x)", [](double x, double, double) { return x > 0   ? 1.0
                                                                : x < 0 ? -1.0
                                                                        : 0.0; }, ulps(0), {-1e4, 1e4}},
      {"step", "step(y, x)", [](double x, double y, double) { return x < y ? 0.0 : 1.0; }, ulps(0), {-10, 10}, {-10, 10}},
      {"clamp",
       "clamp(x, y, y + 2.0)",
       [](double x, double y, double) { return std::clamp(x, y, static_cast<double>(static_cast<float>(y + 2))); },
       ulps(1),
       {-10, 10},
       {-5, 5}},
      {"mix",
       "mix(x, y, z)",
       [](double x, double y, double z) { return x * (1 - z) + y * z; },
       [](double x, double y, double z, double) {  // from x * (1 - z) + y * z, or x + (y - x) * z
         return Tolerance{2, 3 * ulp32(std::abs(x) + std::abs(y)) * (1 + std::abs(z))};
       },
       {-100, 100},
       {-100, 100},
       {0, 1}},
      {"smoothstep",
       "smoothstep(y, y + 3.0, x)",
       [](double x, double y, double) {
         const double high = static_cast<float>(y + 3), t = std::clamp((x - y) / (high - y), 0.0, 1.0);
         return t * t * (3 - 2 * t);
       },
       ulps(8, 0x1p-20),
       {-6, 8},
       {-5, 5}},
      {"ldexp",
       "ldexp(x, ivecN(y))",
       [](double x, double y, double) { return std::ldexp(x, static_cast<int>(y)); },
       ulps(1),
       {-100, 100},
       {-40, 40}},
  };
  return table;
}

double draw_from(Random& random, const Range& range) {
  if (!range.logarithmic) return static_cast<float>(random.between(range.low, range.high));
  return static_cast<float>(std::exp(random.between(std::log(range.low), std::log(range.high))));
}

std::string float_vector(int size) { return size == 1 ? "float" : fmt::format("vec{}", size); }

void run(Device& device, const Function& function, int size, VkShaderStageFlagBits stage, const std::string& name) {
  Random random(name);
  std::vector<Arguments> inputs(256);
  for (Arguments& input : inputs) {
    for (size_t i = 0; i < 4; ++i) {
      input.a[i] = as_bits(static_cast<float>(draw_from(random, function.x)));
      input.b[i] = as_bits(static_cast<float>(draw_from(random, function.y)));
      input.c[i] = as_bits(static_cast<float>(draw_from(random, function.z)));
    }
  }
  const std::string swizzle = std::string(".xyzw").substr(0, static_cast<size_t>(size) + 1), type = float_vector(size);
  std::string expression = function.expression;
  if (const size_t at = expression.find("ivecN"); at != std::string::npos) {
    expression.replace(at, 5, size == 1 ? "int" : fmt::format("ivec{}", size));
  }
  Snippet snippet;
  snippet.body = fmt::format(
      "{0} x = uintBitsToFloat(a{1}), y = uintBitsToFloat(b{1}), z = uintBitsToFloat(c{1});\nr{1} = floatBitsToUint({0}({2}));",
      type, swizzle, expression);
  const std::vector<Words4> results = evaluate(device, stage, snippet, inputs);
  for (size_t n = 0; n < inputs.size(); ++n) {
    for (size_t i = 0; i < static_cast<size_t>(size); ++i) {
      const double x = as_float(inputs[n].a[i]), y = as_float(inputs[n].b[i]), z = as_float(inputs[n].c[i]);
      const double exact = function.exact(x, y, z);
      const float got = as_float(results[n][i]);
      const Tolerance allowed = function.allowed(x, y, z, exact);
      expect(near_enough(got, exact, allowed),
             fmt::format("{} of {}, {}, {} gave {:.9g}, not {:.12g}: {:.1f} ULP, allowed {:.1f} and {:.3g}", function.name, x, y,
                         z, got, exact, std::abs(got - exact) / ulp32(exact), allowed.ulp, allowed.absolute));
    }
  }
}

}  // namespace

void register_glsl_builtins() {
  for (const Function& function : functions()) {
    for (const StageName& stage : kStages) {
      for (int size = 1; size <= 4; ++size) {
        const std::string name = fmt::format("{}.size{}_{}", function.name, size, stage.name);
        add_case("glsl.builtin.precision", name, "Appendix A, Precision and Operation of SPIR-V Instructions",
                 [&function, size, stage, name](Device& device) { run(device, function, size, stage.stage, name); });
      }
    }
  }
}

}  // namespace pineda::cts
