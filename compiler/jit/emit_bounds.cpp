// Bounds of accesses: which need no check, and the checks of the others.
#include <algorithm>

#include "compiler/ir/ranges.h"
#include "compiler/ir/walk.h"
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;

// ---- ranges ---------------------------------------------------------------------------------------------------------------
// Looks at the IR, not at LLVM's values: see Emitter::b_.

constexpr uint64_t kAny = ir::kAnyU32;
constexpr uint64_t kNonNegative = 0x7fffffff;

// The largest value that an I32 can have, as far as its expression tells, and, in active lanes, what the Ifs and Loops around the
// place that is being emitted tell.
uint64_t Emitter::upper_bound(ir::Value v, bool with_facts, uint32_t depth) const {
  constexpr uint32_t kMaxDepth = 8;
  if (depth > kMaxDepth) return kAny;
  uint64_t out = expression_bound(v, with_facts, depth);
  for (const auto& [value, most] : facts_) {
    if (with_facts && value == v) out = std::min(out, most);
  }
  return out;
}

uint64_t Emitter::expression_bound(ir::Value v, bool with_facts, uint32_t depth) const {
  const ir::Inst& inst = kernel_.at(v);
  if (inst.op == Op::kLoopArg) return with_facts ? carried_bound(v, depth) : kAny;
  return ir::expression_bound(kernel_, inst, [&](ir::Value operand) { return upper_bound(operand, with_facts, depth + 1); });
}

// Calls fn for each comparison that holds where `condition` does.
void Emitter::for_each_implied(ir::Value condition, const std::function<void(const ir::Inst&)>& fn, uint32_t depth) const {
  constexpr uint32_t kMaxDepth = 6;
  const ir::Inst& inst = kernel_.at(condition);
  const auto is_false = [&](ir::Value v) { return kernel_.at(v).op == Op::kConst && kernel_.at(v).imm == 0; };
  if (depth > kMaxDepth) return;
  if (inst.op == Op::kAnd) {
    for (uint32_t i = 0; i < 2; ++i) for_each_implied(inst.operand[i], fn, depth + 1);
  } else if (inst.op == Op::kSelect && is_false(inst.operand[2])) {
    for (uint32_t i = 0; i < 2; ++i) for_each_implied(inst.operand[i], fn, depth + 1);
  } else if (inst.op == Op::kResult && kernel_.at(inst.operand[0]).op == Op::kIf) {
    const ir::Inst& branch = kernel_.at(inst.operand[0]);
    if (!is_false(ir::yielded(kernel_, branch.region[1])[inst.imm])) return;
    for_each_implied(branch.operand[0], fn, depth + 1);
    for_each_implied(ir::yielded(kernel_, branch.region[0])[inst.imm], fn, depth + 1);
  } else if (inst.op == Op::kULt || inst.op == Op::kULe || inst.op == Op::kSLt || inst.op == Op::kSLe) {
    if (kernel_.at(inst.operand[0]).type == ir::Type::kI32) fn(inst);
  }
}

// What x is at most where x < y (or <=) holds; kAny when that tells nothing. `x_bound` is known of x otherwise.
uint64_t Emitter::compared_bound(const ir::Inst& compare, uint64_t x_bound, bool with_facts) const {
  const uint64_t y = upper_bound(compare.operand[1], with_facts);
  const bool is_signed = compare.op == Op::kSLt || compare.op == Op::kSLe;
  if (is_signed && (y > kNonNegative || x_bound > kNonNegative)) return kAny;
  const bool less = compare.op == Op::kULt || compare.op == Op::kSLt;
  return less && y > 0 ? y - 1 : y;
}

void Emitter::learn(ir::Value condition) {
  for_each_implied(
      condition,
      [&](const ir::Inst& compare) {
        const uint64_t before = upper_bound(compare.operand[0], true);
        const uint64_t most = compared_bound(compare, before, true);
        if (most < before) facts_.push_back({compare.operand[0], most});
      },
      0);
}

// A LoopArg is its initial value, or a next value of which the loop's condition held.
uint64_t Emitter::carried_bound(ir::Value arg, uint32_t depth) const {
  const auto owner = loop_of_arg_.find(arg.id);
  if (owner == loop_of_arg_.end() || kernel_.at(arg).type != ir::Type::kI32) return kAny;
  const ir::Inst& loop = kernel_.at(owner->second);
  const uint64_t k = kernel_.at(arg).imm;
  const auto& values = ir::yielded(kernel_, loop.region[0]);
  const ir::Inst& next = kernel_.at(values[k + 1]);
  const ir::Inst* step = next.op == Op::kIAdd && next.operand[0] == arg   ? &kernel_.at(next.operand[1])
                         : next.op == Op::kIAdd && next.operand[1] == arg ? &kernel_.at(next.operand[0])
                                                                          : nullptr;
  const uint64_t first = upper_bound(kernel_.lists[loop.list][k], true, depth + 1);
  // By induction a counter that starts at 0 or above and is compared before it can overflow never is negative.
  constexpr uint64_t kMaxStep = 1 << 30;
  const bool counts = step != nullptr && step->op == Op::kConst && step->imm < kMaxStep && first < kMaxStep;
  uint64_t most = kAny;
  for_each_implied(
      values[0],
      [&](const ir::Inst& compare) {
        const bool of_next = compare.operand[0] == values[k + 1], of_arg = counts && compare.operand[0] == arg;
        if (!of_next && !of_arg) return;
        // Without facts: they are about this turn, the comparison was one of the turn before.
        const uint64_t held = compared_bound(compare, counts ? 0 : kAny, false);
        if (counts && held >= kMaxStep) return;
        most = std::min(most, of_next ? held : held + step->imm);
      },
      0);
  return most == kAny ? kAny : std::max(first, most);
}

// A limit of the form "x <= c ? limit : 0" is what the translator gives an offset that may have wrapped (spirv/pointer.cpp). What
// is known to hold is left out; else it is a condition of its own, so that the limit stays uniform.
bool Emitter::is_known_true(ir::Value condition, bool with_facts) const {
  const ir::Inst& inst = kernel_.at(condition);
  if (inst.op == Op::kConst) return inst.imm != 0;
  if (inst.op == Op::kAnd) return is_known_true(inst.operand[0], with_facts) && is_known_true(inst.operand[1], with_facts);
  return ir::is_known_true(kernel_, inst, [&](ir::Value v) { return upper_bound(v, with_facts); });
}

void Emitter::set_limit(Access& a, ir::Value limit, bool with_facts) {
  const ir::Inst& inst = kernel_.at(limit);
  const bool guarded = ir::is_guarded_limit(inst, kernel_);
  if (guarded && is_known_true(inst.operand[0], with_facts)) return set_limit(a, inst.operand[1], with_facts);
  const bool split = guarded && is_lane(inst.operand[0]) && !is_lane(inst.operand[1]);
  if (split) a.where = vector(inst.operand[0]);
  const ir::Value plain = split ? inst.operand[1] : limit;
  a.limit = get(plain, is_lane(plain));
}

// ---- checks ---------------------------------------------------------------------------------------------------------------

bool Emitter::is_known_in_bounds(const Access& a) const {
  const auto* limit = llvm::dyn_cast_or_null<llvm::ConstantInt>(a.limit);
  const uint64_t reach_bytes = uint64_t{kLanes - 1} * a.lane_stride_bytes + a.size_bytes;  // from lane 0's offset to the last end
  return limit != nullptr && a.offset_bound + reach_bytes <= limit->getZExtValue();
}

// In bounds means offset + k <= limit with k = lane * stride + size, in exact arithmetic. As limit -sat- (k - 1) is either limit
// - k + 1 or 0, this is offset < limit -sat- (k - 1): one unsigned compare with a value that is mostly uniform.

Emitter::V Emitter::uniform_in_bounds(const Access& a) {
  if (a.limit == nullptr || is_known_in_bounds(a)) return nullptr;
  V room = b_.CreateBinaryIntrinsic(llvm::Intrinsic::usub_sat, a.limit, b_.getInt32(a.size_bytes - 1));
  return b_.CreateICmpULT(a.offset, room);
}

Emitter::V Emitter::lanes_in_bounds(const Access& a) {
  if (a.limit == nullptr || is_known_in_bounds(a)) return a.where;
  std::vector<uint32_t> k_less_1(kLanes);
  for (uint32_t l = 0; l < kLanes; ++l) {
    // Saturated: a k beyond 2^32 lets nothing in, whatever the limit, as the difference is then 0.
    k_less_1[l] = static_cast<uint32_t>(std::min<uint64_t>(uint64_t{l} * a.lane_stride_bytes + a.size_bytes - 1, ~0u));
  }
  const auto in_lanes = [&](V x) { return is_vector(x) ? x : b_.CreateVectorSplat(kLanes, x); };
  V room = a.lane_stride_bytes == 0 && !is_vector(a.limit)
               ? in_lanes(b_.CreateBinaryIntrinsic(llvm::Intrinsic::usub_sat, a.limit, b_.getInt32(a.size_bytes - 1)))
               : b_.CreateBinaryIntrinsic(llvm::Intrinsic::usub_sat, in_lanes(a.limit),
                                          llvm::ConstantDataVector::get(context_, k_less_1));
  return both(from_i1(b_.CreateICmpULT(in_lanes(a.offset), room)), a.where);
}

// Of masks that may be null: all lanes.
Emitter::V Emitter::both(V a, V b) { return a == nullptr ? b : b == nullptr ? a : b_.CreateAnd(a, b); }

}  // namespace pineda::jit
