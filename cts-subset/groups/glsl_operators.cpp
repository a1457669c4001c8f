// glsl.operators: the integer, logical and exact float operators of GLSL, in every stage and vector size, against the same
// operator here.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/evaluate.h"
#include "cts-subset/reference/float32.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

enum class Type { kFloat, kInt, kUint, kBool };

struct Operator {
  const char* name;
  const char* expression;  // of x, y, z
  Type in, out;
  std::function<uint32_t(uint32_t, uint32_t, uint32_t)> exact;
  enum class Inputs { kAny, kShift, kNonZeroDivisor, kSmallIndex } inputs = Inputs::kAny;
};

uint32_t of(bool value) { return value ? 1 : 0; }
int32_t s(uint32_t bits) { return static_cast<int32_t>(bits); }
uint32_t u(int64_t value) { return static_cast<uint32_t>(value); }
float f(uint32_t bits) { return as_float(bits); }

uint32_t find_msb_signed(uint32_t v) {
  const uint32_t magnitude = s(v) < 0 ? ~v : v;
  return magnitude ? 31u - static_cast<uint32_t>(std::countl_zero(magnitude)) : ~0u;
}

uint32_t reverse_bits(uint32_t v) {
  uint32_t out = 0;
  for (int i = 0; i < 32; ++i) out |= (v >> i & 1) << (31 - i);
  return out;
}

uint32_t extract(uint32_t v, uint32_t offset, uint32_t count, bool sign) {
  if (count == 0) return 0;
  const uint32_t field = static_cast<uint32_t>((uint64_t{v} >> offset) & ((uint64_t{1} << count) - 1));
  return sign && count < 32 && (field >> (count - 1) & 1) ? field | ~0u << count : field;
}

const std::vector<Operator>& operators() {
  using I = Operator::Inputs;
  static const std::vector<Operator> table = {
      {"add_int", "x + y", Type::kInt, Type::kInt, [](auto a, auto b, auto) { return a + b; }},
      {"sub_int", "x - y", Type::kInt, Type::kInt, [](auto a, auto b, auto) { return a - b; }},
      {"mul_int", "x * y", Type::kInt, Type::kInt, [](auto a, auto b, auto) { return a * b; }},
      {"div_int", "x / y", Type::kInt, Type::kInt, [](auto a, auto b, auto) { return u(int64_t{s(a)} / s(b)); },
       I::kNonZeroDivisor},
      {"negate_int", "-x", Type::kInt, Type::kInt, [](auto a, auto, auto) { return 0 - a; }},
      {"abs_int", "abs(x)", Type::kInt, Type::kInt, [](auto a, auto, auto) { return s(a) < 0 ? 0 - a : a; }},
      {"sign_int", "sign(x)", Type::kInt, Type::kInt, [](auto a, auto, auto) { return u(s(a) > 0   ? 1
                                                                                        : s(a) < 0 ? -1
                                                                                                   : 0); }},
      {"min_int", "min(x, y)", Type::kInt, Type::kInt, [](auto a, auto b, auto) { return u(std::min(s(a), s(b))); }},
      {"max_int", "max(x, y)", Type::kInt, Type::kInt, [](auto a, auto b, auto) { return u(std::max(s(a), s(b))); }},
      {"shift_left_int", "x << (y & 31)", Type::kInt, Type::kInt, [](auto a, auto b, auto) { return a << (b & 31); }},
      {"shift_right_int", "x >> (y & 31)", Type::kInt, Type::kInt, [](auto a, auto b, auto) { return u(s(a) >> (b & 31)); }},
      {"find_msb_int", "findMSB(x)", Type::kInt, Type::kInt, [](auto a, auto, auto) { return find_msb_signed(a); }},
      {"less_int", "lessThan(x, y)", Type::kInt, Type::kBool, [](auto a, auto b, auto) { return of(s(a) < s(b)); }},
      {"greater_equal_int", "greaterThanEqual(x, y)", Type::kInt, Type::kBool,
       [](auto a, auto b, auto) { return of(s(a) >= s(b)); }},
      {"int_to_float", "T_FLOAT(x)", Type::kInt, Type::kFloat, nullptr},
      {"add_uint", "x + y", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a + b; }},
      {"mul_uint", "x * y", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a * b; }},
      {"div_uint", "x / y", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a / b; }, I::kNonZeroDivisor},
      {"mod_uint", "x % y", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a % b; }, I::kNonZeroDivisor},
      {"and_uint", "x & y", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a & b; }},
      {"or_uint", "x | y", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a | b; }},
      {"xor_uint", "x ^ y", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a ^ b; }},
      {"not_uint", "~x", Type::kUint, Type::kUint, [](auto a, auto, auto) { return ~a; }},
      {"shift_left_uint", "x << (y & 31u)", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a << (b & 31); }},
      {"shift_right_uint", "x >> (y & 31u)", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return a >> (b & 31); }},
      {"min_uint", "min(x, y)", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return std::min(a, b); }},
      {"max_uint", "max(x, y)", Type::kUint, Type::kUint, [](auto a, auto b, auto) { return std::max(a, b); }},
      {"clamp_uint", "clamp(x, min(y, z), max(y, z))", Type::kUint, Type::kUint,
       [](auto a, auto b, auto c) { return std::clamp(a, std::min(b, c), std::max(b, c)); }},
      {"bit_count", "uvecN(bitCount(x))", Type::kUint, Type::kUint, [](auto a, auto, auto) { return u(std::popcount(a)); }},
      {"bit_reverse", "bitfieldReverse(x)", Type::kUint, Type::kUint, [](auto a, auto, auto) { return reverse_bits(a); }},
      {"find_lsb", "uvecN(findLSB(x))", Type::kUint, Type::kUint,
       [](auto a, auto, auto) { return a ? u(std::countr_zero(a)) : ~0u; }},
      {"find_msb", "uvecN(findMSB(x))", Type::kUint, Type::kUint,
       [](auto a, auto, auto) { return a ? 31u - u(std::countl_zero(a)) : ~0u; }},
      {"bitfield_extract_uint", "bitfieldExtract(x, 7, 11)", Type::kUint, Type::kUint,
       [](auto a, auto, auto) { return extract(a, 7, 11, false); }},
      {"bitfield_extract_int", "bitfieldExtract(x, 5, 13)", Type::kInt, Type::kInt,
       [](auto a, auto, auto) { return extract(a, 5, 13, true); }},
      {"bitfield_extract_none", "bitfieldExtract(x, 9, 0)", Type::kUint, Type::kUint, [](auto, auto, auto) { return 0u; }},
      {"bitfield_extract_all", "bitfieldExtract(x, 0, 32)", Type::kInt, Type::kInt, [](auto a, auto, auto) { return a; }},
      {"bitfield_insert", "bitfieldInsert(x, y, 9, 6)", Type::kUint, Type::kUint,
       [](auto a, auto b, auto) { return (a & ~(63u << 9)) | (b & 63u) << 9; }},
      {"uint_to_float", "T_FLOAT(x)", Type::kUint, Type::kFloat, nullptr},
      {"equal_uint", "equal(x, y)", Type::kUint, Type::kBool, [](auto a, auto b, auto) { return of(a == b); }},
      {"less_uint", "lessThan(x, y)", Type::kUint, Type::kBool, [](auto a, auto b, auto) { return of(a < b); }},
      {"less_float", "lessThan(x, y)", Type::kFloat, Type::kBool, [](auto a, auto b, auto) { return of(f(a) < f(b)); }},
      {"less_equal_float", "lessThanEqual(x, y)", Type::kFloat, Type::kBool,
       [](auto a, auto b, auto) { return of(f(a) <= f(b)); }},
      {"equal_float", "equal(x, y)", Type::kFloat, Type::kBool, [](auto a, auto b, auto) { return of(f(a) == f(b)); }},
      {"not_equal_float", "notEqual(x, y)", Type::kFloat, Type::kBool, [](auto a, auto b, auto) { return of(f(a) != f(b)); }},
      {"negate_float", "-x", Type::kFloat, Type::kFloat, [](auto a, auto, auto) { return as_bits(-f(a)); }},
      {"abs_float", "abs(x)", Type::kFloat, Type::kFloat, [](auto a, auto, auto) { return as_bits(std::abs(f(a))); }},
      {"min_float", "min(x, y)", Type::kFloat, Type::kFloat, [](auto a, auto b, auto) { return as_bits(std::min(f(a), f(b))); }},
      {"max_float", "max(x, y)", Type::kFloat, Type::kFloat, [](auto a, auto b, auto) { return as_bits(std::max(f(a), f(b))); }},
      {"floor", "floor(x)", Type::kFloat, Type::kFloat, [](auto a, auto, auto) { return as_bits(std::floor(f(a))); }},
      {"ceil", "ceil(x)", Type::kFloat, Type::kFloat, [](auto a, auto, auto) { return as_bits(std::ceil(f(a))); }},
      {"trunc", "trunc(x)", Type::kFloat, Type::kFloat, [](auto a, auto, auto) { return as_bits(std::trunc(f(a))); }},
      {"round_even", "roundEven(x)", Type::kFloat, Type::kFloat,
       [](auto a, auto, auto) { return as_bits(std::nearbyint(f(a))); }},
      {"float_to_int", "ivecN(x)", Type::kFloat, Type::kInt, [](auto a, auto, auto) { return u(static_cast<int32_t>(f(a))); }},
      {"logical_and", "bvecN(x.N && y.N)", Type::kBool, Type::kBool, [](auto a, auto b, auto) { return of(a && b); }},
      {"logical_not", "not(x)", Type::kBool, Type::kBool, [](auto a, auto, auto) { return of(!a); }},
      {"mix_bool", "mix(x, y, greaterThan(z, x))", Type::kInt, Type::kInt,
       [](auto a, auto b, auto c) { return s(c) > s(a) ? b : a; }},
  };
  return table;
}

const char* prefix(Type type) { return type == Type::kFloat ? "" : type == Type::kInt ? "i" : type == Type::kUint ? "u" : "b"; }

std::string vector_of(Type type, int size) {
  if (size > 1) return fmt::format("{}vec{}", prefix(type), size);
  return type == Type::kFloat ? "float" : type == Type::kInt ? "int" : type == Type::kUint ? "uint" : "bool";
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) text.replace(at, from.size(), to);
}

std::string read_expression(Type type, int size, char argument) {
  const std::string swizzle = std::string(".xyzw").substr(0, static_cast<size_t>(size) + 1);
  const std::string raw = std::string(1, argument) + swizzle;
  switch (type) {
    case Type::kFloat:
      return "uintBitsToFloat(" + raw + ")";
    case Type::kBool:
      return size == 1 ? "bool(" + raw + " & 1u)" : fmt::format("{}({} & 1u)", vector_of(type, size), raw);
    default:
      return fmt::format("{}({})", vector_of(type, size), raw);
  }
}

// Relational operators take vectors only; sizes 1 of them and of the componentwise logical ones are written with scalars.
std::string expression_for(const Operator& op, int size) {
  std::string text = op.expression;
  static const std::pair<const char*, const char*> kRelational[] = {
      {"lessThan(x, y)", "x < y"},   {"lessThanEqual(x, y)", "x <= y"},    {"equal(x, y)", "x == y"},
      {"notEqual(x, y)", "x != y"},  {"greaterThanEqual(x, y)", "x >= y"}, {"not(x)", "!x"},
      {"greaterThan(z, x)", "z > x"}};
  if (std::string(op.name) == "logical_and") {
    if (size == 1) return "x && y";
    std::string parts;
    for (int i = 0; i < size; ++i) parts += fmt::format("{}x[{}] && y[{}]", i ? ", " : "", i, i);
    return vector_of(Type::kBool, size) + "(" + parts + ")";
  }
  if (size == 1) {
    for (const auto& [vector_form, scalar_form] : kRelational) {
      if (text == vector_form) return scalar_form;
      replace_all(text, vector_form, scalar_form);
    }
  }
  replace_all(text, "T_FLOAT", vector_of(Type::kFloat, size));
  replace_all(text, "uvecN", vector_of(Type::kUint, size));
  replace_all(text, "ivecN", vector_of(Type::kInt, size));
  return text;
}

std::string write_expression(Type type, int size) {
  const std::string swizzle = std::string(".xyzw").substr(0, static_cast<size_t>(size) + 1);
  if (type == Type::kFloat) return "r" + swizzle + " = floatBitsToUint(out_value);";
  return fmt::format("r{} = {}(out_value);", swizzle, vector_of(Type::kUint, size));
}

uint32_t random_input(const Operator& op, Random& random, bool divisor) {
  static constexpr uint32_t kEdges[] = {0, 1, 2, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x80000001, 31, 32, 0x55555555};
  if (op.in == Type::kFloat) {  // normal numbers in the range of int, halves among them
    const double value = random.below(4) ? random.between(-2e9, 2e9) : random.below(2001) * 0.5 - 500;
    return as_bits(static_cast<float>(random.below(2) ? value : value * 1e-6));
  }
  uint32_t bits = random.below(3) ? random.bits() >> random.below(32) : kEdges[random.below(std::size(kEdges))];
  if (divisor && (bits == 0 || bits == ~0u)) bits = 3;  // and INT_MIN / -1 is undefined
  return bits;
}

void run(Device& device, const Operator& op, int size, VkShaderStageFlagBits stage, const std::string& name) {
  Random random(name);
  std::vector<Arguments> inputs(256);
  const bool divides = op.inputs == Operator::Inputs::kNonZeroDivisor;
  for (Arguments& input : inputs) {
    for (size_t i = 0; i < 4; ++i) {
      input.a[i] = random_input(op, random, false);
      input.b[i] = random.below(8) ? random_input(op, random, divides) : input.a[i];
      if (divides && (input.b[i] == 0 || input.b[i] == ~0u)) input.b[i] = 5;
      input.c[i] = random_input(op, random, false);
    }
  }
  Snippet snippet;
  const std::string type = vector_of(op.in, size);
  snippet.body =
      fmt::format("{0} x = {1}, y = {2}, z = {3};\n{4} out_value = {4}({5});\n{6}", type, read_expression(op.in, size, 'a'),
                  read_expression(op.in, size, 'b'), read_expression(op.in, size, 'c'), vector_of(op.out, size),
                  expression_for(op, size), write_expression(op.out, size));
  const std::vector<Words4> results = evaluate(device, stage, snippet, inputs);
  for (size_t n = 0; n < inputs.size(); ++n) {
    for (size_t i = 0; i < static_cast<size_t>(size); ++i) {
      uint32_t a = inputs[n].a[i], b = inputs[n].b[i], c = inputs[n].c[i];
      if (op.in == Type::kBool) a &= 1, b &= 1, c &= 1;
      if (!op.exact) {  // integer to float: correctly rounded, in an open rounding mode
        const double exact = op.in == Type::kInt ? double{s(a) * 1.0} : double{a * 1.0};
        expect(near_enough(f(results[n][i]), exact, {1, 0}), fmt::format("{:#x} became {}, not {}", a, f(results[n][i]), exact));
        continue;
      }
      const uint32_t want = op.exact(a, b, c), got = results[n][i];
      const bool both_zero = op.out == Type::kFloat && f(want) == 0 && f(got) == 0;  // GLSL leaves the sign of zero open here
      expect(want == got || both_zero,
             fmt::format("{} of {:#x}, {:#x}, {:#x} gave {:#x}, not {:#x}", op.name, a, b, c, got, want));
    }
  }
}

}  // namespace

void register_glsl_operators() {
  for (const Operator& op : operators()) {
    for (const StageName& stage : kStages) {
      for (int size = 1; size <= 4; ++size) {
        const std::string name = fmt::format("{}.size{}_{}", op.name, size, stage.name);
        add_case("glsl.operators", name, "GLSL 4.60, 5.9 Expressions, 8.8 Integer Functions; SPIR-V 3.49",
                 [&op, size, stage, name](Device& device) { run(device, op, size, stage.stage, name); });
      }
    }
  }
}

}  // namespace pineda::cts
