// Comparisons, bool arithmetic, select. The IR compares floats with ordered ==, < and <= and with unordered !=; the other
// relations are their negations or swaps: "unordered a < b" is not (b <= a), and so on.
#include <limits>

#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::Value;
using Relation = Value (*)(ir::Builder&, Value, Value);

enum class Operands : uint8_t { kFloat, kInt, kBool };

template <Operands kOperands>
Values operand(Translator& t, const Instruction& inst, uint32_t word) {
  if constexpr (kOperands == Operands::kFloat)
    return t.floats(inst, word);
  else if constexpr (kOperands == Operands::kInt)
    return t.integers(inst, word);
  else
    return t.bools(inst, word);
}

template <Operands kOperands, Relation kRelation>
void relate(Translator& t, const Instruction& inst) {
  Values a = operand<kOperands>(t, inst, 3);
  const Values c = operand<kOperands>(t, inst, 4);
  if (a.size() != c.size() || t.b.type(a[0]) != t.b.type(c[0])) inst.fail("the operands have different types");
  for (size_t i = 0; i < a.size(); ++i) a[i] = kRelation(t.b, a[i], c[i]);
  t.define(inst, std::move(a));
}

// NOLINTBEGIN(readability-identifier-naming): one line each
Value int_eq(ir::Builder& b, Value x, Value y) { return b.ieq(x, y); }
Value int_ne(ir::Builder& b, Value x, Value y) { return b.ine(x, y); }
Value u_lt(ir::Builder& b, Value x, Value y) { return b.ult(x, y); }
Value u_gt(ir::Builder& b, Value x, Value y) { return b.ult(y, x); }
Value u_le(ir::Builder& b, Value x, Value y) { return b.ule(x, y); }
Value u_ge(ir::Builder& b, Value x, Value y) { return b.ule(y, x); }
Value s_lt(ir::Builder& b, Value x, Value y) { return b.slt(x, y); }
Value s_gt(ir::Builder& b, Value x, Value y) { return b.slt(y, x); }
Value s_le(ir::Builder& b, Value x, Value y) { return b.sle(x, y); }
Value s_ge(ir::Builder& b, Value x, Value y) { return b.sle(y, x); }
Value ord_eq(ir::Builder& b, Value x, Value y) { return b.feq(x, y); }
Value ord_ne(ir::Builder& b, Value x, Value y) { return b.or_(b.flt(x, y), b.flt(y, x)); }
Value ord_lt(ir::Builder& b, Value x, Value y) { return b.flt(x, y); }
Value ord_gt(ir::Builder& b, Value x, Value y) { return b.flt(y, x); }
Value ord_le(ir::Builder& b, Value x, Value y) { return b.fle(x, y); }
Value ord_ge(ir::Builder& b, Value x, Value y) { return b.fle(y, x); }
Value unord_eq(ir::Builder& b, Value x, Value y) { return b.not_(ord_ne(b, x, y)); }
Value unord_ne(ir::Builder& b, Value x, Value y) { return b.fne(x, y); }
Value unord_lt(ir::Builder& b, Value x, Value y) { return b.not_(b.fle(y, x)); }
Value unord_gt(ir::Builder& b, Value x, Value y) { return b.not_(b.fle(x, y)); }
Value unord_le(ir::Builder& b, Value x, Value y) { return b.not_(b.flt(y, x)); }
Value unord_ge(ir::Builder& b, Value x, Value y) { return b.not_(b.flt(x, y)); }
Value ordered(ir::Builder& b, Value x, Value y) { return b.and_(b.feq(x, x), b.feq(y, y)); }
Value unordered(ir::Builder& b, Value x, Value y) { return b.or_(b.fne(x, x), b.fne(y, y)); }
Value logical_and(ir::Builder& b, Value x, Value y) { return b.and_(x, y); }
Value logical_or(ir::Builder& b, Value x, Value y) { return b.or_(x, y); }
Value logical_ne(ir::Builder& b, Value x, Value y) { return b.xor_(x, y); }
Value logical_eq(ir::Builder& b, Value x, Value y) { return b.not_(b.xor_(x, y)); }
// NOLINTEND

void logical_not(Translator& t, const Instruction& inst) {
  Values a = t.bools(inst, 3);
  for (Value& v : a) v = t.b.not_(v);
  t.define(inst, std::move(a));
}

void is_nan(Translator& t, const Instruction& inst) {
  Values a = t.floats(inst, 3);
  for (Value& v : a) v = t.b.fne(v, v);
  t.define(inst, std::move(a));
}

void is_inf(Translator& t, const Instruction& inst) {
  Values a = t.floats(inst, 3);
  for (Value& v : a) v = t.b.feq(t.b.fabs(v), t.b.fconst(t.b.type(v), std::numeric_limits<double>::infinity()));
  t.define(inst, std::move(a));
}

template <bool kAll>
void reduce(Translator& t, const Instruction& inst) {
  const Values a = t.bools(inst, 3);
  Value out = a[0];
  for (size_t i = 1; i < a.size(); ++i) out = kAll ? t.b.and_(out, a[i]) : t.b.or_(out, a[i]);
  t.define(inst, Values{out});
}

// A scalar condition selects whole composites (SPIR-V 1.4), a vector of conditions selects by component.
void select(Translator& t, const Instruction& inst) {
  const Values cond = t.bools(inst, 3), a = t.values(inst, 4), c = t.values(inst, 5);
  if (a.size() != c.size()) inst.fail("the operands have different sizes");
  if (cond.size() != 1 && cond.size() != a.size()) inst.fail("the condition does not have the operands' size");
  Values out;
  for (size_t i = 0; i < a.size(); ++i) {
    if (t.b.type(a[i]) != t.b.type(c[i])) inst.fail("the operands have different types");
    out.push_back(t.b.select(cond[cond.size() == 1 ? 0 : i], a[i], c[i]));
  }
  t.define(inst, std::move(out));
}

constexpr auto kF = Operands::kFloat;
constexpr auto kI = Operands::kInt;
constexpr auto kB = Operands::kBool;

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(IEqual, 5, relate<kI, int_eq>),
    PINEDA_SPIRV_ROW(INotEqual, 5, relate<kI, int_ne>),
    PINEDA_SPIRV_ROW(ULessThan, 5, relate<kI, u_lt>),
    PINEDA_SPIRV_ROW(UGreaterThan, 5, relate<kI, u_gt>),
    PINEDA_SPIRV_ROW(ULessThanEqual, 5, relate<kI, u_le>),
    PINEDA_SPIRV_ROW(UGreaterThanEqual, 5, relate<kI, u_ge>),
    PINEDA_SPIRV_ROW(SLessThan, 5, relate<kI, s_lt>),
    PINEDA_SPIRV_ROW(SGreaterThan, 5, relate<kI, s_gt>),
    PINEDA_SPIRV_ROW(SLessThanEqual, 5, relate<kI, s_le>),
    PINEDA_SPIRV_ROW(SGreaterThanEqual, 5, relate<kI, s_ge>),
    PINEDA_SPIRV_ROW(FOrdEqual, 5, relate<kF, ord_eq>),
    PINEDA_SPIRV_ROW(FUnordEqual, 5, relate<kF, unord_eq>),
    PINEDA_SPIRV_ROW(FOrdNotEqual, 5, relate<kF, ord_ne>),
    PINEDA_SPIRV_ROW(FUnordNotEqual, 5, relate<kF, unord_ne>),
    PINEDA_SPIRV_ROW(FOrdLessThan, 5, relate<kF, ord_lt>),
    PINEDA_SPIRV_ROW(FUnordLessThan, 5, relate<kF, unord_lt>),
    PINEDA_SPIRV_ROW(FOrdGreaterThan, 5, relate<kF, ord_gt>),
    PINEDA_SPIRV_ROW(FUnordGreaterThan, 5, relate<kF, unord_gt>),
    PINEDA_SPIRV_ROW(FOrdLessThanEqual, 5, relate<kF, ord_le>),
    PINEDA_SPIRV_ROW(FUnordLessThanEqual, 5, relate<kF, unord_le>),
    PINEDA_SPIRV_ROW(FOrdGreaterThanEqual, 5, relate<kF, ord_ge>),
    PINEDA_SPIRV_ROW(FUnordGreaterThanEqual, 5, relate<kF, unord_ge>),
    PINEDA_SPIRV_ROW(Ordered, 5, relate<kF, ordered>),
    PINEDA_SPIRV_ROW(Unordered, 5, relate<kF, unordered>),
    PINEDA_SPIRV_ROW(LogicalAnd, 5, relate<kB, logical_and>),
    PINEDA_SPIRV_ROW(LogicalOr, 5, relate<kB, logical_or>),
    PINEDA_SPIRV_ROW(LogicalEqual, 5, relate<kB, logical_eq>),
    PINEDA_SPIRV_ROW(LogicalNotEqual, 5, relate<kB, logical_ne>),
    PINEDA_SPIRV_ROW(LogicalNot, 4, logical_not),
    PINEDA_SPIRV_ROW(IsNan, 4, is_nan),
    PINEDA_SPIRV_ROW(IsInf, 4, is_inf),
    PINEDA_SPIRV_ROW(Any, 4, reduce<false>),
    PINEDA_SPIRV_ROW(All, 4, reduce<true>),
    PINEDA_SPIRV_ROW(Select, 6, select),
};

}  // namespace

std::span<const OpRow> logic_rows() { return kRows; }

}  // namespace pineda::spirv
