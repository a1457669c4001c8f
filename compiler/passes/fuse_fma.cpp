// The one place where a * b + c becomes an FMA. The rule looks at the expression alone, so a shader gives the same bits whatever
// else its kernel holds:
//     fadd(fmul(a, b), c) -> fma(a, b, c)        fsub(fmul(a, b), c) -> fma(a, b, -c)
//     fadd(c, fmul(a, b)) -> fma(a, b, c)        fsub(c, fmul(a, b)) -> fma(-a, b, c)
// The left product wins when both are products. F32 only: without FMA hardware an F64 FMA costs hundreds of instructions.
//
// optimize() runs this on the expressions as they were built, before fold can know that an operand happens to be constant.
// Whatever was not fused then is marked kNoContract, so that the decision stands: a second run (after lower_math) sees new
// instructions only.
#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::Value;

class Fuser {
 public:
  explicit Fuser(ir::Kernel& kernel) : kernel_(kernel) {}

  void region(ir::RegionId id) {
    const std::vector<Value> old = std::move(kernel_.regions[id].insts);
    std::vector<Value> out;
    out.reserve(old.size());
    for (Value v : old) {
      fuse(v, out);
      out.push_back(v);
      const Inst inst = kernel_.at(v);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) region(inst.region[r]);
    }
    kernel_.regions[id].insts = std::move(out);
  }

 private:
  static bool may_contract(const Inst& inst) { return inst.type == ir::Type::kF32 && !(inst.flags & ir::kNoContract); }

  bool is_product(Value v) const { return kernel_.at(v).op == Op::kFMul && may_contract(kernel_.at(v)); }

  Value negate(Value a, std::vector<Value>& out) {
    out.push_back(add_inst(kernel_, {.op = Op::kFNeg, .type = ir::Type::kF32, .operand = {a}}));
    return out.back();
  }

  void fuse(Value v, std::vector<Value>& out) {
    const Inst inst = kernel_.at(v);
    if ((inst.op != Op::kFAdd && inst.op != Op::kFSub) || !may_contract(inst)) return;
    const Value left = inst.operand[0], right = inst.operand[1];
    Value a, b, c;
    if (is_product(left)) {
      const Inst product = kernel_.at(left);
      a = product.operand[0], b = product.operand[1];
      c = inst.op == Op::kFSub ? negate(right, out) : right;
    } else if (is_product(right)) {
      const Inst product = kernel_.at(right);
      a = inst.op == Op::kFSub ? negate(product.operand[0], out) : product.operand[0];
      b = product.operand[1], c = left;
    } else {
      return;
    }
    kernel_.at(v) = {.op = Op::kFMa, .type = ir::Type::kF32, .operand = {a, b, c}};
  }

  ir::Kernel& kernel_;
};

}  // namespace

void fuse_fma(ir::Kernel& k) {
  Fuser fuser(k);
  for (ir::RegionId root : {k.draw, k.prim, k.wave}) {
    if (root != 0) fuser.region(root);
  }
  for (Inst& inst : k.insts) {
    if (inst.op == Op::kFAdd || inst.op == Op::kFSub || inst.op == Op::kFMul) inst.flags |= ir::kNoContract;
  }
}

}  // namespace pineda::passes
