#include "compiler/passes/simplify.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/abi.h"
#include "compiler/ir/ranges.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::Type;
using ir::Value;

uint32_t width_bits(Type t) { return t == Type::kB1 ? 1 : 8 * ir::size_bytes(t); }
uint64_t all_ones(Type t) { return width_bits(t) == 64 ? ~0ull : (1ull << width_bits(t)) - 1; }

// Whether 1 / v is exact and both are normal numbers of the type, so that x / v and x * (1 / v) round the same exact quotient.
bool has_exact_reciprocal(Type type, double v) {
  int exponent = 0;
  const double fraction = std::frexp(v, &exponent);
  const int limit = type == Type::kF64 ? 1021 : type == Type::kF32 ? 125 : 13;
  return std::fabs(fraction) == 0.5 && std::abs(exponent - 1) <= limit;
}

}  // namespace

Value Simplifier::simplify(Inst& inst, std::vector<Value>& before) {
  before_ = &before;
  for (int step = 0; step < 8; ++step) {  // a rule may make another one applicable
    const Outcome outcome = rule(inst);
    if (outcome.value) return outcome.value;
    if (!outcome.changed) break;
  }
  return {};
}

Outcome Simplifier::become(Inst& inst, Op op, std::initializer_list<Value> operands) {
  inst.op = op;
  // fuse_fma has looked at the expression as it was written; what replaces it is not open to it.
  inst.flags = op == Op::kFAdd || op == Op::kFMul ? ir::kNoContract : 0;
  inst.imm = 0;
  inst.operand = {};
  std::ranges::copy(operands, inst.operand.begin());
  return {{}, true};
}

Value Simplifier::emit(const Inst& inst) {
  const Value v = add_inst(kernel_, inst);
  before_->push_back(v);
  return v;
}

Value Simplifier::constant(Type type, uint64_t imm) {
  return emit({.op = Op::kConst, .type = type, .imm = imm & all_ones(type)});
}

Value Simplifier::float_constant(Type type, double v) {
  return emit({.op = Op::kConst, .type = type, .imm = std::bit_cast<uint64_t>(v)});
}

std::optional<uint64_t> Simplifier::imm(Value v) const {
  const Inst& inst = def(v);
  if (inst.op != Op::kConst || ir::is_float(inst.type)) return {};
  return inst.imm;
}

std::optional<double> Simplifier::number(Value v) const {
  const Inst& inst = def(v);
  if (inst.op != Op::kConst || !ir::is_float(inst.type)) return {};
  return std::bit_cast<double>(ir::const_imm(inst.type, ir::const_raw(inst.type, inst.imm, floats_), floats_));
}

Outcome Simplifier::rule(Inst& inst) {
  if (const Outcome out = constants(inst); out.value) return out;
  if (ir::is_commutative(inst.op) && def(inst.operand[0]).op == Op::kConst && def(inst.operand[1]).op != Op::kConst) {
    std::swap(inst.operand[0], inst.operand[1]);  // constants stand right: the rules need to look there only
  }
  switch (inst.op) {
    case Op::kIAdd:
    case Op::kISub:
      return add(inst);
    case Op::kAnd:
    case Op::kOr:
    case Op::kXor:
      return logic(inst);
    case Op::kNot:
      return logic_not(inst);
    case Op::kShl:
    case Op::kLShr:
    case Op::kAShr:
      return shift(inst);
    case Op::kIMul:
    case Op::kUDiv:
    case Op::kSDiv:
    case Op::kURem:
    case Op::kSMin:
    case Op::kSMax:
    case Op::kUMin:
    case Op::kUMax:
      return integer(inst);
    case Op::kIEq:
    case Op::kINe:
    case Op::kULt:
    case Op::kULe:
    case Op::kSLt:
    case Op::kSLe:
      return compare(inst);
    case Op::kFAdd:
    case Op::kFSub:
    case Op::kFMul:
    case Op::kFMa:
    case Op::kFNeg:
    case Op::kFAbs:
    case Op::kFMin:
    case Op::kFMax:
    case Op::kFCanon:
      return floating(inst);
    case Op::kFDiv:
      return divide(inst);
    case Op::kFConvert:
    case Op::kZExt:
    case Op::kSExt:
    case Op::kTrunc:
    case Op::kBitcast:
      return conversion(inst);
    case Op::kSelect:
      return select(inst);
    case Op::kUnpackMask:
    case Op::kQuadSwizzle:
    case Op::kPtrAdd:
    case Op::kLoad:
      return memory(inst);
    default:
      return kNothing;
  }
}

// Everything that is lane-wise and has only constants: computed by the same functions that the evaluator runs.
Outcome Simplifier::constants(const Inst& inst) {
  const ir::OpInfo& info = ir::op_info(inst.op);
  if (info.effect != ir::Effect::kPure || info.operands == 0 || info.operands > 3) return kNothing;
  if (inst.op == Op::kUnpackMask || inst.op == Op::kQuadSwizzle || inst.op == Op::kResult || inst.type == Type::kPtr) {
    return kNothing;
  }
  uint64_t lanes[3][kLanes] = {};
  for (uint32_t i = 0; i < info.operands; ++i) {
    const Inst& operand = def(inst.operand[i]);
    if (operand.op != Op::kConst) return kNothing;
    std::fill_n(lanes[i], kLanes, ir::const_raw(operand.type, operand.imm, floats_));
  }
  const ir::LaneFn fn = ir::lane_fn(inst.op, inst.type, type(inst.operand[inst.op == Op::kSelect ? 1 : 0]), floats_);
  if (fn == nullptr) return kNothing;
  uint64_t out[kLanes];
  fn(out, lanes[0], lanes[1], lanes[2]);
  const uint64_t folded = ir::const_imm(inst.type, out[0], floats_);
  // A Bitcast may give a NaN with a payload, which no Const can hold.
  if (inst.op == Op::kBitcast && ir::const_raw(inst.type, folded, floats_) != out[0]) return kNothing;
  return is(emit({.op = Op::kConst, .type = inst.type, .imm = folded}));
}

// ---- integers -------------------------------------------------------------------------------------------------------------

Outcome Simplifier::add(Inst& inst) {
  const Value a = inst.operand[0], b = inst.operand[1];
  if (is_imm(b, 0)) return is(a);
  if (inst.op == Op::kISub) {
    if (a == b) return is_const(inst.type, 0);
    if (const auto c = imm(b)) return become(inst, Op::kIAdd, {a, constant(inst.type, 0 - *c)});
    return kNothing;
  }
  const Inst& inner = def(a);
  if (!imm(b) || inner.op != Op::kIAdd || !imm(inner.operand[1])) return kNothing;
  const Value x = inner.operand[0];
  return become(inst, Op::kIAdd, {x, constant(inst.type, *imm(inner.operand[1]) + *imm(b))});
}

Outcome Simplifier::integer(Inst& inst) {
  const Value a = inst.operand[0], b = inst.operand[1];
  const bool min_max = inst.op == Op::kSMin || inst.op == Op::kSMax || inst.op == Op::kUMin || inst.op == Op::kUMax;
  if (min_max) {
    if (a == b) return is(a);
    if (inst.op == Op::kUMin && is_imm(b, 0)) return is(b);
    if (inst.op == Op::kUMax && is_imm(b, 0)) return is(a);
    return kNothing;
  }
  if (inst.op == Op::kIMul && is_imm(b, 0)) return is(b);
  if (inst.op == Op::kURem) return is_imm(b, 1) ? is_const(inst.type, 0) : kNothing;
  return is_imm(b, 1) ? is(a) : kNothing;  // a * 1, a / 1
}

Outcome Simplifier::logic(Inst& inst) {
  const Value a = inst.operand[0], b = inst.operand[1];
  const uint64_t ones = all_ones(inst.type);
  if (a == b) return inst.op == Op::kXor ? is_const(inst.type, 0) : is(a);
  const auto c = imm(b);
  if (!c) {
    const bool complement =
        (def(a).op == Op::kNot && def(a).operand[0] == b) || (def(b).op == Op::kNot && def(b).operand[0] == a);
    if (!complement) return kNothing;
    return is_const(inst.type, inst.op == Op::kAnd ? 0 : ones);
  }
  if (inst.op == Op::kAnd && *c == 0) return is(b);
  if (inst.op == Op::kAnd && *c == ones) return is(a);
  if (inst.op == Op::kOr && *c == ones) return is(b);
  if (inst.op != Op::kAnd && *c == 0) return is(a);
  if (inst.op == Op::kXor && *c == ones) return become(inst, Op::kNot, {a});
  const Inst& inner = def(a);
  if (inner.op != inst.op || !imm(inner.operand[1])) return kNothing;
  const uint64_t d = *imm(inner.operand[1]);
  const uint64_t both = inst.op == Op::kAnd ? d & *c : inst.op == Op::kOr ? d | *c : d ^ *c;
  const Value x = inner.operand[0];
  return become(inst, inst.op, {x, constant(inst.type, both)});
}

// A negated comparison stays: LLVM turns it around for free, and assume() in fold.cpp knows that the two are opposites.
Outcome Simplifier::logic_not(Inst& inst) {
  const Inst inner = def(inst.operand[0]);
  if (inner.op == Op::kNot) return is(inner.operand[0]);
  if (inner.op != Op::kAnd && inner.op != Op::kOr) return kNothing;
  const Value a = inner.operand[0], b = inner.operand[1];
  if (def(a).op != Op::kNot && def(b).op != Op::kNot) return kNothing;
  return become(inst, inner.op == Op::kAnd ? Op::kOr : Op::kAnd, {negate(a), negate(b)});  // De Morgan
}

Value Simplifier::negate(Value v) {
  const Inst inst = def(v);
  return inst.op == Op::kNot ? inst.operand[0] : emit({.op = Op::kNot, .type = inst.type, .operand = {v}});
}

Outcome Simplifier::shift(Inst& inst) {
  const auto count = imm(inst.operand[1]);
  if (count && *count % width_bits(inst.type) == 0) return is(inst.operand[0]);
  return is_imm(inst.operand[0], 0) ? is(inst.operand[0]) : kNothing;
}

Outcome Simplifier::compare(Inst& inst) {
  const Op op = inst.op;
  if (inst.operand[0] == inst.operand[1]) {
    return is_const(Type::kB1, op == Op::kIEq || op == Op::kULe || op == Op::kSLe);
  }
  if (op == Op::kULt && is_imm(inst.operand[1], 0)) return is_const(Type::kB1, 0);
  if (op == Op::kULe && is_imm(inst.operand[0], 0)) return is_const(Type::kB1, 1);
  const auto bound = [&](Value v) { return ir::upper_bound(kernel_, v); };
  if (ir::is_known_true(kernel_, inst, bound)) return is_const(Type::kB1, 1);
  return op == Op::kIEq || op == Op::kINe ? compare_with_const(inst) : kNothing;
}

// A B1 that went through an integer: zext(b) == c, select(b, c1, c2) == c.
Outcome Simplifier::compare_with_const(Inst& inst) {
  const auto c = imm(inst.operand[1]);
  const Inst inner = def(inst.operand[0]);
  if (!c) return kNothing;
  std::optional<uint64_t> when_true, when_false;
  if (inner.op == Op::kZExt && type(inner.operand[0]) == Type::kB1) {
    when_true = 1, when_false = 0;
  } else if (inner.op == Op::kSelect) {
    when_true = imm(inner.operand[1]), when_false = imm(inner.operand[2]);
  }
  if (!when_true || !when_false) return kNothing;
  const bool on_true = (*when_true == *c) == (inst.op == Op::kIEq), on_false = (*when_false == *c) == (inst.op == Op::kIEq);
  if (on_true == on_false) return is_const(Type::kB1, on_true);
  return on_true ? is(inner.operand[0]) : become(inst, Op::kNot, {inner.operand[0]});
}

// ---- floats ---------------------------------------------------------------------------------------------------------------

Outcome Simplifier::floating(Inst& inst) {
  const Value a = inst.operand[0], b = inst.operand[1];
  const auto is_zero = [&](Value v, bool negative) { return number(v) == 0.0 && std::signbit(*number(v)) == negative; };
  const Op inner = def(a).op;
  switch (inst.op) {
    case Op::kFAdd:
      return is_zero(b, true) ? is(a) : kNothing;  // x + -0, but +0 turns -0 into +0
    case Op::kFSub:
      return is_zero(b, false) ? is(a) : kNothing;  // x - +0
    case Op::kFMul:
      if (number(b) == 1.0) return is(a);
      return number(b) == -1.0 ? become(inst, Op::kFNeg, {a}) : kNothing;
    case Op::kFMa:
      if (number(a) == 1.0) return become(inst, Op::kFAdd, {b, inst.operand[2]});
      return number(b) == 1.0 ? become(inst, Op::kFAdd, {a, inst.operand[2]}) : kNothing;
    case Op::kFNeg:
      return inner == Op::kFNeg ? is(def(a).operand[0]) : kNothing;
    case Op::kFAbs:
      if (inner == Op::kFNeg) return become(inst, Op::kFAbs, {def(a).operand[0]});
      return inner == Op::kFAbs ? is(a) : kNothing;
    case Op::kFMin:
    case Op::kFMax:
      return a == b ? is(a) : kNothing;
    case Op::kFCanon:
      return inner == Op::kFCanon || inner == Op::kSToF || inner == Op::kUToF ? is(a) : kNothing;
    default:
      return kNothing;
  }
}

Outcome Simplifier::divide(Inst& inst) {
  const auto divisor = number(inst.operand[1]);
  if (!divisor || !has_exact_reciprocal(inst.type, *divisor)) return kNothing;
  return become(inst, Op::kFMul, {inst.operand[0], float_constant(inst.type, 1 / *divisor)});
}

// ---- conversions, select, the rest ----------------------------------------------------------------------------------------

// In the truth a conversion away from F16 or F32 and back may round, since such values are doubles there.
bool Simplifier::rounds(Value x, Type through) const {
  if (floats_ == ir::Floats::kNative || !ir::is_float(type(x)) || type(x) == Type::kF64) return false;
  return ir::is_int(through) || type(x) == Type::kF16;
}

Outcome Simplifier::conversion(Inst& inst) {
  const Inst inner = def(inst.operand[0]);
  const Value x = inner.operand[0];
  switch (inst.op) {
    case Op::kZExt:
      return inner.op == Op::kZExt ? become(inst, Op::kZExt, {x}) : kNothing;
    case Op::kSExt:
      if (inner.op == Op::kZExt) return become(inst, Op::kZExt, {x});
      return inner.op == Op::kSExt ? become(inst, Op::kSExt, {x}) : kNothing;
    case Op::kTrunc:
      if (inner.op == Op::kTrunc) return become(inst, Op::kTrunc, {x});
      return (inner.op == Op::kZExt || inner.op == Op::kSExt) && type(x) == inst.type ? is(x) : kNothing;
    case Op::kBitcast:
      if (inner.op != Op::kBitcast || rounds(x, inner.type)) return kNothing;
      return type(x) == inst.type ? is(x) : become(inst, Op::kBitcast, {x});
    case Op::kFConvert:  // widening is exact
      if (inner.op != Op::kFConvert || type(x) != inst.type || rounds(x, inner.type)) return kNothing;
      return ir::size_bytes(inner.type) > ir::size_bytes(inst.type) ? is(x) : kNothing;
    default:
      return kNothing;
  }
}

Outcome Simplifier::select(Inst& inst) {
  const Value cond = inst.operand[0], a = inst.operand[1], b = inst.operand[2];
  if (a == b) return is(a);
  if (const auto c = imm(cond)) return is(*c != 0 ? a : b);
  const Inst &first = def(a), &second = def(b);
  if (first.op == Op::kConst && second.op == Op::kConst && first.imm == second.imm) return is(a);
  if (def(cond).op == Op::kNot) return become(inst, Op::kSelect, {def(cond).operand[0], b, a});
  if (inst.type != Type::kB1) return kNothing;
  if (a == cond) return become(inst, Op::kOr, {cond, b});
  if (b == cond) return become(inst, Op::kAnd, {cond, a});
  if (is_imm(a, 1)) return is_imm(b, 0) ? is(cond) : become(inst, Op::kOr, {cond, b});
  if (is_imm(b, 0)) return become(inst, Op::kAnd, {cond, a});
  if (is_imm(b, 1)) return is_imm(a, 0) ? become(inst, Op::kNot, {cond}) : become(inst, Op::kOr, {negate(cond), a});
  return is_imm(a, 0) ? become(inst, Op::kAnd, {negate(cond), b}) : kNothing;
}

Outcome Simplifier::memory(Inst& inst) {
  const Value a = inst.operand[0], b = inst.operand[1];
  switch (inst.op) {
    case Op::kUnpackMask:
      if (is_imm(a, 0)) return is_const(Type::kB1, 0);
      return imm(a) && (*imm(a) & 0xffff) == 0xffff ? is_const(Type::kB1, 1) : kNothing;
    case Op::kQuadSwizzle:
      return def(a).op == Op::kConst ? is(a) : kNothing;
    case Op::kPtrAdd: {
      if (is_imm(b, 0)) return is(a);
      const Inst inner = def(a);
      if (inner.op != Op::kPtrAdd || !imm(b) || !imm(inner.operand[1])) return kNothing;
      return become(inst, Op::kPtrAdd, {inner.operand[0], constant(Type::kI64, *imm(inner.operand[1]) + *imm(b))});
    }
    case Op::kLoad: {  // a check whose outcome is known
      const Value limit = inst.operand[2];
      if (!limit || !imm(limit) || !imm(b)) return kNothing;
      const uint64_t size = ir::size_bytes(inst.type), stride = inst.lane_stride();
      if (*imm(b) + size > *imm(limit)) return is(emit({.op = Op::kConst, .type = inst.type}));  // fails for lane 0, so for all
      if (*imm(b) + (kLanes - 1) * stride + size > *imm(limit)) return kNothing;
      inst.operand[2] = {};
      inst.flags |= ir::kSpeculate;  // as a checked access is valid for every lane
      return {{}, true};
    }
    default:
      return kNothing;
  }
}

}  // namespace pineda::passes
