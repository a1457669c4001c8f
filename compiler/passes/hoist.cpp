// Loop-invariant code motion for the two outermost loops of a kernel: what depends on nothing but the draw moves to Kernel::draw,
// what depends on the primitive to Kernel::prim; out of Ifs and Loops too. Only instructions that may run for lanes and waves
// that would not have run them: pure ones, and invariant loads whose address is checked or valid anyway.
#include <algorithm>

#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Value;

enum class Level : uint8_t { kDraw, kPrim, kWave };

class Hoister {
 public:
  explicit Hoister(ir::Kernel& kernel) : kernel_(kernel), aliases_(kernel), level_(kernel.insts.size(), Level::kWave) {
    for (RegionId* root : {&kernel_.draw, &kernel_.prim}) {
      if (*root != 0) continue;
      *root = static_cast<RegionId>(kernel_.regions.size());
      kernel_.regions.emplace_back();
    }
  }

  void run() {
    for (Value v : kernel_.regions[kernel_.draw].insts) level_[v.id] = Level::kDraw;
    std::vector<Value> prim = std::move(kernel_.regions[kernel_.prim].insts);
    kernel_.regions[kernel_.prim].insts.clear();
    for (Value v : prim) move(v, Level::kPrim);
    region(kernel_.wave);
  }

 private:
  void region(RegionId id) {
    auto insts = std::move(kernel_.regions[id].insts);
    size_t kept = 0;
    for (Value v : insts) {
      aliases_.apply(kernel_, v);
      if (move(v, Level::kWave)) continue;
      insts[kept++] = v;
      const Inst inst = kernel_.at(v);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) region(inst.region[r]);
    }
    insts.resize(kept);
    kernel_.regions[id].insts = std::move(insts);
  }

  // Puts `v` where it can stand, `at_most` being where it stands now. False: it stays in the wave.
  bool move(Value v, Level at_most) {
    const Inst& inst = kernel_.at(v);
    const Level level = std::min(highest(inst), at_most);
    level_[v.id] = level;
    if (level == Level::kWave) return false;
    if (inst.op == Op::kQuadSwizzle) {  // of a value that all lanes share
      aliases_.set(v, inst.operand[0]);
    } else {
      kernel_.regions[level == Level::kDraw ? kernel_.draw : kernel_.prim].insts.push_back(v);
    }
    return true;
  }

  Level highest(const Inst& inst) const {
    switch (inst.op) {
      case Op::kWavePtr:
      case Op::kLane:
      case Op::kUnpackMask:
      case Op::kLocal:
      case Op::kLoopArg:
      case Op::kResult:
        return Level::kWave;
      case Op::kPrimPtr:
        return Level::kPrim;
      case Op::kLoad: {
        const bool anywhere = ir::limit_of(inst) || (inst.flags & ir::kSpeculate);
        if (!(inst.flags & ir::kInvariant) || inst.lane_stride() != 0 || !anywhere) return Level::kWave;
        break;
      }
      default:
        if (ir::op_info(inst.op).effect != ir::Effect::kPure) return Level::kWave;
    }
    Level out = Level::kDraw;
    for (Value operand : inst.operand) {
      if (operand) out = std::max(out, level_[operand.id]);
    }
    return out;
  }

  ir::Kernel& kernel_;
  Aliases aliases_;
  std::vector<Level> level_;  // by value: where it stands
};

}  // namespace

void hoist(ir::Kernel& k) { Hoister(k).run(); }

}  // namespace pineda::passes
