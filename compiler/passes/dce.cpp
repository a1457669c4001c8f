// Mark from the effects backwards, then sweep. Results, yields and carried values are marked one by one, so an If or a loop loses
// the values that nobody reads, also those that only feed themselves.
#include <utility>

#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Value;

class Eliminator {
 public:
  explicit Eliminator(ir::Kernel& kernel)
      : kernel_(kernel), live_(kernel.insts.size()), owner_(kernel.insts.size()), side_(kernel.insts.size()) {}

  void run() {
    for (RegionId root : roots()) survey(root, {});
    while (!work_.empty()) {
      const Value v = work_.back();
      work_.pop_back();
      visit(v);
    }
    for (auto& uses : used_) {  // from "is read" to "how many before it are read, itself included"
      uint32_t count = 0;
      for (uint32_t& use : uses) use = count += use;
    }
    for (RegionId root : roots()) sweep(root);
  }

 private:
  std::vector<RegionId> roots() const {
    std::vector<RegionId> out;
    for (RegionId root : {kernel_.draw, kernel_.prim, kernel_.wave}) {
      if (root != 0) out.push_back(root);
    }
    return out;
  }

  void mark(Value v) {
    if (live_[v.id]) return;
    live_[v.id] = true;
    work_.push_back(v);
  }

  // Finds owners and the instructions that must stay. A store to a Local stays only when that Local is read.
  void survey(RegionId id, Value owner) {
    for (Value v : kernel_.regions[id].insts) {
      const Inst& inst = kernel_.at(v);
      owner_[v.id] = owner;
      if (inst.op == Op::kLocalStore) {
        stores_[side_[inst.operand[0].id]].push_back(v);
      } else if (writes(inst)) {
        mark(v);
      }
      if (inst.op == Op::kLocal) {
        side_[v.id] = static_cast<uint32_t>(stores_.size());
        stores_.emplace_back();
      } else if (ir::has_regions(inst.op)) {
        side_[v.id] = static_cast<uint32_t>(used_.size());
        used_.emplace_back(ir::yielded(kernel_, inst.region[0]).size() - is_loop(inst));
      }
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) survey(inst.region[r], v);
    }
  }

  static size_t is_loop(const Inst& inst) { return inst.op == Op::kLoop ? 1 : 0; }

  void visit(Value v) {
    const Inst& inst = kernel_.at(v);
    if (owner_[v.id]) mark(owner_[v.id]);
    for (Value operand : inst.operand) {
      if (operand) mark(operand);
    }
    switch (inst.op) {
      case Op::kLocal:
        for (Value store : stores_[side_[v.id]]) mark(store);
        return;
      case Op::kLoop:
        mark(ir::yielded(kernel_, inst.region[0])[0]);
        return;
      case Op::kResult:
        use(inst.operand[0], inst.imm);
        return;
      case Op::kLoopArg:
        use(owner_[v.id], inst.imm);
        return;
      default:
        return;
    }
  }

  // Value k of an If or Loop is read.
  void use(Value owner, uint64_t k) {
    if (used_[side_[owner.id]][k] != 0) return;
    used_[side_[owner.id]][k] = 1;
    const Inst& inst = kernel_.at(owner);
    for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) mark(ir::yielded(kernel_, inst.region[r])[k + is_loop(inst)]);
    if (inst.op != Op::kLoop) return;
    mark(kernel_.lists[inst.list][k]);
    mark(kernel_.regions[inst.region[0]].insts[k]);  // the LoopArg: verify() wants all of them
  }

  void sweep(RegionId id) {
    auto& insts = kernel_.regions[id].insts;
    size_t kept = 0;
    for (Value v : insts) {
      Inst& inst = kernel_.at(v);
      if (!live_[v.id] && inst.op != Op::kYield) continue;
      insts[kept++] = v;
      if (inst.op == Op::kResult) inst.imm = new_index(inst.operand[0], inst.imm);
      if (inst.op == Op::kLoopArg) inst.imm = new_index(owner_[v.id], inst.imm);
    }
    insts.resize(kept);
    for (Value v : insts) {
      const Inst& inst = kernel_.at(v);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) {
        filter(kernel_.lists[kernel_.at(ir::yield_of(kernel_, inst.region[r])).list], v, is_loop(inst));
        sweep(inst.region[r]);
      }
      if (inst.op == Op::kLoop) filter(kernel_.lists[inst.list], v, 0);
    }
  }

  // After run() has summed: a live value's new index, and whether a value is live.
  uint64_t new_index(Value owner, uint64_t k) const { return used_[side_[owner.id]][k] - 1; }
  bool is_used(Value owner, size_t k) const { return used_[side_[owner.id]][k] != (k == 0 ? 0 : used_[side_[owner.id]][k - 1]); }

  // Drops the unused values; `skip` leading ones are not counted (a loop's `again`).
  void filter(std::vector<Value>& list, Value owner, size_t skip) const {
    size_t kept = skip;
    for (size_t i = skip; i < list.size(); ++i) {
      if (is_used(owner, i - skip)) list[kept++] = list[i];
    }
    list.resize(kept);
  }

  ir::Kernel& kernel_;
  std::vector<bool> live_;
  std::vector<Value> owner_;    // by instruction: the If or Loop whose region it stands in
  std::vector<uint32_t> side_;  // by Local: index in stores_; by If or Loop: index in used_
  std::vector<std::vector<Value>> stores_;
  std::vector<std::vector<uint32_t>> used_;  // by value of an If or Loop: whether it is read; later the running sum
  std::vector<Value> work_;
};

}  // namespace

void dce(ir::Kernel& k) { Eliminator(k).run(); }

}  // namespace pineda::passes
