#include "compiler/ir/semantics.h"

#include <bit>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/abi.h"

namespace pineda::ir {
namespace {

// ---- formats: how raw bits and the number they stand for relate ------------------------------------------------------------

// Arithmetic on halves in binary32, rounded once more, is correctly rounded for + - * / sqrt, because 24 >= 2 * 11 + 2 (S. A.
// Figueroa, "When is double rounding innocuous?", 1995).
struct Half {
  static constexpr uint64_t kSign = 0x8000, kCanonicalNan = 0x7E00;
  static float get(uint64_t raw) { return static_cast<float>(double_from_half(static_cast<uint16_t>(raw))); }
  static uint64_t put(double v) { return half_from_double(v); }
};

struct Single {
  static constexpr uint64_t kSign = 0x80000000, kCanonicalNan = 0x7FC00000;
  static float get(uint64_t raw) { return std::bit_cast<float>(static_cast<uint32_t>(raw)); }
  static uint64_t put(float v) { return std::bit_cast<uint32_t>(v); }
};

struct Double {
  static constexpr uint64_t kSign = 1ull << 63, kCanonicalNan = 0x7FF8000000000000;
  static double get(uint64_t raw) { return std::bit_cast<double>(raw); }
  static uint64_t put(double v) { return std::bit_cast<uint64_t>(v); }
};

// ---- lanes ----------------------------------------------------------------------------------------------------------------

template <auto kFn>
void lanes1(uint64_t* out, const uint64_t* a, const uint64_t*, const uint64_t*) {
  for (uint32_t l = 0; l < kLanes; ++l) out[l] = kFn(a[l]);
}

template <auto kFn>
void lanes2(uint64_t* out, const uint64_t* a, const uint64_t* b, const uint64_t*) {
  for (uint32_t l = 0; l < kLanes; ++l) out[l] = kFn(a[l], b[l]);
}

template <auto kFn>
void lanes3(uint64_t* out, const uint64_t* a, const uint64_t* b, const uint64_t* c) {
  for (uint32_t l = 0; l < kLanes; ++l) out[l] = kFn(a[l], b[l], c[l]);
}

// ---- integers: U is unsigned and as wide as the type ------------------------------------------------------------------------

template <class U>
struct Int {
  using S = std::make_signed_t<U>;
  static constexpr uint32_t kBits = 8 * sizeof(U);
  static S s(uint64_t raw) { return static_cast<S>(static_cast<U>(raw)); }
  static uint64_t raw(U v) { return v; }

  static uint64_t umul_hi(uint64_t a, uint64_t b) {
    return raw(static_cast<U>((static_cast<unsigned __int128>(a) * b) >> kBits));
  }
  static uint64_t madd16(uint64_t a, uint64_t b) {  // I32 only
    const auto product = [&](uint32_t shift) {
      return static_cast<int32_t>(static_cast<int16_t>(a >> shift)) * static_cast<int32_t>(static_cast<int16_t>(b >> shift));
    };
    return raw(static_cast<U>(static_cast<uint32_t>(product(0)) + static_cast<uint32_t>(product(16))));
  }
  static uint64_t smul_hi(uint64_t a, uint64_t b) { return raw(static_cast<U>((static_cast<__int128>(s(a)) * s(b)) >> kBits)); }
  static uint64_t udiv(uint64_t a, uint64_t b) { return b == 0 ? raw(static_cast<U>(~0ull)) : a / b; }
  static uint64_t urem(uint64_t a, uint64_t b) { return b == 0 ? a : a % b; }
  static uint64_t sdiv(uint64_t a, uint64_t b) {
    if (b == 0) return raw(static_cast<U>(~0ull));
    if (s(b) == -1) return raw(static_cast<U>(0 - a));  // INT_MIN / -1 wraps
    return raw(static_cast<U>(s(a) / s(b)));
  }
  static uint64_t srem(uint64_t a, uint64_t b) {
    if (b == 0) return a;
    if (s(b) == -1) return 0;
    return raw(static_cast<U>(s(a) % s(b)));
  }
  static uint64_t lshr(uint64_t a, uint64_t b) { return a >> (b % kBits); }
  static uint64_t ashr(uint64_t a, uint64_t b) { return raw(static_cast<U>(s(a) >> (b % kBits))); }
  static uint64_t bit_reverse(uint64_t a) {
    uint64_t out = 0;
    for (uint32_t i = 0; i < kBits; ++i) out |= ((a >> i) & 1) << (kBits - 1 - i);
    return out;
  }

  static LaneFn fn(Op op) {
    switch (op) {
      case Op::kIAdd:
        return lanes2<[](uint64_t a, uint64_t b) { return raw(static_cast<U>(a + b)); }>;
      case Op::kISub:
        return lanes2<[](uint64_t a, uint64_t b) { return raw(static_cast<U>(a - b)); }>;
      case Op::kIMul:
        return lanes2<[](uint64_t a, uint64_t b) { return raw(static_cast<U>(a * b)); }>;
      case Op::kUMulHi:
        return lanes2<umul_hi>;
      case Op::kSMulHi:
        return lanes2<smul_hi>;
      case Op::kMAdd16:
        return lanes2<madd16>;
      case Op::kUDiv:
        return lanes2<udiv>;
      case Op::kSDiv:
        return lanes2<sdiv>;
      case Op::kURem:
        return lanes2<urem>;
      case Op::kSRem:
        return lanes2<srem>;
      case Op::kShl:
        return lanes2<[](uint64_t a, uint64_t b) { return raw(static_cast<U>(a << (b % kBits))); }>;
      case Op::kLShr:
        return lanes2<lshr>;
      case Op::kAShr:
        return lanes2<ashr>;
      case Op::kNot:
        return lanes1<[](uint64_t a) { return raw(static_cast<U>(~a)); }>;
      case Op::kSMin:
        return lanes2<[](uint64_t a, uint64_t b) { return s(b) < s(a) ? b : a; }>;
      case Op::kSMax:
        return lanes2<[](uint64_t a, uint64_t b) { return s(a) < s(b) ? b : a; }>;
      case Op::kUMin:
        return lanes2<[](uint64_t a, uint64_t b) { return b < a ? b : a; }>;
      case Op::kUMax:
        return lanes2<[](uint64_t a, uint64_t b) { return a < b ? b : a; }>;
      case Op::kClz:
        return lanes1<[](uint64_t a) -> uint64_t { return std::countl_zero(static_cast<U>(a)); }>;
      case Op::kCtz:
        return lanes1<[](uint64_t a) -> uint64_t { return std::countr_zero(static_cast<U>(a)); }>;
      case Op::kPopCount:
        return lanes1<[](uint64_t a) -> uint64_t { return std::popcount(a); }>;
      case Op::kBitReverse:
        return lanes1<bit_reverse>;
      case Op::kSLt:
        return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return s(a) < s(b); }>;
      case Op::kSLe:
        return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return s(a) <= s(b); }>;
      case Op::kTrunc:
        return lanes1<[](uint64_t a) { return raw(static_cast<U>(a)); }>;  // U: the result's type
      default:
        return nullptr;
    }
  }
};

// Operations whose raw form does not depend on the width.
LaneFn widthless_fn(Op op) {
  switch (op) {
    case Op::kAnd:
      return lanes2<[](uint64_t a, uint64_t b) { return a & b; }>;
    case Op::kOr:
      return lanes2<[](uint64_t a, uint64_t b) { return a | b; }>;
    case Op::kXor:
      return lanes2<[](uint64_t a, uint64_t b) { return a ^ b; }>;
    case Op::kIEq:
      return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return a == b; }>;
    case Op::kINe:
      return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return a != b; }>;
    case Op::kULt:
      return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return a < b; }>;
    case Op::kULe:
      return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return a <= b; }>;
    case Op::kZExt:
      return lanes1<[](uint64_t a) { return a; }>;
    case Op::kPtrAdd:
      return lanes2<[](uint64_t a, uint64_t b) { return a + b; }>;
    case Op::kSelect:
      return lanes3<[](uint64_t c, uint64_t a, uint64_t b) { return c != 0 ? a : b; }>;
    case Op::kUnpackMask:
      return [](uint64_t* out, const uint64_t* a, const uint64_t*, const uint64_t*) {
        for (uint32_t l = 0; l < kLanes; ++l) out[l] = (a[l] >> l) & 1;
      };
    default:
      return nullptr;
  }
}

template <class Fn>
LaneFn with_int(Type type, Fn&& fn) {
  switch (type) {
    case Type::kI8:
      return fn(uint8_t{});
    case Type::kI16:
      return fn(uint16_t{});
    case Type::kI32:
      return fn(uint32_t{});
    case Type::kI64:
      return fn(uint64_t{});
    default:
      return nullptr;
  }
}

LaneFn sign_extend_fn(Type from, Type to) {
  if (from == Type::kB1) {
    return with_int(
        to, [](auto u) -> LaneFn { return lanes1<[](uint64_t a) -> uint64_t { return static_cast<decltype(u)>(0 - a); }>; });
  }
  return with_int(from, [to](auto f) -> LaneFn {
    return with_int(to, [](auto t) -> LaneFn {
      return lanes1<[](uint64_t a) -> uint64_t {
        return static_cast<decltype(t)>(static_cast<std::make_signed_t<decltype(f)>>(a));
      }>;
    });
  });
}

// ---- floats ---------------------------------------------------------------------------------------------------------------

// The exact sum of doubles p and c rounded to odd, so that rounding it again to a narrower format is correct (S. Boldo and G.
// Melquiond, "Emulation of a FMA and correctly rounded sums: proved algorithms using rounding to odd", 2008).
double add_round_to_odd(double p, double c) {
  const double sum = p + c;
  const double c_part = sum - p;
  const double error = (p - (sum - c_part)) + (c - c_part);  // Knuth's two-sum: p + c == sum + error
  if (error == 0 || !std::isfinite(sum)) return sum;
  const auto bits = std::bit_cast<uint64_t>(sum);
  if (bits & 1) return sum;
  const bool away = (error > 0) == (sum > 0);  // the exact value has the larger magnitude
  return std::bit_cast<double>(away ? bits + 1 : bits - 1);
}

template <class T>
uint64_t fma_raw(uint64_t a, uint64_t b, uint64_t c) {
  if constexpr (std::is_same_v<T, Half>) {  // the product of two halves is exact in double
    return T::put(add_round_to_odd(static_cast<double>(T::get(a)) * T::get(b), T::get(c)));
  } else {
    return T::put(std::fma(T::get(a), T::get(b), T::get(c)));
  }
}

template <class T>
LaneFn float_fn(Op op) {
  switch (op) {
    case Op::kFAdd:
      return lanes2<[](uint64_t a, uint64_t b) { return T::put(T::get(a) + T::get(b)); }>;
    case Op::kFSub:
      return lanes2<[](uint64_t a, uint64_t b) { return T::put(T::get(a) - T::get(b)); }>;
    case Op::kFMul:
      return lanes2<[](uint64_t a, uint64_t b) { return T::put(T::get(a) * T::get(b)); }>;
    case Op::kFDiv:
      return lanes2<[](uint64_t a, uint64_t b) { return T::put(T::get(a) / T::get(b)); }>;
    case Op::kFMa:
      return lanes3<fma_raw<T>>;
    case Op::kFSqrt:
      return lanes1<[](uint64_t a) { return T::put(std::sqrt(T::get(a))); }>;
    case Op::kFNeg:
      return lanes1<[](uint64_t a) { return a ^ T::kSign; }>;
    case Op::kFAbs:
      return lanes1<[](uint64_t a) { return a & ~T::kSign; }>;
    case Op::kFMin:
      return lanes2<[](uint64_t a, uint64_t b) { return T::get(b) < T::get(a) ? b : a; }>;
    case Op::kFMax:
      return lanes2<[](uint64_t a, uint64_t b) { return T::get(a) < T::get(b) ? b : a; }>;
    case Op::kFFloor:
      return lanes1<[](uint64_t a) { return T::put(std::floor(T::get(a))); }>;
    case Op::kFCeil:
      return lanes1<[](uint64_t a) { return T::put(std::ceil(T::get(a))); }>;
    case Op::kFTrunc:
      return lanes1<[](uint64_t a) { return T::put(std::trunc(T::get(a))); }>;
    case Op::kFRoundEven:
      return lanes1<[](uint64_t a) { return T::put(std::nearbyint(T::get(a))); }>;
    case Op::kFCanon:
      return lanes1<[](uint64_t a) { return std::isnan(T::get(a)) ? T::kCanonicalNan : a; }>;
    case Op::kFEq:
      return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return T::get(a) == T::get(b); }>;
    case Op::kFNe:
      return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return T::get(a) != T::get(b); }>;
    case Op::kFLt:
      return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return T::get(a) < T::get(b); }>;
    case Op::kFLe:
      return lanes2<[](uint64_t a, uint64_t b) -> uint64_t { return T::get(a) <= T::get(b); }>;
    default:
      return nullptr;
  }
}

template <auto kFn>
void libm1(uint64_t* out, const uint64_t* a, const uint64_t*, const uint64_t*) {
  for (uint32_t l = 0; l < kLanes; ++l) out[l] = Double::put(kFn(Double::get(a[l])));
}

template <auto kFn>
void libm2(uint64_t* out, const uint64_t* a, const uint64_t* b, const uint64_t*) {
  for (uint32_t l = 0; l < kLanes; ++l) out[l] = Double::put(kFn(Double::get(a[l]), Double::get(b[l])));
}

// The truth that polynomials are measured against; never used by what the bit contract covers.
LaneFn transcendental_fn(Op op) {
  switch (op) {
    case Op::kFSin:
      return libm1<[](double x) { return std::sin(x); }>;
    case Op::kFCos:
      return libm1<[](double x) { return std::cos(x); }>;
    case Op::kFTan:
      return libm1<[](double x) { return std::tan(x); }>;
    case Op::kFAsin:
      return libm1<[](double x) { return std::asin(x); }>;
    case Op::kFAcos:
      return libm1<[](double x) { return std::acos(x); }>;
    case Op::kFAtan:
      return libm1<[](double x) { return std::atan(x); }>;
    case Op::kFAtan2:
      return libm2<[](double y, double x) { return std::atan2(y, x); }>;
    case Op::kFSinh:
      return libm1<[](double x) { return std::sinh(x); }>;
    case Op::kFCosh:
      return libm1<[](double x) { return std::cosh(x); }>;
    case Op::kFTanh:
      return libm1<[](double x) { return std::tanh(x); }>;
    case Op::kFAsinh:
      return libm1<[](double x) { return std::asinh(x); }>;
    case Op::kFAcosh:
      return libm1<[](double x) { return std::acosh(x); }>;
    case Op::kFAtanh:
      return libm1<[](double x) { return std::atanh(x); }>;
    case Op::kFRsqrt:
      return libm1<[](double x) { return 1 / std::sqrt(x); }>;
    case Op::kFExp2:
      return libm1<[](double x) { return std::exp2(x); }>;
    case Op::kFLog2:
      return libm1<[](double x) { return std::log2(x); }>;
    case Op::kFLog2Coarse:
      return libm1<[](double x) { return std::log2(x > 0x1p-126 ? x : 0x1p-126); }>;
    case Op::kFExp:
      return libm1<[](double x) { return std::exp(x); }>;
    case Op::kFLog:
      return libm1<[](double x) { return std::log(x); }>;
    case Op::kFPow:
      return libm2<[](double x, double y) { return std::pow(x, y); }>;
    default:
      return nullptr;
  }
}

// ---- conversions ----------------------------------------------------------------------------------------------------------

template <class U>
uint64_t to_signed(double v) {  // binary16 and binary32 widen to double exactly
  using S = std::make_signed_t<U>;
  constexpr double kEnd = static_cast<double>(1ull << (8 * sizeof(U) - 1));
  if (std::isnan(v)) return 0;
  if (v >= kEnd) return static_cast<U>(std::numeric_limits<S>::max());
  if (v < -kEnd) return static_cast<U>(std::numeric_limits<S>::min());
  return static_cast<U>(static_cast<int64_t>(v));
}

template <class U>
uint64_t to_unsigned(double v) {
  constexpr double kEnd = 2.0 * static_cast<double>(1ull << (8 * sizeof(U) - 1));
  if (!(v > 0)) return 0;  // NaN too
  if (v >= kEnd) return std::numeric_limits<U>::max();
  return static_cast<U>(static_cast<uint64_t>(v));
}

template <class T>
LaneFn float_to_int_fn(Op op, Type to) {
  return with_int(to, [op](auto u) -> LaneFn {
    using U = decltype(u);
    if (op == Op::kFToS) return lanes1<[](uint64_t a) { return to_signed<U>(T::get(a)); }>;
    return lanes1<[](uint64_t a) { return to_unsigned<U>(T::get(a)); }>;
  });
}

// One rounding: from the integer to binary32 or binary64. To binary16 by way of double, which is exact for every integer that
// does not overflow a half.
template <class T, class I>
uint64_t from_int(I v) {
  if constexpr (std::is_same_v<T, Single>) {
    return T::put(static_cast<float>(v));
  } else {
    return T::put(static_cast<double>(v));
  }
}

template <class T>
LaneFn int_to_float_fn(Op op, Type from) {
  return with_int(from, [op](auto u) -> LaneFn {
    using U = decltype(u);
    if (op == Op::kSToF) return lanes1<[](uint64_t a) { return from_int<T>(static_cast<int64_t>(Int<U>::s(a))); }>;
    return lanes1<[](uint64_t a) { return from_int<T>(a); }>;
  });
}

template <class Fn>
LaneFn with_float(Type type, Floats floats, Fn&& fn) {
  if (!is_float(type)) return nullptr;
  if (type == Type::kF64 || floats == Floats::kDouble) return fn(Double{});
  return type == Type::kF32 ? fn(Single{}) : fn(Half{});
}

LaneFn convert_fn(Type to, Type from, Floats floats) {
  if (floats == Floats::kDouble) {
    if (to != Type::kF16) return lanes1<[](uint64_t a) { return a; }>;
    return lanes1<[](uint64_t a) { return Double::put(double_from_half(half_from_double(Double::get(a)))); }>;
  }
  return with_float(to, floats, [from](auto t) -> LaneFn {
    return with_float(from, Floats::kNative, [](auto f) -> LaneFn {
      using T = decltype(t);
      if constexpr (std::is_same_v<T, Single>) {
        return lanes1<[](uint64_t a) { return T::put(static_cast<float>(decltype(f)::get(a))); }>;
      } else {
        return lanes1<[](uint64_t a) { return T::put(static_cast<double>(decltype(f)::get(a))); }>;
      }
    });
  });
}

// Memory's view of raw bits in kDouble.
uint64_t single_from_double(uint64_t raw) {
  const double v = Double::get(raw);
  if (!std::isnan(v)) return Single::put(static_cast<float>(v));
  const uint64_t payload = (raw >> 29) & 0x7FFFFF;
  return ((raw >> 32) & 0x80000000) | 0x7F800000 | (payload != 0 ? payload : 0x400000);
}

uint64_t double_from_single(uint64_t bits) {
  const float v = Single::get(bits);
  if (!std::isnan(v)) return Double::put(v);
  return (bits & 0x80000000) << 32 | 0x7FF0000000000000 | (bits & 0x7FFFFF) << 29;
}

LaneFn bitcast_fn(Type to, Type from, Floats floats) {
  if (floats == Floats::kDouble) {
    if (from == Type::kF32) return lanes1<single_from_double>;
    if (to == Type::kF32) return lanes1<double_from_single>;
    if (from == Type::kF16) return lanes1<[](uint64_t a) -> uint64_t { return half_from_double(Double::get(a)); }>;
    if (to == Type::kF16) return lanes1<[](uint64_t a) { return Double::put(double_from_half(static_cast<uint16_t>(a))); }>;
  }
  return lanes1<[](uint64_t a) { return a; }>;
}

}  // namespace

uint16_t half_from_double(double v) {
  const auto bits = std::bit_cast<uint64_t>(v);
  const auto sign = static_cast<uint16_t>(bits >> 48 & 0x8000);
  if (std::isnan(v)) return sign | 0x7E00 | static_cast<uint16_t>(bits >> 42 & 0x1FF);
  const double magnitude = std::fabs(v);
  if (magnitude >= 65520) return sign | 0x7C00;  // halfway between 65504 and 65536, and above
  // Scaling by a power of two is exact; nearbyint rounds to a multiple of the half's last place.
  const int exponent = static_cast<int>(bits >> 52 & 0x7FF) - 1023;
  const int last_place = (exponent < -14 ? -14 : exponent) - 10;
  const auto scale = std::bit_cast<double>(static_cast<uint64_t>(1023 - last_place) << 52);
  const auto units = static_cast<uint32_t>(std::nearbyint(magnitude * scale));  // 0..2048, where 1024 = the hidden bit
  return sign | static_cast<uint16_t>((static_cast<uint32_t>(last_place + 24) << 10) + units);
}

double double_from_half(uint16_t bits) {
  const uint32_t exponent = bits >> 10 & 31, mantissa = bits & 0x3FF;
  const uint64_t sign = static_cast<uint64_t>(bits & 0x8000) << 48;
  if (exponent == 31) return std::bit_cast<double>(sign | 0x7FF0000000000000 | static_cast<uint64_t>(mantissa) << 42);
  const double units = exponent == 0 ? mantissa : mantissa + 1024;
  const auto scale = std::bit_cast<double>(static_cast<uint64_t>((exponent == 0 ? 1 : exponent) + 1023 - 25) << 52);
  return std::bit_cast<double>(sign | std::bit_cast<uint64_t>(units * scale));
}

LaneFn lane_fn(Op op, Type result, Type operand, Floats floats) {
  switch (op) {
    case Op::kFToS:
    case Op::kFToU:
      return with_float(operand, floats, [=](auto t) { return float_to_int_fn<decltype(t)>(op, result); });
    case Op::kSToF:
    case Op::kUToF:
      return with_float(result, floats, [=](auto t) { return int_to_float_fn<decltype(t)>(op, operand); });
    case Op::kFConvert:
      return convert_fn(result, operand, floats);
    case Op::kSExt:
      return sign_extend_fn(operand, result);
    case Op::kBitcast:
      return bitcast_fn(result, operand, floats);
    case Op::kNot:
      if (result == Type::kB1) return lanes1<[](uint64_t a) { return a ^ 1; }>;
      break;
    default:
      break;
  }
  if (const LaneFn fn = widthless_fn(op)) return fn;
  if (is_transcendental(op)) return floats == Floats::kDouble ? transcendental_fn(op) : nullptr;
  const Type type = op == Op::kTrunc ? result : operand;
  if (is_float(type)) return with_float(type, floats, [op](auto t) { return float_fn<decltype(t)>(op); });
  return with_int(type, [op](auto u) { return Int<decltype(u)>::fn(op); });
}

uint64_t memory_raw(Type type, uint64_t bits, Floats floats) {
  if (floats == Floats::kNative) return bits;
  if (type == Type::kF32) return double_from_single(bits);
  return type == Type::kF16 ? Double::put(double_from_half(static_cast<uint16_t>(bits))) : bits;
}

uint64_t raw_memory(Type type, uint64_t raw, Floats floats) {
  if (floats == Floats::kNative) return raw;
  if (type == Type::kF32) return single_from_double(raw);
  return type == Type::kF16 ? half_from_double(Double::get(raw)) : raw;
}

uint64_t const_raw(Type type, uint64_t imm, Floats floats) {
  if (!is_float(type) || type == Type::kF64 || floats == Floats::kDouble) return imm;
  return type == Type::kF32 ? single_from_double(imm) : half_from_double(Double::get(imm));
}

uint64_t const_imm(Type type, uint64_t raw, Floats floats) {
  if (!is_float(type)) return raw;
  double v = Double::get(raw);
  if (floats == Floats::kNative && type == Type::kF32) v = Single::get(raw);
  if (floats == Floats::kNative && type == Type::kF16) v = double_from_half(static_cast<uint16_t>(raw));
  return std::isnan(v) ? Double::kCanonicalNan : Double::put(v);
}

uint64_t reduce_identity(ReduceOp op, Type type, bool first_of_exclusive) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const uint64_t ones = type == Type::kB1 ? 1 : ~0ull >> (64 - 8 * size_bytes(type));
  switch (op) {
    case ReduceOp::kIAdd:
    case ReduceOp::kUMax:
    case ReduceOp::kOr:
    case ReduceOp::kXor:
      return 0;
    case ReduceOp::kIMul:
      return 1;
    case ReduceOp::kUMin:
    case ReduceOp::kAnd:
      return ones;
    case ReduceOp::kSMin:
      return ones >> 1;
    case ReduceOp::kSMax:
      return ones ^ ones >> 1;
    case ReduceOp::kFAdd:
      return std::bit_cast<uint64_t>(first_of_exclusive ? 0.0 : -0.0);
    case ReduceOp::kFMul:
      return std::bit_cast<uint64_t>(1.0);
    case ReduceOp::kFMin:
      return std::bit_cast<uint64_t>(kInfinity);
    case ReduceOp::kFMax:
      return std::bit_cast<uint64_t>(-kInfinity);
    case ReduceOp::kCount:
      break;
  }
  return 0;
}

}  // namespace pineda::ir
