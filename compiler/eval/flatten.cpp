#include <string>
#include <unordered_map>

#include "base/log.h"
#include "compiler/eval/code.h"
#include "compiler/ir/walk.h"

namespace pineda::eval {
namespace {

using ir::Op;

class Flattener {
 public:
  Flattener(const ir::Kernel& kernel, Mode mode)
      : kernel_(kernel),
        with_barriers_(ir::regions_with_barriers(kernel)),
        slots_(kernel.insts.size()),
        results_(kernel.insts.size()) {
    code_.has_barriers = with_barriers_[kernel.wave];
    code_.floats = mode == Mode::kF32 ? ir::Floats::kNative : ir::Floats::kDouble;
    code_.wave_stride_bytes = kernel.wave_stride_bytes;
  }

  Code run() {
    for (ir::RegionId root : {kernel_.draw, kernel_.prim, kernel_.wave}) {
      if (root != 0) assign_slots(root);
    }
    code_.locals_begin = code_.value_count;
    for (ir::Value v : kernel_.regions[kernel_.wave].insts) {
      const ir::Inst& inst = kernel_.at(v);
      if (inst.op != Op::kLocal) break;
      slots_[v.id] = static_cast<Slot>(code_.value_count);
      code_.value_count += inst.imm * kLanes;
    }
    if (kernel_.draw != 0) code_.draw = block(kernel_.draw);
    if (kernel_.prim != 0) code_.prim = block(kernel_.prim);
    code_.wave = block(kernel_.wave);
    return std::move(code_);
  }

 private:
  Slot new_slot() {
    const auto slot = static_cast<Slot>(code_.value_count);
    code_.value_count += kLanes;
    return slot;
  }

  void assign_slots(ir::RegionId root) {
    ir::for_each_inst(kernel_, root, [&](ir::Value v) {
      const ir::Inst& inst = kernel_.at(v);
      if (ir::has_regions(inst.op)) {  // Results of one index share a slot
        const size_t skip = inst.op == Op::kLoop ? 1 : 0;
        const size_t count = ir::yielded(kernel_, inst.region[0]).size() - skip;
        for (size_t k = 0; k < count; ++k) results_[v.id].push_back(new_slot());
      }
      if (inst.op == Op::kResult) {
        slots_[v.id] = results_[inst.operand[0].id][inst.imm];
      } else if (inst.type != ir::Type::kVoid && inst.op != Op::kLocal) {
        slots_[v.id] = new_slot();
      }
    });
  }

  Slot slot(ir::Value v) const { return slots_[v.id]; }

  uint32_t block(ir::RegionId region) {
    Block out;
    for (ir::Value v : kernel_.regions[region].insts) step(v, out);
    code_.blocks.push_back(std::move(out));
    return static_cast<uint32_t>(code_.blocks.size() - 1);
  }

  void step(ir::Value v, Block& out) {
    const ir::Inst& inst = kernel_.at(v);
    switch (inst.op) {
      case Op::kConst:
        code_.constants.push_back({slot(v), ir::const_raw(inst.type, inst.imm, code_.floats)});
        return;
      case Op::kLocal:
      case Op::kLoopArg:
      case Op::kYield:
      case Op::kResult:
        return;  // their owner moves the values
      case Op::kIf:
      case Op::kLoop:
        out.steps.push_back(control(v));
        return;
      default:
        out.steps.push_back(plain(v));
        return;
    }
  }

  Step plain(ir::Value v) {
    const ir::Inst& inst = kernel_.at(v);
    Step step{.op = inst.op, .type = inst.type, .flags = inst.flags, .out = slot(v), .imm = inst.imm};
    for (uint32_t i = 0; i < ir::kMaxOperands; ++i) step.in[i] = inst.operand[i] ? slot(inst.operand[i]) : 0;
    if (inst.op == Op::kStore) step.type = kernel_.at(inst.operand[2]).type;
    if (inst.op == Op::kLocalLoad || inst.op == Op::kLocalStore) step.imm = kernel_.at(inst.operand[0]).imm;
    if (inst.op == Op::kReduce) {
      step.identity = ir::const_raw(inst.type, ir::reduce_identity(inst.reduce_op(), inst.type, false), code_.floats);
      step.first = ir::const_raw(inst.type, ir::reduce_identity(inst.reduce_op(), inst.type, true), code_.floats);
      step.combine = ir::lane_fn(ir::combining_op(inst.reduce_op()), inst.type, inst.type, code_.floats);
    }
    const ir::OpInfo& info = ir::op_info(inst.op);
    if (info.effect == ir::Effect::kPure && info.operands > 0 && inst.op != Op::kQuadSwizzle) {
      const ir::Value typed = inst.operand[inst.op == Op::kSelect ? 1 : 0];
      step.fn = ir::lane_fn(inst.op, inst.type, kernel_.at(typed).type, code_.floats);
      if (step.fn == nullptr) {  // a transcendental that nobody lowered
        report(Severity::kError, std::string("eval: ") + info.name + " has no f32 definition; the kernel was not lowered");
        step.fn = [](uint64_t* to, const uint64_t*, const uint64_t*, const uint64_t*) { std::fill_n(to, kLanes, 0x7FC00000); };
      }
    }
    return step;
  }

  Step control(ir::Value v) {
    const ir::Inst& inst = kernel_.at(v);
    Step step{.op = inst.op, .in = {slot(inst.operand[0])}, .for_group = ir::is_group_construct(inst, with_barriers_)};
    const auto& results = results_[v.id];
    for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) {
      step.block[r] = block(inst.region[r]);
      Block& body = code_.blocks[step.block[r]];
      const auto& values = ir::yielded(kernel_, inst.region[r]);
      const size_t skip = inst.op == Op::kLoop ? 1 : 0;
      for (size_t k = 0; k < results.size(); ++k) body.yields.push_back({slot(values[k + skip]), results[k]});
      if (inst.op == Op::kIf) continue;
      body.again = slot(values[0]);
      const auto& body_insts = kernel_.regions[inst.region[0]].insts;
      const auto& init = kernel_.lists[inst.list];
      for (size_t k = 0; k < results.size(); ++k) {
        body.carried.push_back({results[k], slot(body_insts[k])});
        body.initial.push_back({slot(init[k]), slot(body_insts[k])});
      }
    }
    return step;
  }

  const ir::Kernel& kernel_;
  const std::vector<bool> with_barriers_;  // by region
  Code code_;
  std::vector<Slot> slots_;                 // by value
  std::vector<std::vector<Slot>> results_;  // by If or Loop: slot of each result
};

}  // namespace

Code flatten(const ir::Kernel& kernel, Mode mode) { return Flattener(kernel, mode).run(); }

}  // namespace pineda::eval
