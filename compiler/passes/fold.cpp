// One walk in program order: constants, identities (simplify.h), Ifs whose condition is known, Results that need no If, carried
// values that never change. Inside a region of an If, its condition is a known constant, so the guards that the translator nests
// (break, return and kill flags) fall out.
#include <algorithm>

#include "base/float_environment.h"
#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"
#include "compiler/passes/simplify.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Type;
using ir::Value;

class Folder {
 public:
  Folder(ir::Kernel& kernel, ir::Floats floats) : kernel_(kernel), aliases_(kernel), simplifier_(kernel, floats) {}

  void run() {
    for (RegionId root : {kernel_.draw, kernel_.prim, kernel_.wave}) {
      if (root != 0) region(root, /*scoped=*/false);
    }
  }

 private:
  using Insts = std::vector<Value>;

  bool is_visible(Value v) const { return v.id < visible_.size() && visible_[v.id]; }

  void push(Value v, Insts& out) {
    if (v.id >= visible_.size()) visible_.resize(std::max<size_t>(v.id + 1, kernel_.insts.size()));
    visible_[v.id] = true;
    out.push_back(v);
  }

  void region(RegionId id, bool scoped) {
    const Insts old = std::move(kernel_.regions[id].insts);
    Insts out;
    out.reserve(old.size());
    inline_insts(old, out);
    if (scoped) {
      for (Value v : out) visible_[v.id] = false;
    }
    kernel_.regions[id].insts = std::move(out);
  }

  // Folds a list of instructions to the end of `out`.
  void inline_insts(const Insts& insts, Insts& out) {
    for (size_t i = 0; i < insts.size(); ++i) {
      const Value v = insts[i];
      aliases_.apply(kernel_, v);
      const Op op = kernel_.at(v).op;
      if (!ir::has_regions(op)) {
        instruction(v, out);
        continue;
      }
      size_t end = i + 1;
      while (end < insts.size() && kernel_.at(insts[end]).op == Op::kResult) ++end;
      const Insts results(insts.begin() + static_cast<ptrdiff_t>(i) + 1, insts.begin() + static_cast<ptrdiff_t>(end));
      op == Op::kIf ? if_else(v, results, out) : loop(v, results, out);
      i = end - 1;
    }
  }

  void instruction(Value v, Insts& out) {
    Inst inst = kernel_.at(v);
    Insts before;
    const Value same = simplifier_.simplify(inst, before);
    for (Value added : before) push(added, out);
    kernel_.at(v) = inst;
    if (same) {
      aliases_.set(v, aliases_.resolve(same));
    } else {
      push(v, out);
    }
  }

  // ---- If -------------------------------------------------------------------------------------------------------------------

  std::vector<Value>& yields(RegionId id) { return kernel_.lists[kernel_.at(ir::yield_of(kernel_, id)).list]; }

  // Sides that both write are never swapped: where lanes race, the order of the sides shows.
  bool has_writes(RegionId id) const {
    bool out = false;
    ir::for_each_inst(kernel_, id, [&](Value v) { out |= writes(kernel_.at(v)); });
    return out;
  }

  void if_else(Value v, const Insts& results, Insts& out) {
    Inst inst = kernel_.at(v);
    while (kernel_.at(inst.operand[0]).op == Op::kNot && !(has_writes(inst.region[0]) && has_writes(inst.region[1]))) {
      inst.operand[0] = aliases_.resolve(kernel_.at(inst.operand[0]).operand[0]);
      std::swap(inst.region[0], inst.region[1]);
    }
    kernel_.at(v) = inst;
    const Value cond = inst.operand[0];
    if (kernel_.at(cond).op == Op::kConst) return take_side(inst.region[kernel_.at(cond).imm != 0 ? 0 : 1], results, out);
    for (uint32_t side = 0; side < 2; ++side) {
      const size_t mark = assumed_.size();
      assume(cond, side == 0, 0, out);
      region(inst.region[side], /*scoped=*/true);
      for (; assumed_.size() > mark; assumed_.pop_back()) aliases_.set(assumed_.back().value, assumed_.back().before);
    }
    push(v, out);
    Insts replaced;
    for (Value result : results) {
      const uint64_t k = kernel_.at(result).imm;
      const bool outside = is_movable(yields(inst.region[0])[k]) && is_movable(yields(inst.region[1])[k]);
      if (outside) {
        replaced.push_back(result);
      } else {
        push(result, out);
      }
    }
    for (Value result : replaced) to_select(result, inst, out);
  }

  // The If is decided: its side's instructions stand in its place.
  void take_side(RegionId side, const Insts& results, Insts& out) {
    Insts insts = std::move(kernel_.regions[side].insts);
    const Value yield = insts.back();
    insts.pop_back();
    inline_insts(insts, out);
    aliases_.apply(kernel_, yield);
    for (Value result : results) {
      aliases_.set(result, kernel_.lists[kernel_.at(yield).list][kernel_.at(result).imm]);
    }
  }

  // Within a region `v` has a known value, and so have the conditions that it consists of.
  void assume(Value v, bool value, int depth, Insts& out) {
    const Inst inst = kernel_.at(v);
    if (inst.op == Op::kConst || depth > 8) return;
    assumed_.push_back({v, aliases_.get(v)});
    aliases_.set(v, truth(value, out));
    if (inst.op == Op::kNot) assume(aliases_.resolve(inst.operand[0]), !value, depth + 1, out);
    if (inst.op == (value ? Op::kAnd : Op::kOr)) {
      for (uint32_t i = 0; i < 2; ++i) assume(aliases_.resolve(inst.operand[i]), value, depth + 1, out);
    }
  }

  // A B1 constant that is visible where `out` ends.
  Value truth(bool value, Insts& out) {
    if (!is_visible(truth_[value])) {
      truth_[value] = add_inst(kernel_, {.op = Op::kConst, .type = Type::kB1, .imm = value});
      push(truth_[value], out);
    }
    return truth_[value];
  }

  bool is_movable(Value v) const { return kernel_.at(v).op == Op::kConst || is_visible(v); }

  // A Result whose two values are known outside of the If needs only its condition.
  void to_select(Value result, const Inst& branch, Insts& out) {
    const uint64_t k = kernel_.at(result).imm;
    std::array<Value, 2> side;
    for (uint32_t s = 0; s < 2; ++s) {
      side[s] = yields(branch.region[s])[k];
      if (!is_visible(side[s])) {
        side[s] = add_inst(kernel_, kernel_.at(side[s]));
        push(side[s], out);
      }
    }
    kernel_.at(result) = {.op = Op::kSelect, .type = kernel_.at(result).type, .operand = {branch.operand[0], side[0], side[1]}};
    instruction(result, out);
  }

  // ---- Loop -----------------------------------------------------------------------------------------------------------------

  void loop(Value v, const Insts& results, Insts& out) {
    const Inst inst = kernel_.at(v);
    const RegionId body = inst.region[0];
    const std::vector<Value> init = kernel_.lists[inst.list];
    const Value again = aliases_.resolve(yields(body)[0]);
    if (kernel_.at(again).op == Op::kConst && kernel_.at(again).imm == 0) return run_once(v, results, out);
    std::vector<Value> args(kernel_.regions[body].insts.begin(),
                            kernel_.regions[body].insts.begin() + static_cast<ptrdiff_t>(init.size()));
    for (size_t k = 0; k < init.size(); ++k) {
      const Value next = aliases_.resolve(yields(body)[k + 1]);
      if (next == args[k] || is_same(next, init[k])) aliases_.set(args[k], init[k]);
    }
    region(body, /*scoped=*/true);
    push(v, out);
    for (Value result : results) {
      const uint64_t k = kernel_.at(result).imm;
      if (aliases_.get(args[k])) {
        aliases_.set(result, init[k]);
      } else {
        push(result, out);
      }
    }
  }

  bool is_same(Value a, Value b) const {
    const Inst &first = kernel_.at(a), &second = kernel_.at(b);
    return a == b || (first.op == Op::kConst && second.op == Op::kConst && first.type == second.type && first.imm == second.imm);
  }

  // A loop that leaves after its first turn is its body.
  void run_once(Value v, const Insts& results, Insts& out) {
    const Inst inst = kernel_.at(v);
    Insts insts = std::move(kernel_.regions[inst.region[0]].insts);
    const std::vector<Value> init = kernel_.lists[inst.list];
    const Value yield = insts.back();
    insts.pop_back();
    for (size_t k = 0; k < init.size(); ++k) aliases_.set(insts[k], init[k]);
    insts.erase(insts.begin(), insts.begin() + static_cast<ptrdiff_t>(init.size()));
    inline_insts(insts, out);
    aliases_.apply(kernel_, yield);
    for (Value result : results) {
      aliases_.set(result, kernel_.lists[kernel_.at(yield).list][kernel_.at(result).imm + 1]);
    }
  }

  struct Assumption {
    Value value, before;
  };

  ir::Kernel& kernel_;
  Aliases aliases_;
  Simplifier simplifier_;
  std::vector<bool> visible_;  // by value: defined where the walk stands
  std::vector<Assumption> assumed_;
  std::array<Value, 2> truth_{};  // false, true
};

}  // namespace

void fold(ir::Kernel& k, Form form) {
  const ScopedFloatEnvironment environment;
  Folder(k, form == Form::kMachine ? ir::Floats::kNative : ir::Floats::kDouble).run();
}

}  // namespace pineda::passes
