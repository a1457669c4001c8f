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

using Emit = Value (*)(Builder& b, Value x, Value y);

template <Value (*kFn)(Builder&, Value)>
Value unary(Builder& b, Value x, Value) {
  return kFn(b, x);
}

struct Row {
  Op op;
  Emit fast, standard, exact;
};

// The one table of algorithms.
constexpr Row kRows[] = {
    {Op::kFSin, unary<fast::emit_sin>, unary<emit_sin>, unary<exact::emit_sin>},
    {Op::kFCos, unary<fast::emit_cos>, unary<emit_cos>, unary<exact::emit_cos>},
    {Op::kFTan, unary<fast::emit_tan>, unary<emit_tan>, unary<exact::emit_tan>},
    {Op::kFAsin, unary<fast::emit_asin>, unary<emit_asin>, unary<exact::emit_asin>},
    {Op::kFAcos, unary<fast::emit_acos>, unary<emit_acos>, unary<exact::emit_acos>},
    {Op::kFAtan, unary<fast::emit_atan>, unary<emit_atan>, unary<exact::emit_atan>},
    {Op::kFAtan2, fast::emit_atan2, emit_atan2, exact::emit_atan2},
    {Op::kFSinh, unary<emit_sinh>, unary<emit_sinh>, unary<exact::emit_sinh>},
    {Op::kFCosh, unary<emit_cosh>, unary<emit_cosh>, unary<exact::emit_cosh>},
    {Op::kFTanh, unary<emit_tanh>, unary<emit_tanh>, unary<exact::emit_tanh>},
    {Op::kFAsinh, unary<emit_asinh>, unary<emit_asinh>, unary<exact::emit_asinh>},
    {Op::kFAcosh, unary<emit_acosh>, unary<emit_acosh>, unary<exact::emit_acosh>},
    {Op::kFAtanh, unary<emit_atanh>, unary<emit_atanh>, unary<exact::emit_atanh>},
    {Op::kFRsqrt, unary<emit_rsqrt>, unary<emit_rsqrt>, unary<exact::emit_rsqrt>},
    {Op::kFExp2, unary<fast::emit_exp2>, unary<emit_exp2>, unary<exact::emit_exp2>},
    {Op::kFLog2, unary<fast::emit_log2>, unary<emit_log2>, unary<exact::emit_log2>},
    {Op::kFLog2Coarse, unary<emit_log2_coarse>, unary<emit_log2_coarse>, unary<emit_log2_coarse>},
    {Op::kFExp, unary<fast::emit_exp>, unary<emit_exp>, unary<exact::emit_exp>},
    {Op::kFLog, unary<fast::emit_log>, unary<emit_log>, unary<exact::emit_log>},
    {Op::kFPow, fast::emit_pow, emit_pow, exact::emit_pow},
};
constexpr uint32_t kFirst = static_cast<uint32_t>(Op::kFSin);

constexpr bool rows_follow_ops() {
  for (uint32_t i = 0; i < std::size(kRows); ++i) {
    if (static_cast<uint32_t>(kRows[i].op) != kFirst + i) return false;
  }
  return kRows[std::size(kRows) - 1].op == Op::kFPow;
}
static_assert(rows_follow_ops());

Value convert(Builder& b, Type to, Value x) { return b.type(x) == to ? x : b.convert(Op::kFConvert, to, x); }

Value lower(Builder& b, const Inst& inst, Precision precision) {
  const Row& row = kRows[static_cast<uint32_t>(inst.op) - kFirst];
  const Emit emit = precision == Precision::kFast ? row.fast : precision == Precision::kExact ? row.exact : row.standard;
  const Value x = convert(b, Type::kF32, inst.operand[0]);
  const Value y = inst.operand[1] ? convert(b, Type::kF32, inst.operand[1]) : Value{};
  return convert(b, inst.type, emit(b, x, y));
}

}  // namespace

void lower_math(Kernel& k, Precision precision) {
  Builder b(k);
  std::unordered_map<uint32_t, Value> replacement;
  const size_t regions = k.regions.size();
  for (ir::RegionId region = 1; region < regions; ++region) {
    std::vector<Value> before = std::move(k.regions[region].insts);
    k.regions[region].insts.clear();
    b.set_region(region);
    for (const Value v : before) {
      const Inst inst = k.at(v);
      if (ir::is_transcendental(inst.op)) {
        replacement[v.id] = lower(b, inst, precision);
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
