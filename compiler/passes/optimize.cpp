#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

class Compactor {
 public:
  explicit Compactor(ir::Kernel& kernel) : old_(kernel), renumbered_(old_.insts.size()) {
    kernel.insts.resize(1);
    kernel.regions.resize(1);
    kernel.lists.resize(1);
    for (ir::RegionId* root : {&kernel.draw, &kernel.prim, &kernel.wave}) {
      if (*root != 0) *root = region(kernel, *root);
    }
  }

 private:
  ir::RegionId region(ir::Kernel& to, ir::RegionId id) {
    const auto copy = static_cast<ir::RegionId>(to.regions.size());
    to.regions.emplace_back();
    std::vector<ir::Value> insts;
    insts.reserve(old_.regions[id].insts.size());
    for (ir::Value v : old_.regions[id].insts) insts.push_back(inst(to, v));
    to.regions[copy].insts = std::move(insts);
    return copy;
  }

  ir::Value inst(ir::Kernel& to, ir::Value v) {
    const ir::Value copy = add_inst(to, old_.at(v));
    renumbered_[v.id] = copy;
    if (ir::has_list(to.at(copy).op)) {
      to.lists.push_back(old_.lists[to.at(copy).list]);
      to.at(copy).list = static_cast<uint32_t>(to.lists.size() - 1);
    }
    ir::for_each_operand(to, copy, [&](ir::Value& operand) { operand = renumbered_[operand.id]; });
    for (uint32_t r = 0; r < ir::region_count(old_.at(v).op); ++r) {
      const ir::RegionId inner = region(to, old_.at(v).region[r]);
      to.at(copy).region[r] = inner;
    }
    return copy;
  }

  const ir::Kernel old_;
  std::vector<ir::Value> renumbered_;
};

bool has_locals(const ir::Kernel& k) {
  const auto& wave = k.regions[k.wave].insts;
  return !wave.empty() && k.at(wave.front()).op == ir::Op::kLocal;
}

}  // namespace

void compact(ir::Kernel& kernel) { Compactor compactor(kernel); }

void optimize(ir::Kernel& k, Form form, Precision precision) {
  ssa(k);
  dce(k);
  if (form == Form::kMachine) fuse_fma(k);  // before fold: see fuse_fma.cpp
  fold(k, form);
  if (has_locals(k)) {  // arrays whose indices fold has just made constant
    ssa(k);
    fold(k, form);
  }
  cse(k);
  dce(k);
  while (form == Form::kMachine && unroll(k)) {  // a loop around others when they are gone
    fold(k, form);
    cse(k);
    dce(k);
  }
  rates(k);
  flatten_ifs(k);
  narrow_loops(k);
  if (form == Form::kMachine) {
    lower_math(k, precision);
    fuse_fma(k);
  }
  fold(k, form);
  cse(k);
  dce(k);
  rates(k);
  hoist(k);
  hoist_loops(k);
  if (consecutive_accesses(k)) {  // behind them: nothing moves out of its branches, but what it compares with may
    dce(k);
    hoist(k);
    hoist_loops(k);
  }
  cse(k);  // equal values that stood in different regions may now meet
  dce(k);
  rates(k);
  compact(k);
}

}  // namespace pineda::passes
