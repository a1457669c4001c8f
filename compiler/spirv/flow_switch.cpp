// OpSwitch: one If for each case, in an order in which every case comes behind those that fall through into it.
#include <algorithm>
#include <set>

#include "compiler/spirv/flow.h"

namespace pineda::spirv {

std::vector<uint32_t> Flow::successors(const Block& from) const {
  const Instruction& inst = end_of(from);
  std::vector<uint32_t> out;
  if (inst.op() == spv::OpBranch) out.push_back(inst.word(1));
  if (inst.op() == spv::OpBranchConditional) out = {inst.word(2), inst.word(3)};
  if (inst.op() == spv::OpSwitch) {
    out.push_back(inst.word(2));
    for (const SwitchCase& c : switch_cases(t_.m, inst)) out.push_back(c.label);
  }
  return out;
}

// The distinct blocks that the switch goes to, without its merge block, default first.
std::vector<Flow::Case> Flow::cases(const Instruction& inst, uint32_t merge) const {
  std::vector<Case> out;
  std::unordered_map<uint32_t, size_t> index;
  const auto add = [&](uint32_t label) -> Case* {
    if (label == merge) return nullptr;
    const auto [found, is_new] = index.emplace(label, out.size());
    if (is_new) out.push_back({.block = label});
    return &out[found->second];
  };
  if (Case* c = add(inst.word(2))) c->is_default = true;
  for (const SwitchCase& s : switch_cases(t_.m, inst)) {
    if (Case* c = add(s.label)) c->literals.push_back(s.literal);
  }
  return out;
}

// Each block of a structured switch belongs to one case, so one walk over all of them finds who falls into whom.
std::vector<Flow::Case> Flow::in_fall_through_order(const Instruction& inst, const std::vector<Case>& cases,
                                                    uint32_t merge) const {
  std::unordered_map<uint32_t, size_t> case_of;
  for (size_t i = 0; i < cases.size(); ++i) case_of.emplace(cases[i].block, i);
  std::vector<std::vector<size_t>> falls_into(cases.size());
  std::vector<uint32_t> waits_for(cases.size(), 0);
  std::unordered_map<uint32_t, size_t> owner;
  for (size_t i = 0; i < cases.size(); ++i) {
    if (is_target(cases[i].block)) continue;  // leaves the switch at once
    std::vector<uint32_t> pending{cases[i].block};
    while (!pending.empty()) {
      const uint32_t label = pending.back();
      pending.pop_back();
      const auto other = case_of.find(label);
      if (other != case_of.end() && other->second != i) {
        falls_into[i].push_back(other->second);
        ++waits_for[other->second];
        continue;
      }
      if (label == merge || is_target(label)) continue;
      const auto [found, is_new] = owner.emplace(label, i);
      if (!is_new && found->second != i)
        inst.fail("control flow is not structured: two cases share block %" + std::to_string(label));
      if (!is_new) continue;
      for (uint32_t next : successors(block(inst, label))) pending.push_back(next);
    }
  }
  std::set<size_t> ready;
  for (size_t i = 0; i < cases.size(); ++i) {
    if (waits_for[i] == 0) ready.insert(i);
  }
  std::vector<Case> out;
  while (!ready.empty()) {
    const size_t i = *ready.begin();
    ready.erase(ready.begin());
    out.push_back(cases[i]);
    for (size_t j : falls_into[i]) {
      if (--waits_for[j] == 0) ready.insert(j);
    }
  }
  if (out.size() != cases.size()) inst.fail("control flow is not structured: cases fall through in a circle");
  return out;
}

// B1: the selector chooses this case.
ir::Value Flow::matches(const Instruction& inst, ir::Value selector, const Case& c) {
  ir::Value any;
  const auto add = [&](uint64_t literal) {
    const ir::Value equal = t_.b.ieq(selector, t_.b.constant(t_.b.type(selector), literal));
    any = any ? t_.b.or_(any, equal) : equal;
  };
  if (!c.is_default) {
    for (uint64_t literal : c.literals) add(literal);
    return any;
  }
  for (const SwitchCase& s : switch_cases(t_.m, inst)) {
    if (s.label != c.block) add(s.literal);
  }
  return any ? t_.b.not_(any) : t_.b.b1(true);
}

bool Flow::switch_(const Block& current) {
  const Instruction& inst = end_of(current);
  if (current.merge_kind != MergeKind::kSelection) inst.fail("has no OpSelectionMerge");
  const Values selectors = t_.integers(inst, 1);
  if (selectors.size() != 1) inst.fail("the selector is not a scalar");
  const ir::Value selector = selectors[0];
  std::vector<uint32_t> all = successors(current);
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  for (uint32_t to : all) edge(current, to);  // a lane that takes another way sets its phis again
  const uint32_t merge = current.merge;
  const std::vector<Case> order = in_fall_through_order(inst, cases(inst, merge), merge);

  const size_t mark = jumps_.size(), first_target = targets_.size();
  bool arrives = std::ranges::find(all, merge) != all.end();
  std::vector<size_t> target_of(order.size(), 0);  // 0: the case leaves the switch at once
  std::vector<bool> leaves;
  for (const Case& c : order) leaves.push_back(is_target(c.block));
  push_target(inst, merge);
  for (size_t i = 0; i < order.size(); ++i) {
    if (leaves[i]) continue;
    target_of[i] = targets_.size();
    push_target(inst, order[i].block);
  }
  for (size_t i = 0; i < order.size(); ++i) {
    ir::Value cond = matches(inst, selector, order[i]);
    if (!leaves[i] && std::ranges::find(jumps_, target_of[i]) != jumps_.end()) {
      cond = t_.b.or_(cond, t_.b.get(targets_[target_of[i]].left));
    }
    if (!leaves[i]) targets_[target_of[i]].closed = true;
    const auto body = [&] { arrives |= leaves[i] ? go_on(inst, order[i].block, merge) : sequence(order[i].block, merge); };
    t_.in_if(inst, cond, body, [] {});
  }
  arrives |= jumped_to(merge, mark);
  pop_targets(targets_.size() - first_target, mark);
  return arrives;
}

}  // namespace pineda::spirv
