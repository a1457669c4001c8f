#include "compiler/kernels/texel.h"

#include <limits>

#include "base/srgb.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

// Adding 2^23 to 0 <= x < 2^23 rounds x to the nearest even integer and leaves it in the low bits; 1.5 * 2^23 does it for
// negative x too.
constexpr double kRoundUnsigned = 0x1p23, kRoundSigned = 0x1.8p23;

uint32_t low_bits(uint32_t bits) { return bits >= 32 ? ~0u : (1u << bits) - 1; }

bool is_signed(Numeric numeric) {
  return numeric == Numeric::kSnorm || numeric == Numeric::kSscaled || numeric == Numeric::kSint;
}

// The bits of a float that is known not to be a NaN, so no canonical form is needed.
Value raw_bits(Builder& b, Value v) { return b.op(Op::kBitcast, Type::kI32, {v}); }

Value to_float(Builder& b, const FormatInfo& format, uint32_t bits, Value code) {
  // Codes below 2^31 are cheaper to convert as signed.
  return b.convert(is_signed(format.numeric) || bits < 32 ? Op::kSToF : Op::kUToF, Type::kF32, code);
}

Value decode_float(Builder& b, uint32_t bits, Value code) {
  if (bits == 32) return b.bitcast(Type::kF32, code);
  return b.convert(Op::kFConvert, Type::kF32, b.bitcast(Type::kF16, b.convert(Op::kTrunc, Type::kI16, code)));
}

// A half without its sign and its lowest mantissa bits.
Value decode_ufloat(Builder& b, uint32_t bits, Value code) { return decode_float(b, 16, b.shl(code, b.i32(15 - bits))); }

// base/format_pack.cpp's ufloat.
Value encode_ufloat(Builder& b, uint32_t bits, Value value) {
  const uint32_t mantissa_bits = bits - 5, shift = 23 - mantissa_bits, infinity = 31u << mantissa_bits;
  const Value x = b.fmax(b.f32(0), value);  // NaN gives 0 until the select below
  const Value word = raw_bits(b, b.fmin(x, b.f32(65536)));
  const Value odd = b.and_(b.lshr(word, b.i32(shift)), b.i32(1));
  const Value rounded = b.lshr(b.iadd(b.iadd(word, b.i32((1u << (shift - 1)) - 1)), odd), b.i32(shift));
  const Value normal = b.umin(b.isub(rounded, b.i32(112u << mantissa_bits)), b.i32(infinity - 1));
  const double denormal_scale = static_cast<double>(1u << (14 + mantissa_bits));
  const Value scaled = b.fma(b.fmin(x, b.f32(1)), b.f32(denormal_scale), b.f32(kRoundUnsigned));
  const Value denormal = b.and_(raw_bits(b, scaled), b.i32((1u << (mantissa_bits + 1)) - 1));
  const Value finite = b.select(b.flt(x, b.f32(0x1p-14)), denormal, normal);
  const Value special = b.select(b.feq(value, value), b.i32(infinity), b.i32(infinity | 1u << (mantissa_bits - 1)));
  return b.select(b.flt(value, b.f32(std::numeric_limits<double>::infinity())), finite, special);
}

// base/format_pack.cpp's shared_exponent.
Value encode_shared_exponent(Builder& b, const Channels& values) {
  std::array<Value, 3> c;
  for (uint32_t i = 0; i < 3; ++i) c[i] = clamp(b, values[i], 0, 65408);
  const Value largest = b.fmax(b.fmax(c[0], c[1]), c[2]);
  const auto scale_of = [&](Value exponent) {
    return b.bitcast(Type::kF32, b.shl(b.isub(b.i32(127 + 24), exponent), b.i32(23)));
  };
  // To nearest, halves up; the product is exact.
  const auto mantissa = [&](Value x, Value scale) {
    const Value scaled = b.fmul(x, scale), whole = b.ffloor(scaled);
    const Value up = b.fle(b.f32(0.5), b.fsub(scaled, whole));
    return b.iadd(b.convert(Op::kFToS, Type::kI32, whole), b.convert(Op::kZExt, Type::kI32, up));
  };
  Value exponent = b.isub(b.umax(b.lshr(raw_bits(b, largest), b.i32(23)), b.i32(111)), b.i32(111));
  const Value carry = b.ieq(mantissa(largest, scale_of(exponent)), b.i32(512));
  exponent = b.iadd(exponent, b.convert(Op::kZExt, Type::kI32, carry));
  const Value scale = scale_of(exponent);
  Value word = b.shl(exponent, b.i32(27));
  for (uint32_t i = 0; i < 3; ++i) word = b.or_(word, b.shl(mantissa(c[i], scale), b.i32(9 * i)));
  return word;
}

Value srgb_table(Builder& b, size_t pointer_offset) {
  return b.load(Type::kPtr, b.draw_ptr(), static_cast<uint32_t>(pointer_offset), ir::kInvariant | ir::kSpeculate);
}

Value decode_srgb(Builder& b, Value code) {
  const ir::Address at{.base = srgb_table(b, offsetof(DrawContext, srgb_decode)), .offset = b.shl(code, b.i32(2))};
  return b.load(Type::kF32, at, ir::kInvariant | ir::kSpeculate);  // the code is below 256, whatever the lane holds
}

// base/srgb.h explains the table.
Value encode_srgb(Builder& b, Value linear) {
  const Value x = raw_bits(b, clamp(b, linear, kSrgbEncodeMin, 1));
  const Value entry_index = b.isub(b.lshr(x, b.i32(16)), b.i32(kSrgbEncodeFirst));
  const ir::Address at{.base = srgb_table(b, offsetof(DrawContext, srgb_encode)), .offset = b.shl(entry_index, b.i32(2))};
  const Value entry = b.load(Type::kI32, at, ir::kInvariant | ir::kSpeculate);  // clamped, so inside the table in any lane
  const Value next = b.ule(b.lshr(entry, b.i32(8)), b.and_(x, b.i32(0xffff)));
  return b.iadd(b.and_(entry, b.i32(0xff)), b.convert(Op::kZExt, Type::kI32, next));
}

}  // namespace

Words load_words(Builder& b, const FormatInfo& format, const ir::Address& at, uint8_t flags) {
  Words words{};
  const auto load = [&](Type type, uint32_t byte) {
    ir::Address part = at;
    if (byte > 0) part.offset = at.offset ? b.iadd(at.offset, b.i32(byte)) : b.i32(byte);
    return b.convert(Op::kZExt, Type::kI32, b.load(type, part, flags));
  };
  // Texels of 3 and 6 bytes end inside a word: its parts are loaded one by one.
  const Type part = format.texel_bytes % 4 == 0 ? Type::kI32 : format.texel_bytes % 2 == 0 ? Type::kI16 : Type::kI8;
  for (uint32_t byte = 0; byte < format.texel_bytes; byte += ir::size_bytes(part)) {
    Value& word = words[byte / 4];
    const Value value = load(part, byte);
    word = word ? b.or_(word, b.shl(value, b.i32(8 * (byte % 4)))) : value;
  }
  return words;
}

Value extract_code(Builder& b, const FormatInfo& format, uint32_t component, const Words& words) {
  const ComponentBits where = format.component[component];
  const Value word = words[where.first_bit / 32];
  const uint32_t shift = where.first_bit % 32;
  if (where.bits == 32) return word;
  if (is_signed(format.numeric)) {
    return b.ashr(b.shl(word, b.i32(32 - where.bits - shift)), b.i32(32 - where.bits));
  }
  const Value low = b.lshr(word, b.i32(shift));
  const bool top = shift + where.bits == 32 || (word_count(format) == 1 && shift + where.bits == format.texel_bytes * 8u);
  return top ? low : b.and_(low, b.i32(low_bits(where.bits)));
}

bool is_unorm(const FormatInfo& format, uint32_t component) {
  return format.numeric == Numeric::kUnorm || (format.numeric == Numeric::kSrgb && component == 3);
}

double code_scale(const FormatInfo& format, uint32_t component) {
  const uint32_t bits = format.component[component].bits;
  if (bits == 0) return 1;
  return format.numeric == Numeric::kSnorm ? low_bits(bits - 1) : low_bits(bits);
}

Value divide_by_constant(Builder& b, Value value, double scale) {
  // 1 / scale in two parts: the small one repairs the rounding of the large one, and the fma rounds once.
  const float high = static_cast<float>(1 / scale);
  const float low = static_cast<float>(1 / scale - high);
  if (low == 0) return b.fmul(value, b.f32(high));
  return b.fma(value, b.f32(high), b.fmul(value, b.f32(low)));
}

Value clamp(Builder& b, Value value, double low, double high) {
  return b.fmin(b.fmax(b.f32(low), value), b.f32(high));  // fmax gives its first operand for NaN
}

Value default_component(Builder& b, Type type, uint32_t component) {
  if (ir::is_float(type)) return b.fconst(type, component == 3 ? 1 : 0);
  return b.constant(type, component == 3 ? 1 : 0);
}

Value unpack_component(Builder& b, const FormatInfo& format, uint32_t component, const Words& words) {
  const uint32_t bits = format.component[component].bits;
  if (bits == 0) return default_component(b, channel_type(format), component);
  const Value code = extract_code(b, format, component, words);
  switch (format.numeric) {
    case Numeric::kUint:
    case Numeric::kSint:
      return code;
    case Numeric::kUscaled:
    case Numeric::kSscaled:
      return to_float(b, format, bits, code);
    case Numeric::kSfloat:
      return decode_float(b, bits, code);
    case Numeric::kUfloat:
      return decode_ufloat(b, bits, code);
    case Numeric::kSharedExp: {
      const Value exponent = b.lshr(words[0], b.i32(27));
      const Value scale = b.bitcast(Type::kF32, b.shl(b.iadd(exponent, b.i32(127 - 24)), b.i32(23)));
      return b.fmul(to_float(b, format, bits, code), scale);
    }
    case Numeric::kSnorm: {  // the most negative code is -1 too
      const Value value = divide_by_constant(b, to_float(b, format, bits, code), code_scale(format, component));
      return b.fmax(value, b.f32(-1));
    }
    case Numeric::kSrgb:
      if (component != 3) return decode_srgb(b, code);
      [[fallthrough]];
    case Numeric::kUnorm:
      return divide_by_constant(b, to_float(b, format, bits, code), code_scale(format, component));
  }
  return {};
}

Channels unpack(Builder& b, const FormatInfo& format, const Words& words) {
  Channels out;
  for (uint32_t c = 0; c < 4; ++c) out[c] = unpack_component(b, format, c, words);
  return out;
}

Field round_code(Builder& b, const FormatInfo& format, uint32_t component, Value code) {
  const uint32_t bits = format.component[component].bits;
  if (bits > 22) return {b.convert(Op::kFToS, Type::kI32, b.fround_even(code))};
  return {raw_bits(b, b.fadd(code, b.f32(kRoundUnsigned))), 24};
}

Field pack_component(Builder& b, const FormatInfo& format, uint32_t component, Value value) {
  const uint32_t bits = format.component[component].bits;
  if (format.is_integer()) return {value, bits};
  if (format.numeric == Numeric::kSrgb && component != 3) return {encode_srgb(b, value)};
  if (is_unorm(format, component)) {
    const Value x = clamp(b, value, 0, 1), scale = b.f32(code_scale(format, component));
    if (bits > 22) return round_code(b, format, component, b.fmul(x, scale));
    return {raw_bits(b, b.fma(x, scale, b.f32(kRoundUnsigned))), 24};
  }
  if (format.numeric == Numeric::kSnorm) {
    const Value x = clamp(b, value, -1, 1);
    return {raw_bits(b, b.fma(x, b.f32(code_scale(format, component)), b.f32(kRoundSigned))), bits};
  }
  if (format.numeric == Numeric::kUfloat) return {encode_ufloat(b, bits, value)};
  if (bits == 16) {
    const Value half = b.convert(Op::kFConvert, Type::kF16, value);
    return {b.convert(Op::kZExt, Type::kI32, b.bitcast(Type::kI16, half))};
  }
  return {b.bitcast(Type::kI32, value)};
}

Words pack_fields(Builder& b, const FormatInfo& format, const std::array<Field, 4>& fields) {
  Words words{};
  for (uint32_t c = 0; c < 4; ++c) {
    const ComponentBits where = format.component[c];
    if (where.bits == 0 || !fields[c].bits) continue;
    const uint32_t shift = where.first_bit % 32;
    Value field = fields[c].bits;
    if (where.bits < 32 && fields[c].clean_bits + shift < 32) field = b.and_(field, b.i32(low_bits(where.bits)));
    field = b.shl(field, b.i32(shift));
    Value& word = words[where.first_bit / 32];
    word = word ? b.or_(word, field) : field;
  }
  for (uint32_t w = 0; w < word_count(format); ++w) {
    if (!words[w]) words[w] = b.i32(0);
  }
  return words;
}

Words pack(Builder& b, const FormatInfo& format, const Channels& values) {
  if (format.numeric == Numeric::kSharedExp) return {encode_shared_exponent(b, values)};
  std::array<Field, 4> fields{};
  for (uint32_t c = 0; c < 4; ++c) {
    if (format.component[c].bits != 0) fields[c] = pack_component(b, format, c, values[c]);
  }
  return pack_fields(b, format, fields);
}

uint32_t component_mask(const FormatInfo& format, uint32_t w, uint32_t mask) {
  uint32_t bits = 0;
  for (uint32_t c = 0; c < 4; ++c) {
    const ComponentBits where = format.component[c];
    if (where.bits == 0 || where.first_bit / 32u != w || !(mask >> c & 1)) continue;
    bits |= low_bits(where.bits) << where.first_bit % 32;
  }
  return bits;
}

}  // namespace pineda::kernels
