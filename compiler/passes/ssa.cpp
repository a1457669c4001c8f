// Locals -> values. Control flow is a tree, so no dominance frontiers are needed: a variable that a side of an If stores becomes
// a result of that If, one that a loop body stores becomes a carried value. That is maximal rather than minimal; dce removes what
// nobody reads.
//
// A Local is promoted when every access has a constant index; each element is then a variable of its own.
#include <algorithm>
#include <span>

#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Value;
using VarId = uint32_t;

constexpr VarId kNotPromoted = ~0u;
constexpr uint64_t kMaxPromotedElements = 64;  // larger arrays would become that many results of every If that stores one

class Promoter {
 public:
  explicit Promoter(ir::Kernel& kernel)
      : kernel_(kernel), aliases_(kernel), first_var_(kernel.insts.size(), kNotPromoted), stored_(kernel.regions.size()) {}

  void run() {
    find_variables();
    if (vars_.empty()) return;
    collect_stores(kernel_.wave);
    current_.resize(vars_.size());
    region(kernel_.wave);
    auto& wave = kernel_.regions[kernel_.wave].insts;
    const auto first = std::ranges::find_if(wave, [&](Value v) { return kernel_.at(v).op != Op::kLocal; });
    wave.insert(first, zeros_.begin(), zeros_.end());
  }

 private:
  static bool is_access(Op op) { return op == Op::kLocalLoad || op == Op::kLocalStore; }

  void find_variables() {
    std::vector<bool> rejected(kernel_.insts.size());
    ir::for_each_inst(kernel_, kernel_.wave, [&](Value v) {
      const Inst& inst = kernel_.at(v);
      if (is_access(inst.op) && kernel_.at(inst.operand[1]).op != Op::kConst) rejected[inst.operand[0].id] = true;
    });
    for (Value v : kernel_.regions[kernel_.wave].insts) {
      const Inst& inst = kernel_.at(v);
      if (inst.op != Op::kLocal) break;
      if (rejected[v.id] || inst.imm > kMaxPromotedElements) continue;
      first_var_[v.id] = static_cast<VarId>(vars_.size());
      vars_.insert(vars_.end(), inst.imm, inst.type);
    }
  }

  // The variable of a LocalLoad or LocalStore; out_of_range: an access that ir.h defines as reading 0 and storing nothing.
  struct Access {
    bool promoted = false, out_of_range = false;
    VarId var = 0;
  };
  Access access(const Inst& inst) const {
    if (!is_access(inst.op) || first_var_[inst.operand[0].id] == kNotPromoted) return {};
    const uint64_t index = kernel_.at(inst.operand[1]).imm;
    if (index >= kernel_.at(inst.operand[0]).imm) return {true, true, 0};
    return {true, false, first_var_[inst.operand[0].id] + static_cast<VarId>(index)};
  }

  // Fills stored_ for a region and those in it: the variables it may change, ascending.
  void collect_stores(RegionId id) {
    std::vector<VarId> vars;
    for (Value v : kernel_.regions[id].insts) {
      const Inst& inst = kernel_.at(v);
      const Access a = access(inst);
      if (inst.op == Op::kLocalStore && a.promoted && !a.out_of_range) vars.push_back(a.var);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) {
        collect_stores(inst.region[r]);
        const auto& inner = stored_[inst.region[r]];
        vars.insert(vars.end(), inner.begin(), inner.end());
      }
    }
    std::ranges::sort(vars);
    vars.erase(std::ranges::unique(vars).begin(), vars.end());
    stored_[id] = std::move(vars);
  }

  Value value_of(VarId var) {
    if (!current_[var]) {
      current_[var] = add_zero(kernel_, vars_[var]);
      zeros_.push_back(current_[var]);
    }
    return current_[var];
  }

  void region(RegionId id) {
    const std::vector<Value> old = std::move(kernel_.regions[id].insts);
    std::vector<Value> out;
    out.reserve(old.size());
    for (size_t i = 0; i < old.size(); ++i) {
      const Value v = old[i];
      aliases_.apply(kernel_, v);
      const Inst inst = kernel_.at(v);
      if (const Access a = access(inst); a.promoted) {
        promote(v, inst, a, out);
      } else if (inst.op == Op::kLocal && first_var_[v.id] != kNotPromoted) {
        continue;
      } else if (ir::has_regions(inst.op)) {
        out.push_back(v);
        const std::vector<Value> results = inst.op == Op::kIf ? if_else(v) : loop(v);
        while (i + 1 < old.size() && kernel_.at(old[i + 1]).op == Op::kResult) out.push_back(old[++i]);
        out.insert(out.end(), results.begin(), results.end());
      } else {
        out.push_back(v);
      }
    }
    kernel_.regions[id].insts = std::move(out);
  }

  void promote(Value v, const Inst& inst, const Access& a, std::vector<Value>& out) {
    if (inst.op == Op::kLocalStore) {
      if (!a.out_of_range) current_[a.var] = inst.operand[2];
    } else if (a.out_of_range) {
      kernel_.at(v) = {.op = Op::kConst, .type = inst.type};
      out.push_back(v);
    } else {
      aliases_.set(v, value_of(a.var));
    }
  }

  // Adds a Result for each variable and makes it the variable's value.
  std::vector<Value> add_results(Value owner, std::span<const VarId> vars, uint64_t first_index) {
    std::vector<Value> out;
    for (VarId var : vars) {
      current_[var] =
          add_inst(kernel_, {.op = Op::kResult, .type = vars_[var], .operand = {owner}, .imm = first_index + out.size()});
      out.push_back(current_[var]);
    }
    return out;
  }

  std::vector<Value>& yield_list(RegionId id) { return kernel_.lists[kernel_.at(ir::yield_of(kernel_, id)).list]; }

  std::vector<Value> if_else(Value v) {
    const std::array<RegionId, 2> sides = kernel_.at(v).region;
    std::vector<VarId> changed;
    std::ranges::set_union(stored_[sides[0]], stored_[sides[1]], std::back_inserter(changed));
    std::vector<Value> before;
    for (VarId var : changed) before.push_back(value_of(var));
    const uint64_t first_index = yield_list(sides[0]).size();
    for (RegionId side : sides) {
      for (size_t i = 0; i < changed.size(); ++i) current_[changed[i]] = before[i];
      region(side);
      for (VarId var : changed) yield_list(side).push_back(current_[var]);
    }
    return add_results(v, changed, first_index);
  }

  std::vector<Value> loop(Value v) {
    const RegionId body = kernel_.at(v).region[0];
    const std::vector<VarId>& changed = stored_[body];
    const size_t first_index = kernel_.lists[kernel_.at(v).list].size();
    std::vector<Value> args;
    for (VarId var : changed) {
      kernel_.lists[kernel_.at(v).list].push_back(value_of(var));
      current_[var] = add_inst(kernel_, {.op = Op::kLoopArg, .type = vars_[var], .imm = first_index + args.size()});
      args.push_back(current_[var]);
    }
    auto& insts = kernel_.regions[body].insts;
    insts.insert(insts.begin() + static_cast<ptrdiff_t>(first_index), args.begin(), args.end());
    region(body);
    for (VarId var : changed) yield_list(body).push_back(current_[var]);
    return add_results(v, changed, first_index);
  }

  ir::Kernel& kernel_;
  Aliases aliases_;
  std::vector<VarId> first_var_;            // by Local: variable of its element 0
  std::vector<ir::Type> vars_;              // type of each variable
  std::vector<std::vector<VarId>> stored_;  // by region
  std::vector<Value> current_;              // by variable; unset: still zero
  std::vector<Value> zeros_;
};

}  // namespace

void ssa(ir::Kernel& k) { Promoter(k).run(); }

}  // namespace pineda::passes
