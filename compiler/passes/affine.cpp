// Addresses that grow by one element from lane to lane become a uniform offset and a lane stride: one vector access instead of a
// gather or scatter, and one scalar bounds check instead of sixteen. The offset may wrap at 2^32 between two lanes, as the
// original arithmetic could: the access is marked kWrap, and the back end looks whether it does.
#include <optional>

#include "base/abi.h"
#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::Rate;
using ir::RegionId;
using ir::Type;
using ir::Value;

constexpr int kMaxDepth = 8;

class Rewriter {
 public:
  explicit Rewriter(ir::Kernel& kernel) : kernel_(kernel) {}

  void region(RegionId id) {
    const std::vector<Value> old = std::move(kernel_.regions[id].insts);
    std::vector<Value> out;
    out.reserve(old.size());
    for (Value v : old) {
      out_ = &out;
      if (ir::is_memory(kernel_.at(v).op)) access(v);
      out.push_back(v);
      const Inst inst = kernel_.at(v);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) region(inst.region[r]);
    }
    kernel_.regions[id].insts = std::move(out);
  }

 private:
  bool varies(Value v) const { return v && kernel_.at(v).rate == Rate::kLane; }

  // "condition ? uniform limit : 0" is a limit for some lanes (jit/emit_bounds.cpp).
  bool limit_varies(Value limit) const {
    if (!varies(limit)) return false;
    const Inst& inst = kernel_.at(limit);
    if (inst.op != Op::kSelect || varies(inst.operand[1])) return true;
    const Inst& other = kernel_.at(inst.operand[2]);
    return other.op != Op::kConst || other.imm != 0;
  }

  void access(Value v) {
    const Inst inst = kernel_.at(v);
    if (inst.op == Op::kAtomic || inst.lane_stride() != 0 || !varies(inst.operand[1])) return;
    if (varies(inst.operand[0]) || limit_varies(ir::limit_of(inst))) return;
    const Type type = inst.op == Op::kStore ? kernel_.at(inst.operand[2]).type : inst.type;
    if (factor(inst.operand[1], 0) != ir::size_bytes(type)) return;
    Value offset = uniform(inst.operand[1]);
    if (!offset) offset = append({.op = Op::kConst, .type = Type::kI32, .rate = Rate::kDraw});
    Inst& access = kernel_.at(v);
    access.operand[1] = offset;
    access.imm |= static_cast<uint64_t>(ir::size_bytes(type)) << 32;
    access.flags |= ir::kWrap;
  }

  // By which a value grows from lane to lane; none when that is not one number.
  std::optional<uint32_t> factor(Value v, int depth) const {
    if (!varies(v)) return 0;
    const Inst& inst = kernel_.at(v);
    if (depth > kMaxDepth || inst.type != Type::kI32) return {};
    const auto of = [&](uint32_t i) { return factor(inst.operand[i], depth + 1); };
    const auto constant = [&](uint32_t i) -> std::optional<uint32_t> {
      const Inst& operand = kernel_.at(inst.operand[i]);
      return operand.op == Op::kConst ? std::optional(static_cast<uint32_t>(operand.imm)) : std::nullopt;
    };
    switch (inst.op) {
      case Op::kLane:
        return 1;
      case Op::kIAdd:
      case Op::kISub: {
        const auto a = of(0), b = of(1);
        if (!a || !b) return {};
        return inst.op == Op::kIAdd ? *a + *b : *a - *b;
      }
      case Op::kIMul:
        for (uint32_t i = 0; i < 2; ++i) {
          const auto k = constant(i), a = k ? of(1 - i) : std::nullopt;
          if (a) return *a * *k;
        }
        return {};
      case Op::kShl: {
        const auto k = constant(1), a = k ? of(0) : std::nullopt;
        return a ? std::optional(*a << (*k & 31)) : std::nullopt;
      }
      default:
        return {};
    }
  }

  // The value at lane 0, for values that have a factor; unset: 0. New instructions go in front of the access: what `v` was made
  // of is visible wherever `v` is.
  Value uniform(Value v) {
    if (!varies(v)) return v;
    const Inst inst = kernel_.at(v);
    if (inst.op == Op::kLane) return {};
    const Value a = uniform(inst.operand[0]), b = uniform(inst.operand[1]);
    const auto both = [&](Value x, Value y) {
      return append({.op = inst.op, .type = Type::kI32, .rate = Rate::kWave, .operand = {x, y}});
    };
    switch (inst.op) {
      case Op::kIAdd:
        return !a ? b : !b ? a : both(a, b);
      case Op::kISub:
        if (!b) return a;
        return both(a ? a : append({.op = Op::kConst, .type = Type::kI32, .rate = Rate::kDraw}), b);
      case Op::kShl:
        return a ? both(a, b) : Value{};
      default:  // IMul
        return a && b ? both(a, b) : Value{};
    }
  }

  Value append(const Inst& inst) {
    const Value v = add_inst(kernel_, inst);
    out_->push_back(v);
    return v;
  }

  ir::Kernel& kernel_;
  std::vector<Value>* out_ = nullptr;
};

}  // namespace

void affine_addresses(ir::Kernel& k) { Rewriter(k).region(k.wave); }

}  // namespace pineda::passes
