#include "compiler/ir/wave_frame.h"

#include <algorithm>

#include "base/abi.h"
#include "compiler/ir/walk.h"

namespace pineda::ir {
namespace {

constexpr uint32_t kScalarBytes = 8;

class Planner {
 public:
  Planner(const Kernel& kernel, const std::vector<bool>& with_barriers)
      : kernel_(kernel), with_barriers_(with_barriers), phase_of_(kernel.insts.size()) {
    frame_.offset.assign(kernel.insts.size(), WaveFrame::kNone);
    frame_.masks.assign(kernel.insts.size(), WaveFrame::kNone);
  }

  WaveFrame run() {
    region(kernel_.wave);
    frame_.bytes = (frame_.bytes + WaveFrame::kAlignmentBytes - 1) / WaveFrame::kAlignmentBytes * WaveFrame::kAlignmentBytes;
    return std::move(frame_);
  }

 private:
  bool varies(Value v) const { return kernel_.at(v).rate > Rate::kPrim; }

  // A region that the workgroup runs.
  void region(RegionId id) {
    ++phase_;
    for (Value v : kernel_.regions[id].insts) {
      const Inst& inst = kernel_.at(v);
      if (inst.op == Op::kBarrier) {
        ++phase_;
      } else if (is_group_construct(inst, with_barriers_)) {
        construct(v);
      } else if (inst.op == Op::kLocal) {
        keep(v, inst.imm);
      } else if (inst.op == Op::kResult && is_group_construct(kernel_.at(inst.operand[0]), with_barriers_)) {
        if (varies(v)) keep_result(v);
      } else if (inst.op != Op::kLoopArg) {
        plain(v);
      }
    }
  }

  // Stands in a phase, with all that is inside of it.
  void plain(Value v) {
    const Inst& inst = kernel_.at(v);
    if (!varies(v) && inst.op != Op::kYield) return;
    phase_of_[v.id] = phase_;
    for_each_read(kernel_, v, [&](Value read) { use(read); });
    for (uint32_t r = 0; r < region_count(inst.op); ++r) {
      for_each_inst(kernel_, inst.region[r], [&](Value inner) { for_each_read(kernel_, inner, [&](Value read) { use(read); }); });
    }
  }

  void use(Value v) {
    if (phase_of_[v.id] == 0 || phase_of_[v.id] == phase_ || is_recomputed(kernel_.at(v).op)) return;
    if (frame_.offset[v.id] == WaveFrame::kNone) keep(v, 1);
  }

  // Its condition and initial values are read in the phase before it.
  void construct(Value v) {
    const Inst& inst = kernel_.at(v);
    for_each_operand(kernel_, v, [&](Value operand) { use(operand); });
    if (inst.rate > Rate::kPrim) frame_.masks[v.id] = reserve(2 * kScalarBytes, kScalarBytes);
    for (uint32_t r = 0; r < region_count(inst.op); ++r) {
      const auto& insts = kernel_.regions[inst.region[r]].insts;
      for (size_t i = 0; i < insts.size() && kernel_.at(insts[i]).op == Op::kLoopArg; ++i) {
        if (varies(insts[i])) keep_for_construct(insts[i]);
      }
      region(inst.region[r]);
    }
    ++phase_;
  }

  // After the last turn a Result is what its LoopArg would be in the next one.
  void keep_result(Value v) {
    const Inst& result = kernel_.at(v);
    const Inst& owner = kernel_.at(result.operand[0]);
    if (owner.op == Op::kLoop) {
      const Value arg = kernel_.regions[owner.region[0]].insts[result.imm];
      if (kernel_.at(arg).rate == result.rate) {
        phase_of_[v.id] = kConstruct;
        frame_.offset[v.id] = frame_.offset[arg.id];
        return;
      }
    }
    keep_for_construct(v);
  }

  void keep_for_construct(Value v) {
    phase_of_[v.id] = kConstruct;
    keep(v, 1);
  }

  void keep(Value v, uint64_t count) {
    const Inst& inst = kernel_.at(v);
    const bool lanes = inst.op == Op::kLocal || inst.rate == Rate::kLane;
    const bool mask = inst.type == Type::kB1 && inst.op != Op::kLocal;
    const uint64_t row = !lanes || mask ? kScalarBytes : uint64_t{kLanes} * (inst.type == Type::kB1 ? 4 : size_bytes(inst.type));
    frame_.offset[v.id] = reserve(row * count, std::min<uint64_t>(row, WaveFrame::kAlignmentBytes));
  }

  uint32_t reserve(uint64_t bytes, uint64_t alignment) {
    frame_.bytes = (frame_.bytes + alignment - 1) / alignment * alignment;
    const auto at = static_cast<uint32_t>(frame_.bytes);
    frame_.bytes += bytes;
    return at;
  }

  static constexpr uint32_t kConstruct = ~0u;  // "phase" of what a construct carries: never the current one

  const Kernel& kernel_;
  const std::vector<bool>& with_barriers_;
  std::vector<uint32_t> phase_of_;  // by value; 0: computed outside of the phases, or inside of one instruction
  uint32_t phase_ = 0;
  WaveFrame frame_;
};

}  // namespace

WaveFrame wave_frame(const Kernel& kernel) {
  const std::vector<bool> with_barriers = regions_with_barriers(kernel);
  if (kernel.wave == 0 || !with_barriers[kernel.wave]) return {};
  return Planner(kernel, with_barriers).run();
}

}  // namespace pineda::ir
