// SPIR-V's structured control flow (specification 2.11) -> If and Loop.
//
// A sequence of blocks is emitted from its first block up to a `stop` block (the merge block of the construct around it).
// Branching to stop ends the sequence. Branching anywhere else that encloses it (the merge or continue target of a loop, the
// merge of a switch, the next case, the function's end) is a jump: the lane sets that target's flag and the sequence ends.
// Whatever follows an inner construct inside an outer one runs under "no flag that was set in there", and a loop goes on for the
// lanes that reached its back edge. Code behind a construct whose first side never comes back is emitted inside the other side,
// so `if (x) return; rest` needs no flag. That nests by one level for each construct that lanes leave; where it is deep already
// (kNestedDepth), such code stands side by side instead, each piece under an If of its own: `later` below.
//
//     loop header H, merge M, continue C            IR
//     H: phis, code                                 Loop { again = false
//        if (c) B else M                              H; If c { B; ... C ...; again = true } else { broken = true }
//     B: ...  branch C                                Yield again }
//     C: i++  branch H                              (M follows)
//
// OpKill and OpTerminateInvocation let the lane run on as a helper invocation, so that derivatives stay defined and no guards are
// needed: its writes are suppressed (Translator::effect). Since a discard may be what keeps a lane out of an endless loop, a loop
// also ends when no lane that is not discarded goes on. A live lane's quad is in its wave, so its neighbours stay with it for
// as long as it can ask them for a derivative; and the condition is the wave's, so a uniform loop stays uniform.
#pragma once

#include "compiler/spirv/translator.h"

namespace pineda::spirv {

class Flow {
 public:
  Flow(Translator& t, const Function& function) : t_(t), f_(function), emitted_(function.blocks.size()) {}
  void run();

 private:
  struct Target {
    uint32_t block = 0;   // label; 0 = the function's end
    ir::Var left;         // B1: the lane is on its way there
    bool closed = false;  // behind us: cannot be jumped to any more
  };
  struct Case {
    uint32_t block;
    std::vector<uint64_t> literals;
    bool is_default = false;
  };
  static constexpr uint32_t kReturn = 0;
  static constexpr size_t kNestedDepth = 16;

  // Where a sequence goes on when one of its blocks has been emitted.
  struct Next {
    std::optional<uint32_t> here;    // in the same region
    std::optional<uint32_t>* later;  // for lanes that have not left, when this region is closed; null: the caller cannot do that
  };

  // All of these give whether `stop` can be reached.
  bool sequence(uint32_t label, uint32_t stop, bool inside_loop = false, std::optional<uint32_t>* later = nullptr);
  bool go(const Block& from, uint32_t to, uint32_t stop);  // takes an edge: phis, then go_on
  bool go_on(const Instruction& at, uint32_t to, uint32_t stop, std::optional<uint32_t>* later = nullptr);
  bool guarded(const Instruction& at, uint32_t merge, uint32_t stop, size_t mark);  // behind a construct: under its guards
  bool behind(const Instruction& at, uint32_t merge, uint32_t stop, size_t mark, Next& next);
  bool terminator(const Block& block, uint32_t stop, Next& next);
  bool conditional(const Block& block, uint32_t stop, const Next& next);
  bool leave_flat(const Block& block, uint32_t stop, const Next& next);
  bool selection(const Block& block, uint32_t stop, Next& next);
  bool is_deep(const Next& next) const { return next.later && t_.nesting() > kNestedDepth; }
  bool loop(const Block& header);       // whether its merge block can be reached
  bool loop_body(const Block& header);  // whether its back edge can be reached
  bool switch_(const Block& block);     // whether its merge block can be reached
  std::vector<Case> cases(const Instruction& inst, uint32_t merge) const;
  std::vector<Case> in_fall_through_order(const Instruction& inst, const std::vector<Case>& cases, uint32_t merge) const;
  std::vector<uint32_t> successors(const Block& block) const;
  ir::Value matches(const Instruction& inst, ir::Value selector, const Case& c);

  const Block& block(const Instruction& at, uint32_t label) const;
  const Instruction& end_of(const Block& block) const { return t_.m.instructions[block.terminator]; }
  void enter(const Block& block);
  uint32_t for_each_phi(const Block& block, const std::function<void(const Instruction&)>& fn) const;
  void edge(const Block& from, uint32_t to);
  bool jump(const Instruction& at, uint32_t to);
  void push_target(const Instruction& at, uint32_t label);
  bool is_target(uint32_t label) const;
  void pop_targets(size_t count, size_t mark);
  bool jumped_to(uint32_t label, size_t mark) const;
  ir::Value guard(size_t mark);  // B1: no flag since `mark` is set; unset when none can be

  Translator& t_;
  const Function& f_;
  std::vector<bool> emitted_;
  std::vector<Target> targets_;  // innermost last
  std::vector<uint32_t> jumps_;  // indices in targets_ of the jumps emitted so far that are still to arrive
  uint32_t depth_ = 0;
};

}  // namespace pineda::spirv
