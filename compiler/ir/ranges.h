// What an I32 is at most, as far as the expression that it comes from tells: for checks that need not be made.
#pragma once

#include <algorithm>

#include "base/abi.h"
#include "compiler/ir/ir.h"

namespace pineda::ir {

inline constexpr uint64_t kAnyU32 = 0xffffffff;

// `bound(operand)` tells it of an operand.
template <typename Bound>
uint64_t expression_bound(const Kernel& kernel, const Inst& inst, const Bound& bound) {
  const auto unwrapped = [](uint64_t bound_64) { return std::min(bound_64, kAnyU32); };
  const auto constant = [&](uint32_t i) -> const Inst* {
    const Inst& operand = kernel.at(inst.operand[i]);
    return operand.op == Op::kConst ? &operand : nullptr;
  };
  const auto shift_count = [&] { return constant(1) ? constant(1)->imm & 31 : 32; };
  switch (inst.op) {
    case Op::kConst:
      return inst.imm;
    case Op::kLane:
      return kLanes - 1;
    case Op::kZExt: {
      const Type from = kernel.at(inst.operand[0]).type;
      return from == Type::kB1 ? 1 : (1u << 8 * size_bytes(from)) - 1;
    }
    case Op::kAnd:
    case Op::kUMin:
      return std::min(bound(inst.operand[0]), bound(inst.operand[1]));
    case Op::kUMax:
      return std::max(bound(inst.operand[0]), bound(inst.operand[1]));
    case Op::kSelect:
      return std::max(bound(inst.operand[1]), bound(inst.operand[2]));
    case Op::kIAdd:
      return unwrapped(bound(inst.operand[0]) + bound(inst.operand[1]));
    case Op::kIMul:
      return unwrapped(bound(inst.operand[0]) * bound(inst.operand[1]));
    case Op::kLShr:
      return shift_count() < 32 ? bound(inst.operand[0]) >> shift_count() : kAnyU32;
    case Op::kShl:
      return shift_count() < 32 ? unwrapped(bound(inst.operand[0]) << shift_count()) : kAnyU32;
    case Op::kURem:
      return constant(1) && constant(1)->imm != 0 ? std::min(bound(inst.operand[0]), constant(1)->imm - 1)
                                                  : bound(inst.operand[0]);
    case Op::kUDiv:
      return constant(1) && constant(1)->imm != 0 ? bound(inst.operand[0]) / constant(1)->imm : kAnyU32;
    default:
      return kAnyU32;
  }
}

// Whether a ULt or ULe of I32s holds for all values within the bounds: x <= constant, 0 <= x, or x <= x + y where the sum does
// not wrap.
template <typename Bound>
bool is_known_true(const Kernel& kernel, const Inst& compare, const Bound& bound) {
  const bool less = compare.op == Op::kULt;
  if ((!less && compare.op != Op::kULe) || kernel.at(compare.operand[0]).type != Type::kI32) return false;
  const Inst& right = kernel.at(compare.operand[1]);
  if (right.op == Op::kConst) return bound(compare.operand[0]) + less <= right.imm;
  if (!less && bound(compare.operand[0]) == 0) return true;
  if (less || right.op != Op::kIAdd) return false;
  const bool is_part = right.operand[0] == compare.operand[0] || right.operand[1] == compare.operand[0];
  return is_part && bound(right.operand[0]) + bound(right.operand[1]) <= kAnyU32;
}

inline uint64_t upper_bound(const Kernel& kernel, Value v, uint32_t depth = 0) {
  constexpr uint32_t kMaxDepth = 6;
  if (depth > kMaxDepth || kernel.at(v).type != Type::kI32) return kAnyU32;
  return expression_bound(kernel, kernel.at(v), [&](Value operand) { return upper_bound(kernel, operand, depth + 1); });
}

}  // namespace pineda::ir
