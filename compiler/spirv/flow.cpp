#include "compiler/spirv/flow.h"

#include <algorithm>

namespace pineda::spirv {

void Flow::run() {
  const Instruction& at = t_.m.instructions[f_.first];
  if (f_.blocks.empty()) at.fail("the function has no body");
  if (f_.returns_early) push_target(at, kReturn);
  sequence(f_.blocks[0].label, kReturn);
}

// ---- blocks and edges -----------------------------------------------------------------------------------------------------

const Block& Flow::block(const Instruction& at, uint32_t label) const {
  const auto found = f_.block_index.find(label);
  if (found == f_.block_index.end()) at.fail("%" + std::to_string(label) + " is not a block of this function");
  return f_.blocks[found->second];
}

// Phis and instructions of a block, without its terminator.
void Flow::enter(const Block& block) {
  const size_t index = &block - f_.blocks.data();
  if (emitted_[index]) {
    end_of(block).fail("control flow is not structured: block %" + std::to_string(block.label) +
                       " is reached from two constructs");
  }
  emitted_[index] = true;
  const uint32_t body = for_each_phi(block, [this](const Instruction& phi) {
    const std::vector<ir::Type> types = t_.m.flat_scalars(phi.word(1));
    Values values;
    for (uint32_t k = 0; k < types.size(); ++k) values.push_back(t_.b.get(t_.phi_var(phi, k, types[k])));
    t_.define(phi, std::move(values));
  });
  for (uint32_t i = body; i < block.terminator; ++i) t_.instruction(t_.m.instructions[i]);
}

// Calls fn for the phis at a block's head (debug lines may stand between them); gives the index of the instruction behind them.
uint32_t Flow::for_each_phi(const Block& block, const std::function<void(const Instruction&)>& fn) const {
  for (uint32_t i = block.first; i < block.terminator; ++i) {
    const Instruction& inst = t_.m.instructions[i];
    if (inst.op() == spv::OpPhi)
      fn(inst);
    else if (inst.op() != spv::OpLine && inst.op() != spv::OpNoLine)
      return i;
  }
  return block.terminator;
}

// Sets the phi variables of the block behind an edge. All are read before any is set: phis of one block are assigned at once.
void Flow::edge(const Block& from, uint32_t to) {
  std::vector<std::pair<const Instruction*, Values>> assigned;
  for_each_phi(block(end_of(from), to), [&](const Instruction& phi) {
    for (uint32_t pair = 3; pair < phi.size(); pair += 2) {
      if (phi.word(pair + 1) != from.label) continue;
      assigned.emplace_back(&phi, t_.values(phi, pair));
      break;
    }
  });
  for (auto& [phi, values] : assigned) {
    const std::vector<ir::Type> types = t_.m.flat_scalars(phi->word(1));
    if (types.size() != values.size()) phi->fail("an operand does not have the result's type");
    for (uint32_t k = 0; k < types.size(); ++k) {
      if (t_.b.type(values[k]) != types[k]) phi->fail("an operand does not have the result's type");
      t_.b.set(t_.phi_var(*phi, k, types[k]), values[k]);
    }
  }
}

// ---- jumps ----------------------------------------------------------------------------------------------------------------

void Flow::push_target(const Instruction& at, uint32_t label) {
  const Target target{.block = label, .left = t_.variable(at, ir::Type::kB1)};
  t_.b.set(target.left, t_.b.b1(false));
  targets_.push_back(target);
}

void Flow::pop_targets(size_t count, size_t mark) {
  targets_.resize(targets_.size() - count);
  const auto arrived = [&](uint32_t index) { return index >= targets_.size(); };
  jumps_.erase(std::remove_if(jumps_.begin() + mark, jumps_.end(), arrived), jumps_.end());
}

bool Flow::jump(const Instruction& at, uint32_t to) {
  for (size_t i = targets_.size(); i-- > 0;) {
    if (targets_[i].block != to) continue;
    if (targets_[i].closed) at.fail("control flow is not structured: %" + std::to_string(to) + " is jumped back to");
    t_.b.set(targets_[i].left, t_.b.b1(true));
    jumps_.push_back(static_cast<uint32_t>(i));
    return true;
  }
  return false;
}

bool Flow::jumped_to(uint32_t label, size_t mark) const {
  return std::any_of(jumps_.begin() + mark, jumps_.end(), [&](uint32_t i) { return targets_[i].block == label; });
}

ir::Value Flow::guard(size_t mark) {
  std::vector<uint32_t> distinct(jumps_.begin() + mark, jumps_.end());
  std::ranges::sort(distinct);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  jumps_.resize(mark);
  jumps_.insert(jumps_.end(), distinct.begin(), distinct.end());  // keeps the list short
  ir::Value left;
  for (uint32_t i : distinct) {
    const ir::Value flag = t_.b.get(targets_[i].left);
    left = left ? t_.b.or_(left, flag) : flag;
  }
  return left ? t_.b.not_(left) : ir::Value{};
}

// ---- sequences ------------------------------------------------------------------------------------------------------------

bool Flow::sequence(uint32_t label, uint32_t stop, bool inside_loop, std::optional<uint32_t>* later) {
  const Instruction* at = &t_.m.instructions[f_.first];
  if (++depth_ > 2 * kMaxNesting) at->fail("control flow is nested too deeply");
  bool reached = false;
  for (Next next{label, later}; next.here;) {
    const Block& current = block(*at, *next.here);
    at = &end_of(current);
    next.here.reset();
    if (current.merge_kind == MergeKind::kLoop && !inside_loop) {
      const size_t mark = jumps_.size();
      reached = loop(current) && behind(*at, current.merge, stop, mark, next);
    } else {
      enter(current);
      reached = terminator(current, stop, next);
    }
    inside_loop = false;
  }
  --depth_;
  return reached;
}

bool Flow::go_on(const Instruction& at, uint32_t to, uint32_t stop, std::optional<uint32_t>* later) {
  if (to == stop) return true;
  if (jump(at, to)) return false;
  return sequence(to, stop, false, later);
}

bool Flow::go(const Block& from, uint32_t to, uint32_t stop) {
  edge(from, to);
  return go_on(end_of(from), to, stop);
}

bool Flow::guarded(const Instruction& at, uint32_t merge, uint32_t stop, size_t mark) {
  bool reached = false;
  for (std::optional<uint32_t> next = merge; next;) {
    const uint32_t label = *next;
    next.reset();
    const ir::Value cond = guard(mark);  // more flags each time round
    if (!cond) {
      reached |= go_on(at, label, stop, &next);
      continue;
    }
    t_.in_if(
        at, cond, [&] { reached |= go_on(at, label, stop, &next); }, [] {});
  }
  return reached;
}

// Goes on at a construct's merge block: under a guard when lanes jumped out of the construct, in the same region otherwise.
bool Flow::behind(const Instruction& at, uint32_t merge, uint32_t stop, size_t mark, Next& next) {
  if (merge == stop) return true;
  if (jumps_.size() == mark) {
    if (!jump(at, merge)) next.here = merge;
    return false;
  }
  if (!is_deep(next)) return guarded(at, merge, stop, mark);
  if (!jump(at, merge)) *next.later = merge;
  return false;
}

// Emits what follows a block's body. `next` is set when the sequence goes on there, without nesting.
bool Flow::terminator(const Block& current, uint32_t stop, Next& next) {
  const Instruction& inst = end_of(current);
  switch (inst.op()) {
    case spv::OpBranch: {
      const uint32_t to = inst.word(1);
      edge(current, to);
      if (to == stop) return true;
      if (!jump(inst, to)) next.here = to;
      return false;
    }
    case spv::OpBranchConditional:
      return current.merge_kind == MergeKind::kSelection ? selection(current, stop, next) : conditional(current, stop, next);
    case spv::OpSwitch: {
      const size_t mark = jumps_.size();
      return switch_(current) && behind(inst, current.merge, stop, mark, next);
    }
    case spv::OpReturnValue:
      t_.set_return(inst);
      [[fallthrough]];
    case spv::OpReturn:
      if (stop == kReturn) return true;
      if (!jump(inst, kReturn)) inst.fail("control flow is not structured");
      return false;
    case spv::OpKill:
    case spv::OpTerminateInvocation:
      if (!t_.is_fragment()) inst.fail("stands outside a fragment shader");
      t_.discard();
      return true;
    default:
      return false;  // OpUnreachable
  }
}

// A conditional branch without merge instruction: at most one side goes on, the other leaves.
bool Flow::conditional(const Block& current, uint32_t stop, const Next& next) {
  const Instruction& inst = end_of(current);
  if (inst.word(2) == inst.word(3)) return go(current, inst.word(2), stop);
  if (is_deep(next) && (is_target(inst.word(2)) || is_target(inst.word(3)))) return leave_flat(current, stop, next);
  bool reached = false;
  const ir::Value cond = t_.scalar(inst, 1, ir::Type::kB1);
  t_.in_if(
      inst, cond, [&] { reached |= go(current, inst.word(2), stop); }, [&] { reached |= go(current, inst.word(3), stop); });
  return reached;
}

// The same where one side is a jump: those lanes set their flag, the others go on later.
bool Flow::leave_flat(const Block& current, uint32_t stop, const Next& next) {
  const Instruction& inst = end_of(current);
  const bool then_leaves = is_target(inst.word(2));
  const uint32_t target = inst.word(then_leaves ? 2 : 3), other = inst.word(then_leaves ? 3 : 2);
  const auto leave = [&] {
    edge(current, target);
    jump(inst, target);
  };
  const auto stay = [&] {
    edge(current, other);
    if (other != stop && !jump(inst, other)) *next.later = other;
  };
  const ir::Value cond = t_.scalar(inst, 1, ir::Type::kB1);
  if (then_leaves)
    t_.in_if(inst, cond, leave, stay);
  else
    t_.in_if(inst, cond, stay, leave);
  return other == stop;
}

bool Flow::selection(const Block& current, uint32_t stop, Next& next) {
  const Instruction& inst = end_of(current);
  const uint32_t merge = current.merge;
  const size_t mark = jumps_.size();
  bool then_arrives = false, else_arrives = false, nested = false, reached = false;
  const ir::Value cond = t_.scalar(inst, 1, ir::Type::kB1);
  t_.in_if(
      inst, cond, [&] { then_arrives = go(current, inst.word(2), merge); },
      [&] {
        const size_t else_mark = jumps_.size();
        else_arrives = go(current, inst.word(3), merge);
        if (!else_arrives || then_arrives || is_deep(next)) return;
        nested = true;
        reached = merge == stop || guarded(inst, merge, stop, else_mark);
      });
  if (nested) return reached;
  return (then_arrives || else_arrives) && behind(inst, merge, stop, mark, next);
}

// ---- loops ----------------------------------------------------------------------------------------------------------------

bool Flow::loop(const Block& header) {
  const Instruction& at = end_of(header);
  if (header.merge == header.label || header.merge == header.continue_target) at.fail("the loop's merge block is impossible");
  const size_t mark = jumps_.size();
  push_target(at, header.merge);
  t_.in_loop(at, [&] {
    if (!loop_body(header)) return t_.b.b1(false);
    ir::Value again = guard(mark);
    if (!again) again = t_.b.b1(true);
    if (!t_.killed().local) return again;
    const ir::Value live = t_.b.and_(again, t_.b.not_(t_.b.get(t_.killed())));
    return t_.b.and_(again, t_.b.ine(t_.b.ballot(live), t_.b.i32(0)));
  });
  const bool leaves = jumped_to(header.merge, mark);
  pop_targets(1, mark);
  return leaves;
}

// One iteration. A continue target with one predecessor is an ordinary block of the body; otherwise the continue construct
// follows the body, under the guard of what left the loop.
bool Flow::loop_body(const Block& header) {
  const Instruction& at = end_of(header);
  const uint32_t continue_target = header.continue_target;
  const bool inline_continue = continue_target == header.label || block(at, continue_target).predecessors == 1;
  const uint32_t stop = inline_continue ? header.label : continue_target;
  const size_t mark = jumps_.size();
  push_target(at, stop);
  bool arrives = sequence(header.label, stop, true);
  arrives |= jumped_to(stop, mark);
  pop_targets(1, mark);
  if (inline_continue || !arrives) return arrives;
  return guarded(at, continue_target, header.label, mark);
}

bool Flow::is_target(uint32_t label) const {
  return std::ranges::any_of(targets_, [&](const Target& t) { return t.block == label; });
}

}  // namespace pineda::spirv
