// If and Loop. Lanes that disagree are handled by masks: both sides of an If run, each under its own mask, and are branched
// around when no lane wants them; a Loop runs until its last lane leaves.
#include "compiler/ir/walk.h"
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;
using ir::Type;

std::vector<ir::Value> Emitter::results_of(ir::Value id) const {
  const auto found = results_.find(id.id);
  return found == results_.end() ? std::vector<ir::Value>() : found->second;
}

// ---- if -------------------------------------------------------------------------------------------------------------------

// Up to this many instructions cost less than a branch that has to look at the mask first.
constexpr uint32_t kFlatCost = 10;

bool Emitter::is_trivial(ir::RegionId region) const { return kernel_.regions[region].insts.size() == 1; }

// Whether the region may run for lanes that did not ask for it: no effects, no faults, and short. Adds up about how many
// instructions it takes.
bool Emitter::is_flat(ir::RegionId region, uint32_t* cost) const {
  constexpr uint32_t kSlow = 6;  // division, square root, scalarised operations
  for (ir::Value v : kernel_.regions[region].insts) {
    if (*cost > kFlatCost) return false;
    const ir::Inst& inst = kernel_.at(v);
    switch (inst.op) {
      case Op::kConst:
      case Op::kResult:
      case Op::kYield:
      case Op::kBitcast:
        break;
      case Op::kFDiv:
      case Op::kFSqrt:
      case Op::kUDiv:
      case Op::kSDiv:
      case Op::kURem:
      case Op::kSRem:
        *cost += kSlow;
        break;
      case Op::kFMa:
        *cost += features_.fma ? 1 : kSlow;
        break;
      case Op::kIf:
        *cost += 1;
        if (!is_flat(inst.region[0], cost) || !is_flat(inst.region[1], cost)) return false;
        break;
      default:
        if (ir::op_info(inst.op).effect != ir::Effect::kPure) return false;
        *cost += 1;
    }
  }
  return true;
}

void Emitter::emit_if(const ir::Inst& inst, ir::Value id) {
  if (!is_lane(inst.operand[0]))
    return is_known_true(inst.operand[0], true) ? emit_first_side(inst, id) : emit_uniform_if(inst, id);
  uint32_t cost = 0;
  if (is_flat(inst.region[0], &cost) && is_flat(inst.region[1], &cost) && cost <= kFlatCost) return emit_flat_if(inst, id);
  emit_divergent_if(inst, id);
}

// The values that `results` read from a region just emitted, in the shape of those results.
std::vector<Emitter::V> Emitter::yielded_values(ir::RegionId region, const std::vector<ir::Value>& results, bool as_lanes) {
  std::vector<V> values;
  const auto& list = ir::yielded(kernel_, region);
  for (ir::Value r : results) {
    const ir::Inst& result = kernel_.at(r);
    values.push_back(get(list[result.imm], as_lanes || result.rate == ir::Rate::kLane));
  }
  return values;
}

// What the constructs around tell decides it.
void Emitter::emit_first_side(const ir::Inst& inst, ir::Value id) {
  emit_insts(inst.region[0]);
  const std::vector<ir::Value> results = results_of(id);
  const std::vector<V> values = yielded_values(inst.region[0], results, false);
  for (size_t k = 0; k < results.size(); ++k) value_[results[k].id] = values[k];
}

void Emitter::emit_uniform_if(const ir::Inst& inst, ir::Value id) {
  const std::vector<ir::Value> results = results_of(id);
  llvm::BasicBlock *sides[2] = {block("then"), block("else")}, *join = block("endif"), *ends[2];
  std::vector<V> values[2];
  constexpr uint32_t kLikelyWeight = 2000;
  llvm::MDNode* const weights =
      inst.flags & ir::kLikely ? llvm::MDBuilder(context_).createBranchWeights(kLikelyWeight, 1) : nullptr;
  b_.CreateCondBr(scalar(inst.operand[0]), sides[0], sides[1], weights);
  for (int side = 0; side < 2; ++side) {
    start(sides[side]);
    const size_t known = facts_.size();
    if (side == 0) learn(inst.operand[0]);
    emit_insts(inst.region[side]);
    facts_.resize(known);
    values[side] = yielded_values(inst.region[side], results, false);
    ends[side] = b_.GetInsertBlock();
    b_.CreateBr(join);
  }
  start(join);
  for (size_t k = 0; k < results.size(); ++k) {
    llvm::PHINode* phi = b_.CreatePHI(values[0][k]->getType(), 2);
    for (int side = 0; side < 2; ++side) phi->addIncoming(values[side][k], ends[side]);
    value_[results[k].id] = phi;
  }
}

// Straight-line: all lanes run both sides.
void Emitter::emit_flat_if(const ir::Inst& inst, ir::Value id) {
  const std::vector<ir::Value> results = results_of(id);
  V cond = vector(inst.operand[0]);
  emit_insts(inst.region[0]);
  emit_insts(inst.region[1]);
  merge_sides(cond, results, yielded_values(inst.region[0], results, true), yielded_values(inst.region[1], results, true));
}

void Emitter::emit_divergent_if(const ir::Inst& inst, ir::Value id) {
  const std::vector<ir::Value> results = results_of(id);
  V cond = vector(inst.operand[0]);
  const size_t known = facts_.size();
  learn(inst.operand[0]);
  std::vector<V> then_values = emit_guarded_side(inst.region[0], exec_and(cond), results);
  facts_.resize(known);
  std::vector<V> else_values =
      emit_guarded_side(inst.region[1], is_trivial(inst.region[1]) ? nullptr : exec_and(mask_not(cond)), results);
  merge_sides(cond, results, then_values, else_values);
}

void Emitter::merge_sides(V cond, const std::vector<ir::Value>& results, const std::vector<V>& then_values,
                          const std::vector<V>& else_values) {
  for (size_t k = 0; k < results.size(); ++k) {
    if (kernel_.at(results[k]).rate != ir::Rate::kLane) fail("the result of a divergent if is rated uniform", b_.getVoidTy());
    value_[results[k].id] = b_.CreateSelect(to_i1(cond), then_values[k], else_values[k]);
  }
}

// One side of a divergent If under `mask`, skipped when no lane wants it; its values are then zero (nobody looks, but they must
// not be poison).
std::vector<Emitter::V> Emitter::emit_guarded_side(ir::RegionId region, V mask, const std::vector<ir::Value>& results) {
  if (is_trivial(region)) return yielded_values(region, results, true);
  llvm::BasicBlock *before = b_.GetInsertBlock(), *side = block("side"), *join = block("join");
  V wanted = any(mask);
  b_.CreateCondBr(wanted, side, join);
  start(side);
  const Exec outer = exec_;
  exec_ = {mask};
  emit_insts(region);
  std::vector<V> values = yielded_values(region, results, true);
  exec_ = outer;
  llvm::BasicBlock* end = b_.GetInsertBlock();
  b_.CreateBr(join);
  start(join);
  for (V& value : values) {
    llvm::PHINode* phi = b_.CreatePHI(value->getType(), 2);
    phi->addIncoming(value, end);
    phi->addIncoming(llvm::Constant::getNullValue(value->getType()), before);
    value = phi;
  }
  return values;
}

// ---- loop -----------------------------------------------------------------------------------------------------------------

// A value carried round a loop. `arg` is what the body reads; `result` keeps each lane's last `next` when lanes leave at
// different times. Both are the same phi where possible: blending then serves the body, too.
struct Emitter::Carried {
  ir::Value arg, result, next;  // none where nobody reads it
  llvm::PHINode* arg_phi = nullptr;
  llvm::PHINode* result_phi = nullptr;
};

std::vector<Emitter::Carried> Emitter::loop_carried(const ir::Inst& inst, ir::Value id) {
  const auto& init = kernel_.lists[inst.list];
  const auto& yielded = ir::yielded(kernel_, inst.region[0]);
  const auto& body = kernel_.regions[inst.region[0]].insts;
  std::vector<Carried> carried(init.size());
  for (size_t k = 0; k < init.size(); ++k) {
    carried[k].arg = body[k];  // the verifier: LoopArgs stand first, in order
    carried[k].next = yielded[k + 1];
    loop_of_arg_[body[k].id] = id;
  }
  for (ir::Value r : results_of(id)) carried[kernel_.at(r).imm].result = r;
  return carried;
}

void Emitter::emit_loop(const ir::Inst& inst, ir::Value id) {
  const ir::Value again = ir::yielded(kernel_, inst.region[0])[0];
  const bool divergent = is_lane(again);
  const auto& init = kernel_.lists[inst.list];
  std::vector<Carried> carried = loop_carried(inst, id);

  // initial values, in the shape of their phis
  std::vector<V> first_arg;
  for (size_t k = 0; k < carried.size(); ++k) {
    first_arg.push_back(get(init[k], is_lane(carried[k].arg)));
  }
  llvm::BasicBlock *before = b_.GetInsertBlock(), *body = block("loop"), *done = block("loop.done");
  const Exec outer = exec_;
  V first_mask = outer.full() ? full_mask() : outer.lanes;
  b_.CreateBr(body);
  start(body);
  llvm::PHINode* mask = nullptr;
  if (divergent) {
    mask = b_.CreatePHI(first_mask->getType(), 2, "mask");
    mask->addIncoming(first_mask, before);
    exec_ = {mask};
  }
  for (size_t k = 0; k < carried.size(); ++k) start_carried(carried[k], first_arg[k], before, divergent);
  emit_insts(inst.region[0]);

  std::vector<V> latch_results;
  for (Carried& c : carried) latch_results.push_back(next_carried(c, mask));
  V stay = divergent ? b_.CreateAnd(mask, vector(again)) : scalar(again);
  V repeat = divergent ? any(stay) : stay;
  llvm::BasicBlock* latch = b_.GetInsertBlock();
  if (divergent) mask->addIncoming(stay, latch);
  for (size_t k = 0; k < carried.size(); ++k) {
    const Carried& c = carried[k];
    const bool shared = c.result_phi == c.arg_phi;
    c.arg_phi->addIncoming(shared ? latch_results[k] : get(c.next, is_lane(c.arg)), latch);
    if (!shared && c.result_phi != nullptr) c.result_phi->addIncoming(latch_results[k], latch);
    if (c.result) value_[c.result.id] = latch_results[k];
  }
  // Volatile: another thread writes the word, so the load stays in the loop.
  V stop = b_.CreateLoad(b_.getInt32Ty(), stop_ptr_, /*isVolatile=*/true);
  b_.CreateCondBr(b_.CreateAnd(repeat, b_.CreateIsNull(stop)), body, done);
  start(done);
  exec_ = outer;
}

void Emitter::start_carried(Carried& c, V first, llvm::BasicBlock* before, bool divergent) {
  c.arg_phi = b_.CreatePHI(first->getType(), 2);
  c.arg_phi->addIncoming(first, before);
  value_[c.arg.id] = c.arg_phi;
  if (!c.result || !divergent) return;
  if (kernel_.at(c.result).rate != ir::Rate::kLane) {
    fail("the result of a divergent loop is rated uniform", b_.getVoidTy());
    return;
  }
  if (is_lane(c.arg)) {
    c.result_phi = c.arg_phi;
  } else {
    V zero = llvm::Constant::getNullValue(value_type(kernel_.at(c.result).type, true));
    c.result_phi = b_.CreatePHI(zero->getType(), 2);
    c.result_phi->addIncoming(zero, before);
  }
}

// What Result gives if the loop ends now; null where nobody asks.
Emitter::V Emitter::next_carried(const Carried& c, V mask) {
  if (!c.result) return nullptr;
  const bool lanes = kernel_.at(c.result).rate == ir::Rate::kLane;
  V next = get(c.next, lanes);
  return c.result_phi == nullptr ? next : b_.CreateSelect(to_i1(mask), next, c.result_phi);
}

}  // namespace pineda::jit
