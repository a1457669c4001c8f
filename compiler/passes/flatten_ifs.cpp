// If-conversion: an If whose sides are short and pure becomes straight code and selects. A divergent branch costs a test of the
// mask, often a misprediction, and mask arithmetic around it; a dozen vector instructions that half of the lanes do not need cost
// less.
#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Value;

// In instructions of one cycle, over both sides. A uniform branch is a scalar one and mostly predicted.
constexpr uint32_t kMaxDivergentCost = 20;
constexpr uint32_t kMaxUniformCost = 3;
constexpr uint32_t kTooCostly = 1000;

uint32_t cost(const Inst& inst) {
  switch (inst.op) {
    case Op::kYield:
    case Op::kConst:
      return 0;
    case Op::kResult:
    case Op::kLoopArg:
      return kTooCostly;  // of a construct that stays
    case Op::kFDiv:
    case Op::kFSqrt:
      return 8;
    case Op::kUDiv:
    case Op::kSDiv:
    case Op::kURem:
    case Op::kSRem:
      return kTooCostly;  // 16 scalar divisions
    case Op::kFMa:
      return 2;
    default:
      if (ir::is_transcendental(inst.op)) return kTooCostly;
      return ir::op_info(inst.op).effect == ir::Effect::kPure ? 1 : kTooCostly;
  }
}

class Flattener {
 public:
  explicit Flattener(ir::Kernel& kernel) : kernel_(kernel) {}

  void region(RegionId id) {
    const std::vector<Value> old = std::move(kernel_.regions[id].insts);
    std::vector<Value> out;
    out.reserve(old.size());
    for (size_t i = 0; i < old.size(); ++i) {
      const Inst inst = kernel_.at(old[i]);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) region(inst.region[r]);  // inner ones first
      if (inst.op != Op::kIf || !is_short(inst)) {
        out.push_back(old[i]);
        continue;
      }
      for (RegionId side : inst.region) {
        const auto& insts = kernel_.regions[side].insts;
        out.insert(out.end(), insts.begin(), insts.end() - 1);
      }
      for (; i + 1 < old.size() && kernel_.at(old[i + 1]).op == Op::kResult; ++i) {
        to_select(inst, kernel_.at(old[i + 1]));
        out.push_back(old[i + 1]);
      }
    }
    kernel_.regions[id].insts = std::move(out);
  }

 private:
  bool is_short(const Inst& branch) const {
    const uint32_t limit = branch.rate == ir::Rate::kLane ? kMaxDivergentCost : kMaxUniformCost;
    uint32_t sum = 0;
    for (RegionId side : branch.region) {
      for (Value v : kernel_.regions[side].insts) {
        sum += cost(kernel_.at(v));
        if (sum > limit) return false;
      }
    }
    return true;
  }

  void to_select(const Inst& branch, Inst& result) const {
    const uint64_t k = result.imm;
    result = {
        .op = Op::kSelect,
        .type = result.type,
        .operand = {branch.operand[0], ir::yielded(kernel_, branch.region[0])[k], ir::yielded(kernel_, branch.region[1])[k]}};
  }

  ir::Kernel& kernel_;
};

}  // namespace

void flatten_ifs(ir::Kernel& k) { Flattener(k).region(k.wave); }

}  // namespace pineda::passes
