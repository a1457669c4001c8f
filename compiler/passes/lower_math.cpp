#include "compiler/passes/lower_math.h"

#include <unordered_map>

#include "compiler/ir/walk.h"
#include "compiler/passes/passes.h"

namespace pineda::passes {
namespace {

using ir::Builder;
using ir::Inst;
using ir::Kernel;
using ir::Op;
using ir::Type;
using ir::Value;

bool is_transcendental(Op op) { return op >= Op::kFSin && op <= Op::kFPow; }

Value emit(Builder& b, Op op, Value x, Value y) {
  switch (op) {
    case Op::kFSin:
      return emit_sin(b, x);
    case Op::kFCos:
      return emit_cos(b, x);
    case Op::kFTan:
      return emit_tan(b, x);
    case Op::kFAsin:
      return emit_asin(b, x);
    case Op::kFAcos:
      return emit_acos(b, x);
    case Op::kFAtan:
      return emit_atan(b, x);
    case Op::kFAtan2:
      return emit_atan2(b, x, y);
    case Op::kFExp2:
      return emit_exp2(b, x);
    case Op::kFLog2:
      return emit_log2(b, x);
    case Op::kFLog2Coarse:
      return emit_log2_coarse(b, x);
    case Op::kFExp:
      return emit_exp(b, x);
    case Op::kFLog:
      return emit_log(b, x);
    case Op::kFPow:
      return emit_pow(b, x, y);
    default:
      return {};
  }
}

// binary16 goes through binary32; binary64 has no transcendentals in Vulkan's GLSL set and is left to be refused by the back end.
Value lower(Builder& b, const Inst& inst) {
  Value x = inst.operand[0], y = inst.operand[1];
  if (inst.type == Type::kF32) return emit(b, inst.op, x, y);
  x = b.convert(Op::kFConvert, Type::kF32, x);
  if (y) y = b.convert(Op::kFConvert, Type::kF32, y);
  return b.convert(Op::kFConvert, inst.type, emit(b, inst.op, x, y));
}

}  // namespace

void lower_math(Kernel& k) {
  Builder b(k);
  std::unordered_map<uint32_t, Value> replacement;
  const size_t regions = k.regions.size();
  for (ir::RegionId region = 1; region < regions; ++region) {
    std::vector<Value> before = std::move(k.regions[region].insts);
    k.regions[region].insts.clear();
    b.set_region(region);
    for (const Value v : before) {
      const Inst inst = k.at(v);
      if (is_transcendental(inst.op) && (inst.type == Type::kF32 || inst.type == Type::kF16)) {
        replacement[v.id] = lower(b, inst);
      } else {
        k.regions[region].insts.push_back(v);
      }
    }
  }
  if (replacement.empty()) return;
  const auto replace = [&](Value& v) {  // an operand may itself have been replaced
    for (auto found = replacement.find(v.id); found != replacement.end(); found = replacement.find(v.id)) v = found->second;
  };
  for (uint32_t id = 1; id < k.insts.size(); ++id) ir::for_each_operand(k, Value{id}, replace);
}

}  // namespace pineda::passes
