// A loop with a break carries more than it needs. The translator guards the rest of the body with flags, so a counter's next
// value is select(broken, i, i + 1): it differs between lanes, and everything that is indexed by i becomes a gather. But a
// carried value matters in two ways only: to a lane that goes round again, for which `again` is known to be true, and to a
// Result. So
//   * what nobody reads as a Result is simplified knowing that `again` holds:  i + 1;
//   * what is read as a Result, too, gets a second carried value for the body, when that one is uniform.
#include <algorithm>
#include <optional>

#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Type;
using ir::Value;

constexpr size_t kMaxFacts = 64;
constexpr int kMaxDepth = 12;
constexpr int kMaxClones = 4;  // instructions recomputed at the end of the body for one carried value

// How deeply the region that a value stands in is nested. Of the values that an expression in some region reaches, those at least
// as deep as the region are inside of it.
using Depths = std::vector<uint32_t>;  // by value

// B1 values that are known at the end of a loop body where a condition holds.
class Facts {
 public:
  Facts(const ir::Kernel& kernel, const Depths& depth_of, uint32_t body_depth, Value condition)
      : kernel_(kernel), depth_of_(depth_of), body_depth_(body_depth) {
    learn(condition, true, 0);
  }

  std::optional<bool> known(Value v, int depth = 0) const {
    const Inst& inst = kernel_.at(v);
    if (inst.type != Type::kB1) return {};
    if (inst.op == Op::kConst) return inst.imm != 0;
    for (const auto& [value, truth] : facts_) {
      if (value == v) return truth;
    }
    constexpr int kMaxKnownDepth = 3;
    if (depth == kMaxKnownDepth || (inst.op != Op::kNot && inst.op != Op::kAnd && inst.op != Op::kOr)) return {};
    const auto a = known(inst.operand[0], depth + 1);
    if (inst.op == Op::kNot) return a ? std::optional(!*a) : std::nullopt;
    const auto b = known(inst.operand[1], depth + 1);
    const bool decides = inst.op == Op::kOr;  // whatever the other is
    if (a == decides || b == decides) return decides;
    return a && b ? std::optional(!decides) : std::nullopt;
  }

  // A value that equals `v` wherever the facts hold.
  Value reduce(Value v) const {
    for (int depth = 0; depth < kMaxDepth; ++depth) {
      Value condition, sides[2];
      if (!choice(v, condition, sides)) break;
      const auto truth = known(condition);
      if (!truth) break;
      v = sides[*truth ? 0 : 1];
    }
    return v;
  }

 private:
  // Select, or the Result of an If in the body: condition ? sides[0] : sides[1].
  bool choice(Value v, Value& condition, Value (&sides)[2]) const {
    const Inst& inst = kernel_.at(v);
    if (inst.op == Op::kSelect) {
      condition = inst.operand[0];
      sides[0] = inst.operand[1], sides[1] = inst.operand[2];
      return true;
    }
    if (inst.op != Op::kResult || kernel_.at(inst.operand[0]).op != Op::kIf || depth_of_[v.id] < body_depth_) return false;
    const Inst& branch = kernel_.at(inst.operand[0]);
    condition = branch.operand[0];
    for (int s = 0; s < 2; ++s) sides[s] = ir::yielded(kernel_, branch.region[s])[inst.imm];
    return true;
  }

  void learn(Value v, bool truth, int depth) {
    const Inst& inst = kernel_.at(v);
    if (inst.op == Op::kConst || depth > kMaxDepth || facts_.size() >= kMaxFacts || known(v)) return;
    facts_.push_back({v, truth});
    if (inst.op == Op::kNot) return learn(inst.operand[0], !truth, depth + 1);
    if (inst.op == (truth ? Op::kAnd : Op::kOr)) {
      learn(inst.operand[0], truth, depth + 1);
      return learn(inst.operand[1], truth, depth + 1);
    }
    Value condition, sides[2];
    if (!choice(v, condition, sides)) return;
    for (int s = 0; s < 2; ++s) {  // a side that is the other constant was not taken
      const Inst& side = kernel_.at(sides[s]);
      if (side.op != Op::kConst || (side.imm != 0) == truth) continue;
      learn(condition, s == 1, depth + 1);
      return learn(sides[1 - s], truth, depth + 1);
    }
  }

  struct Fact {
    Value value;
    bool truth;
  };
  const ir::Kernel& kernel_;
  const Depths& depth_of_;
  const uint32_t body_depth_;
  std::vector<Fact> facts_;
};

class Narrower {
 public:
  explicit Narrower(ir::Kernel& kernel) : kernel_(kernel), depth_of_(kernel.insts.size()) {}

  void region(RegionId id, uint32_t depth) {
    // By index: loops below may add instructions to regions, but not to this one.
    for (size_t i = 0; i < kernel_.regions[id].insts.size(); ++i) {
      const Value v = kernel_.regions[id].insts[i];
      set_depth(v, depth);
      const Inst inst = kernel_.at(v);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) region(inst.region[r], depth + 1);
      if (inst.op == Op::kLoop) loop(v, results_after(id, i), depth + 1);
    }
  }

 private:
  void set_depth(Value v, uint32_t depth) {
    if (v.id >= depth_of_.size()) depth_of_.resize(v.id + 1);
    depth_of_[v.id] = depth;
  }

  std::vector<bool> results_after(RegionId id, size_t at) const {
    const auto& insts = kernel_.regions[id].insts;
    std::vector<bool> out(kernel_.lists[kernel_.at(insts[at]).list].size());
    for (size_t i = at + 1; i < insts.size() && kernel_.at(insts[i]).op == Op::kResult; ++i) out[kernel_.at(insts[i]).imm] = true;
    return out;
  }

  std::vector<Value>& yields(RegionId body) { return kernel_.lists[kernel_.at(ir::yield_of(kernel_, body)).list]; }

  void loop(Value v, const std::vector<bool>& has_result, uint32_t body_depth) {
    const RegionId body = kernel_.at(v).region[0];
    const Facts facts(kernel_, depth_of_, body_depth, yields(body)[0]);
    std::vector<Value> reduced;
    for (size_t k = 0; k < has_result.size(); ++k) {
      reduced.push_back(facts.reduce(yields(body)[k + 1]));
      // a flag that is still what it was at the start
      const Value first = kernel_.lists[kernel_.at(v).list][k];
      const auto start = facts.known(first);
      if (start && facts.known(reduced[k]) == start && kernel_.at(first).op == Op::kConst) reduced[k] = first;
    }
    const std::vector<bool> uniform = uniform_values(v, reduced);
    std::optional<Aliases> split;  // as large as the kernel, so made for the loops that need it
    for (size_t k = 0; k < has_result.size(); ++k) {
      if (reduced[k] == yields(body)[k + 1] || (has_result[k] && !uniform[k])) continue;
      const Value next = make_visible(reduced[k], body, body_depth);
      if (!next) continue;
      if (!has_result[k]) {
        yields(body)[k + 1] = next;
      } else {
        if (!split) split.emplace(kernel_);
        split->set(kernel_.regions[body].insts[k], add_carried(v, k, next));
      }
    }
    if (split) ir::for_each_inst(kernel_, body, [&](Value inst) { split->apply(kernel_, inst); });
  }

  // Which carried values are the same in all lanes if `next` is what they become. Optimistic: those that fail are taken out until
  // none does.
  std::vector<bool> uniform_values(Value loop, const std::vector<Value>& next) const {
    const auto& init = kernel_.lists[kernel_.at(loop).list];
    const auto& args = kernel_.regions[kernel_.at(loop).region[0]].insts;
    std::vector<bool> uniform(next.size(), true);
    const auto is_uniform = [&](auto&& self, Value v, int depth) -> bool {
      const Inst& inst = kernel_.at(v);
      if (inst.op == Op::kLoopArg && inst.imm < next.size() && args[inst.imm] == v) return uniform[inst.imm];
      if (inst.op == Op::kConst || inst.rate != ir::Rate::kLane) return true;
      if (!is_cheap(inst) || depth > kMaxDepth) return false;
      return std::ranges::all_of(inst.operand, [&](Value operand) { return !operand || self(self, operand, depth + 1); });
    };
    for (bool changed = true; changed;) {
      changed = false;
      for (size_t k = 0; k < next.size(); ++k) {
        if (!uniform[k] || (is_uniform(is_uniform, init[k], kMaxDepth) && is_uniform(is_uniform, next[k], kMaxDepth - 3)))
          continue;
        uniform[k] = false;
        changed = true;
      }
    }
    return uniform;
  }

  static bool is_cheap(const Inst& inst) {
    return inst.op > Op::kLane && inst.op <= Op::kSelect && inst.op != Op::kUDiv && inst.op != Op::kSDiv &&
           inst.op != Op::kURem && inst.op != Op::kSRem && inst.op != Op::kFDiv && inst.op != Op::kFSqrt &&
           !ir::is_transcendental(inst.op);
  }

  // `v` itself when the end of the body sees it, else a copy that stands there; none when that would take too much.
  Value make_visible(Value v, RegionId body, uint32_t body_depth) {
    int clones = 0;
    if (!can_clone(v, body_depth, clones)) return {};
    return clone(v, body, body_depth);
  }

  bool is_visible(Value v, uint32_t body_depth) const { return depth_of_[v.id] <= body_depth; }

  bool can_clone(Value v, uint32_t body_depth, int& clones) const {
    if (is_visible(v, body_depth)) return true;
    const Inst& inst = kernel_.at(v);
    if (inst.op == Op::kConst) return true;
    if (!is_cheap(inst) || ++clones > kMaxClones) return false;
    return std::ranges::all_of(inst.operand, [&](Value operand) { return !operand || can_clone(operand, body_depth, clones); });
  }

  Value clone(Value v, RegionId body, uint32_t body_depth) {
    if (is_visible(v, body_depth)) return v;
    Inst inst = kernel_.at(v);
    for (Value& operand : inst.operand) {
      if (operand) operand = clone(operand, body, body_depth);
    }
    const Value copy = add_inst(kernel_, inst);
    set_depth(copy, body_depth);
    auto& insts = kernel_.regions[body].insts;
    insts.insert(insts.end() - 1, copy);
    return copy;
  }

  // A carried value that starts as value k does and becomes `next`; gives its LoopArg.
  Value add_carried(Value loop, size_t k, Value next) {
    const RegionId body = kernel_.at(loop).region[0];
    auto& init = kernel_.lists[kernel_.at(loop).list];
    const Value first = init[k];
    const Value arg = add_inst(kernel_, {.op = Op::kLoopArg, .type = kernel_.at(first).type, .imm = init.size()});
    set_depth(arg, depth_of_[kernel_.regions[body].insts[k].id]);
    auto& insts = kernel_.regions[body].insts;
    insts.insert(insts.begin() + static_cast<ptrdiff_t>(init.size()), arg);
    init.push_back(first);
    yields(body).push_back(next);
    return arg;
  }

  ir::Kernel& kernel_;
  Depths depth_of_;
};

}  // namespace

void narrow_loops(ir::Kernel& k) {
  Narrower narrower(k);
  narrower.region(k.wave, 0);
}

}  // namespace pineda::passes
