// GLSL.std.450: the dispatcher and the common functions. FMin, FMax and FClamp leave NaNs to us: they follow the IR's FMin and
// FMax, which give the first operand; NMin, NMax and NClamp give the operand that is a number.
#include "compiler/spirv/glsl450.h"

#include <algorithm>
#include <array>
#include <numbers>

namespace pineda::spirv {
namespace {

using ir::Op;
using ir::Value;

template <Op kOp>
void f1(Translator& t, const Instruction& inst) {
  glsl_map1<true>(t, inst, [&](Value a) { return t.b.op(kOp, t.b.type(a), {a}); });
}
template <Op kOp>
void f2(Translator& t, const Instruction& inst) {
  glsl_map2<true>(t, inst, [&](Value a, Value c) { return t.b.op(kOp, t.b.type(a), {a, c}); });
}
// Transcendentals.
template <Op kOp>
void t1(Translator& t, const Instruction& inst) {
  glsl_map1<true>(t, inst, [&](Value a) {
    return in_f32(
        t, inst, [&](Value x) { return t.b.op(kOp, ir::Type::kF32, {x}); }, a);
  });
}
template <Op kOp>
void t2(Translator& t, const Instruction& inst) {
  glsl_map2<true>(t, inst, [&](Value a, Value c) {
    return in_f32(
        t, inst,
        [&](Value x, Value y) {
          return t.b.op(kOp, ir::Type::kF32, {x, y});
        },
        a, c);
  });
}
template <Op kOp>
void i2(Translator& t, const Instruction& inst) {
  glsl_map2<false>(t, inst, [&](Value a, Value c) { return t.b.op(kOp, t.b.type(a), {a, c}); });
}
template <Op kMax, Op kMin>  // min(max(x, low), high)
void i_clamp(Translator& t, const Instruction& inst) {
  glsl_map3<false>(t, inst, [&](Value x, Value low, Value high) {
    const ir::Type type = t.b.type(x);
    return t.b.op(kMin, type, {t.b.op(kMax, type, {x, low}), high});
  });
}

void s_abs(Translator& t, const Instruction& inst) {
  glsl_map1<false>(t, inst, [&](Value a) { return t.b.smax(a, t.b.isub(integer(t, a, 0), a)); });
}
void s_sign(Translator& t, const Instruction& inst) {
  glsl_map1<false>(t, inst, [&](Value a) { return t.b.smax(t.b.smin(a, integer(t, a, 1)), integer(t, a, ~0ull)); });
}
void f_sign(Translator& t, const Instruction& inst) {
  glsl_map1<true>(t, inst, [&](Value a) {
    const Value zero = number(t, a, 0);
    return t.b.select(t.b.flt(zero, a), number(t, a, 1), t.b.select(t.b.flt(a, zero), number(t, a, -1), zero));
  });
}
void fract(Translator& t, const Instruction& inst) {
  glsl_map1<true>(t, inst, [&](Value a) { return t.fsub(a, t.b.ffloor(a)); });
}
void radians(Translator& t, const Instruction& inst) {
  glsl_map1<true>(t, inst, [&](Value a) { return t.fmul(a, number(t, a, std::numbers::pi / 180)); });
}
void degrees(Translator& t, const Instruction& inst) {
  glsl_map1<true>(t, inst, [&](Value a) { return t.fmul(a, number(t, a, 180 / std::numbers::pi)); });
}
void inverse_sqrt(Translator& t, const Instruction& inst) {
  glsl_map1<true>(
      t, inst, [&](Value a) { return t.b.type(a) == ir::Type::kF32 ? t.b.frsqrt(a) : t.b.fdiv(number(t, a, 1), t.b.fsqrt(a)); });
}

Value n_min(Translator& t, Value a, Value c) { return t.b.select(t.b.fne(a, a), c, t.b.fmin(a, c)); }
Value n_max(Translator& t, Value a, Value c) { return t.b.select(t.b.fne(a, a), c, t.b.fmax(a, c)); }

void f_clamp(Translator& t, const Instruction& inst) {
  glsl_map3<true>(t, inst, [&](Value x, Value low, Value high) { return t.b.fmin(t.b.fmax(x, low), high); });
}
// Vulkan, "Precision of Individual Operations": x * (1 - a) + y * a, exact at both ends.
void f_mix(Translator& t, const Instruction& inst) {
  glsl_map3<true>(t, inst,
                  [&](Value x, Value y, Value a) { return t.fadd(t.fmul(x, t.fsub(number(t, a, 1), a)), t.fmul(y, a)); });
}
void step(Translator& t, const Instruction& inst) {
  glsl_map2<true>(t, inst, [&](Value edge, Value x) { return t.b.select(t.b.flt(x, edge), number(t, x, 0), number(t, x, 1)); });
}
void smooth_step(Translator& t, const Instruction& inst) {
  glsl_map3<true>(t, inst, [&](Value low, Value high, Value x) {
    const Value linear = t.b.fdiv(t.fsub(x, low), t.fsub(high, low));
    const Value s = t.b.fmin(t.b.fmax(linear, number(t, x, 0)), number(t, x, 1));
    return t.fmul(t.fmul(s, s), t.fsub(number(t, x, 3), t.fmul(number(t, x, 2), s)));
  });
}
void fma(Translator& t, const Instruction& inst) {
  glsl_map3<true>(t, inst, [&](Value a, Value c, Value d) { return t.b.fma(a, c, d); });
}

// The result may be narrower or wider than the operand.
template <typename Fn>
void find_bit(Translator& t, const Instruction& inst, Fn fn) {
  const ir::Type to = t.component_of(t.result_type(inst));
  if (!ir::is_int(to)) inst.fail("the result is not an integer");
  glsl_map1<false>(t, inst, [&](Value a) {
    const Value v = fn(a);
    return t.b.convert(ir::size_bytes(to) < ir::size_bytes(t.b.type(a)) ? Op::kTrunc : Op::kSExt, to, v);
  });
}
uint64_t top_bit(Translator& t, Value a) { return 8 * ir::size_bytes(t.b.type(a)) - 1; }
Value most_significant(Translator& t, Value a) { return t.b.isub(integer(t, a, top_bit(t, a)), t.b.clz(a)); }  // -1 for 0

void find_i_lsb(Translator& t, const Instruction& inst) {
  find_bit(t, inst, [&](Value a) { return t.b.select(t.b.ieq(a, integer(t, a, 0)), integer(t, a, ~0ull), t.b.ctz(a)); });
}
void find_u_msb(Translator& t, const Instruction& inst) {
  find_bit(t, inst, [&](Value a) { return most_significant(t, a); });
}
void find_s_msb(Translator& t, const Instruction& inst) {  // of the bits that differ from the sign
  find_bit(t, inst, [&](Value a) { return most_significant(t, t.b.xor_(a, t.b.ashr(a, integer(t, a, top_bit(t, a))))); });
}

constexpr ExtRow kRows[] = {
    PINEDA_GLSL_ROW(Round, 1, f1<Op::kFRoundEven>),  // which way 0.5 goes is ours to choose
    PINEDA_GLSL_ROW(RoundEven, 1, f1<Op::kFRoundEven>),
    PINEDA_GLSL_ROW(Trunc, 1, f1<Op::kFTrunc>),
    PINEDA_GLSL_ROW(FAbs, 1, f1<Op::kFAbs>),
    PINEDA_GLSL_ROW(SAbs, 1, s_abs),
    PINEDA_GLSL_ROW(FSign, 1, f_sign),
    PINEDA_GLSL_ROW(SSign, 1, s_sign),
    PINEDA_GLSL_ROW(Floor, 1, f1<Op::kFFloor>),
    PINEDA_GLSL_ROW(Ceil, 1, f1<Op::kFCeil>),
    PINEDA_GLSL_ROW(Fract, 1, fract),
    PINEDA_GLSL_ROW(Radians, 1, radians),
    PINEDA_GLSL_ROW(Degrees, 1, degrees),
    PINEDA_GLSL_ROW(Sin, 1, t1<Op::kFSin>),
    PINEDA_GLSL_ROW(Cos, 1, t1<Op::kFCos>),
    PINEDA_GLSL_ROW(Tan, 1, t1<Op::kFTan>),
    PINEDA_GLSL_ROW(Asin, 1, t1<Op::kFAsin>),
    PINEDA_GLSL_ROW(Acos, 1, t1<Op::kFAcos>),
    PINEDA_GLSL_ROW(Atan, 1, t1<Op::kFAtan>),
    PINEDA_GLSL_ROW(Atan2, 2, t2<Op::kFAtan2>),
    PINEDA_GLSL_ROW(Sinh, 1, t1<Op::kFSinh>),
    PINEDA_GLSL_ROW(Cosh, 1, t1<Op::kFCosh>),
    PINEDA_GLSL_ROW(Tanh, 1, t1<Op::kFTanh>),
    PINEDA_GLSL_ROW(Asinh, 1, t1<Op::kFAsinh>),
    PINEDA_GLSL_ROW(Acosh, 1, t1<Op::kFAcosh>),
    PINEDA_GLSL_ROW(Atanh, 1, t1<Op::kFAtanh>),
    PINEDA_GLSL_ROW(Pow, 2, t2<Op::kFPow>),
    PINEDA_GLSL_ROW(Exp, 1, t1<Op::kFExp>),
    PINEDA_GLSL_ROW(Log, 1, t1<Op::kFLog>),
    PINEDA_GLSL_ROW(Exp2, 1, t1<Op::kFExp2>),
    PINEDA_GLSL_ROW(Log2, 1, t1<Op::kFLog2>),
    PINEDA_GLSL_ROW(Sqrt, 1, f1<Op::kFSqrt>),
    PINEDA_GLSL_ROW(InverseSqrt, 1, inverse_sqrt),
    PINEDA_GLSL_ROW(FMin, 2, f2<Op::kFMin>),
    PINEDA_GLSL_ROW(UMin, 2, i2<Op::kUMin>),
    PINEDA_GLSL_ROW(SMin, 2, i2<Op::kSMin>),
    PINEDA_GLSL_ROW(FMax, 2, f2<Op::kFMax>),
    PINEDA_GLSL_ROW(UMax, 2, i2<Op::kUMax>),
    PINEDA_GLSL_ROW(SMax, 2, i2<Op::kSMax>),
    PINEDA_GLSL_ROW(FClamp, 3, f_clamp),
    PINEDA_GLSL_ROW(UClamp, 3, i_clamp<Op::kUMax, Op::kUMin>),
    PINEDA_GLSL_ROW(SClamp, 3, i_clamp<Op::kSMax, Op::kSMin>),
    PINEDA_GLSL_ROW(FMix, 3, f_mix),
    PINEDA_GLSL_ROW(Step, 2, step),
    PINEDA_GLSL_ROW(SmoothStep, 3, smooth_step),
    PINEDA_GLSL_ROW(Fma, 3, fma),
    PINEDA_GLSL_ROW(FindILsb, 1, find_i_lsb),
    PINEDA_GLSL_ROW(FindSMsb, 1, find_s_msb),
    PINEDA_GLSL_ROW(FindUMsb, 1, find_u_msb),
    PINEDA_GLSL_ROW(
        NMin, 2,
        [](Translator& t, const Instruction& i) { glsl_map2<true>(t, i, [&](Value a, Value c) { return n_min(t, a, c); }); }),
    PINEDA_GLSL_ROW(
        NMax, 2,
        [](Translator& t, const Instruction& i) { glsl_map2<true>(t, i, [&](Value a, Value c) { return n_max(t, a, c); }); }),
    PINEDA_GLSL_ROW(NClamp, 3,
                    [](Translator& t, const Instruction& i) {
                      glsl_map3<true>(t, i, [&](Value x, Value low, Value high) { return n_min(t, n_max(t, x, low), high); });
                    }),
};

struct Table {
  std::array<const ExtRow*, GLSLstd450Count> rows{};
  Table() {
    for (auto group : {std::span<const ExtRow>(kRows), glsl_exponent_rows(), glsl_geometry_rows(), glsl_pack_rows(),
                       glsl_interpolate_rows()}) {
      for (const ExtRow& row : group) rows[row.number] = &row;
    }
  }
};

}  // namespace

void glsl_std_450(Translator& t, const Instruction& inst) {
  static const Table table;
  const uint32_t number = inst.word(4);
  const ExtRow* row = number < GLSLstd450Count ? table.rows[number] : nullptr;
  if (!row) inst.fail("GLSL.std.450 instruction " + std::to_string(number) + " is not supported");
  if (inst.size() != kFirstOperand + row->operands) inst.fail(std::string(row->name) + " has the wrong number of operands");
  row->handler(t, inst);
}

}  // namespace pineda::spirv
