// GLSL.std.450: functions that take floats apart.
#include <cmath>
#include <limits>

#include "compiler/spirv/glsl450.h"

namespace pineda::spirv {
namespace {

using ir::Type;
using ir::Value;

// The parameters of binary32 and binary64; halves are scaled and taken apart as binary32, which holds all their results.
struct Format {
  Type type, bits;
  int64_t mantissa_bits, bias;
};
constexpr Format kSingle{Type::kF32, Type::kI32, 23, 127}, kDouble{Type::kF64, Type::kI64, 52, 1023};
const Format& format_of(Type type) { return type == Type::kF64 ? kDouble : kSingle; }

// Arithmetic on a float and on exponents that are integers as wide as it.
struct Scaler {
  Translator& t;
  const Format& format;

  Value exponent(int64_t v) const { return t.b.constant(format.bits, static_cast<uint64_t>(v)); }
  Value power_of_two(int64_t n) const { return t.b.fconst(format.type, std::ldexp(1.0, static_cast<int>(n))); }
  int64_t lowest() const { return 1 - format.bias; }  // exponent of the smallest normal number

  // 2^n for the exponents of normal numbers
  Value normal_power(Value n) const {
    const Value biased = t.b.iadd(n, exponent(format.bias));
    return t.b.bitcast(format.type, t.b.shl(biased, exponent(format.mantissa_bits)));
  }

  // x * 2^n, rounded once: n is brought into the range of one factor by exact steps, up by the largest power or down by one that
  // leaves a whole significand above the denormals, so that only the last multiplication can round.
  Value scale(Value x, Value n) const {
    const int64_t up = format.bias, down = lowest() + format.mantissa_bits + 1;
    for (int i = 0; i < 2; ++i) {
      const Value high = t.b.slt(exponent(up), n), low = t.b.slt(n, exponent(lowest()));
      x = t.b.fmul(x, t.b.select(high, power_of_two(up), t.b.select(low, power_of_two(down), power_of_two(0))));
      n = t.b.isub(n, t.b.select(high, exponent(up), t.b.select(low, exponent(down), exponent(0))));
    }
    n = t.b.smax(t.b.smin(n, exponent(up)), exponent(lowest()));
    return t.b.fmul(x, normal_power(n));
  }
};

Value signed_resize(Translator& t, Value v, Type to) {
  if (t.b.type(v) == to) return v;
  return t.b.convert(ir::size_bytes(to) < ir::size_bytes(t.b.type(v)) ? ir::Op::kTrunc : ir::Op::kSExt, to, v);
}

Value widened(Translator& t, Value x) { return t.b.type(x) == Type::kF16 ? t.b.convert(ir::Op::kFConvert, Type::kF32, x) : x; }

void ldexp(Translator& t, const Instruction& inst) {
  Values x = glsl_operand(t, inst, 0, true);
  const Values n = glsl_operand(t, inst, 1, false, x.size());
  for (size_t i = 0; i < x.size(); ++i) {
    const Type type = t.b.type(x[i]);
    const Scaler scaler{t, format_of(type)};
    const Value exponent = signed_resize(t, n[i], scaler.format.bits);
    x[i] = t.b.convert(ir::Op::kFConvert, type, scaler.scale(widened(t, x[i]), exponent));
  }
  t.define(inst, std::move(x));
}

struct Parts {
  Values first, second;  // fraction and whole part, or significand and exponent
};

// Zero, infinities and NaN come back as the significand with exponent 0.
Parts frexp_parts(Translator& t, const Instruction& inst) {
  Parts out;
  for (Value narrow : glsl_operand(t, inst, 0, true)) {
    const Value x = widened(t, narrow);
    const Scaler s{t, format_of(t.b.type(x))};
    const int64_t mantissa = s.format.mantissa_bits;
    const Value magnitude = t.b.fabs(x), infinity = number(t, x, std::numeric_limits<double>::infinity());
    const Value is_ordinary = t.b.and_(t.b.flt(number(t, x, 0), magnitude), t.b.flt(magnitude, infinity));
    const Value is_small = t.b.flt(magnitude, s.power_of_two(s.lowest()));
    const Value normal = t.b.fmul(x, t.b.select(is_small, s.power_of_two(mantissa + 1), s.power_of_two(0)));
    const Value biased = t.b.lshr(t.b.bitcast(s.format.bits, t.b.fabs(normal)), s.exponent(mantissa));
    const Value exponent = t.b.isub(biased, s.exponent(s.format.bias - 1));  // of `normal`, significand in [0.5, 1)
    const Value significand = s.scale(normal, t.b.isub(s.exponent(0), exponent));
    out.first.push_back(t.b.convert(ir::Op::kFConvert, t.b.type(narrow), t.b.select(is_ordinary, significand, x)));
    const Value whole = t.b.isub(exponent, t.b.select(is_small, s.exponent(mantissa + 1), s.exponent(0)));
    out.second.push_back(t.b.select(is_ordinary, whole, s.exponent(0)));
  }
  return out;
}

// Whole part and fraction both have the sign of x; the fraction of an infinity is zero.
Parts modf_parts(Translator& t, const Instruction& inst) {
  Parts out;
  for (Value x : glsl_operand(t, inst, 0, true)) {
    const Value whole = t.b.ftrunc(x);
    out.first.push_back(t.b.select(t.b.feq(whole, x), number(t, x, 0), t.fsub(x, whole)));
    out.second.push_back(whole);
  }
  return out;
}

// Exponents in the width that the shader asks for.
void fit_second(Translator& t, const Instruction& inst, Parts& p, Type to) {
  for (Value& v : p.second) {
    if (ir::is_int(t.b.type(v)) && ir::is_int(to)) v = signed_resize(t, v, to);
    if (t.b.type(v) != to) inst.fail("the second result does not have its type");
  }
}

template <Parts (*kParts)(Translator&, const Instruction&)>
void to_struct(Translator& t, const Instruction& inst) {
  Parts p = kParts(t, inst);
  const std::vector<Type> wanted = t.m.flat_scalars(inst.word(1));
  if (wanted.size() != 2 * p.first.size()) inst.fail("the result is not a struct of two parts");
  fit_second(t, inst, p, wanted.back());
  p.first.insert(p.first.end(), p.second.begin(), p.second.end());
  t.define(inst, std::move(p.first));
}

template <Parts (*kParts)(Translator&, const Instruction&)>
void to_pointer(Translator& t, const Instruction& inst) {
  Parts p = kParts(t, inst);
  const Pointer to = t.pointer(inst, kFirstOperand + 1);
  fit_second(t, inst, p, t.component_of(t.m.type(to.pointee)));
  t.store(inst, to, p.second);
  t.define(inst, std::move(p.first));
}

constexpr ExtRow kRows[] = {
    PINEDA_GLSL_ROW(Ldexp, 2, ldexp),
    PINEDA_GLSL_ROW(Frexp, 2, to_pointer<frexp_parts>),
    PINEDA_GLSL_ROW(FrexpStruct, 1, to_struct<frexp_parts>),
    PINEDA_GLSL_ROW(Modf, 2, to_pointer<modf_parts>),
    PINEDA_GLSL_ROW(ModfStruct, 1, to_struct<modf_parts>),
};

}  // namespace

std::span<const ExtRow> glsl_exponent_rows() { return kRows; }

}  // namespace pineda::spirv
