#include "compiler/ir/builder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace pineda::ir {
namespace {

uint64_t width_mask(Type t) {
  if (t == Type::kB1) return 1;
  return size_bytes(t) == 8 ? ~0ull : (1ull << (8 * size_bytes(t))) - 1;
}

// Whether the value's bits can be a NaN that an operation made, whose payload is unspecified. Moves of such a value count too;
// memory and constants hold bits that are already defined.
bool needs_canon(const Inst& inst) {
  if (!is_float(inst.type)) return false;
  return inst.op != Op::kLoad && inst.op != Op::kConst && inst.op != Op::kBitcast && inst.op != Op::kFCanon;
}

bool is_const(const Inst& inst, uint64_t bits) { return inst.op == Op::kConst && inst.imm == bits; }

}  // namespace

Builder::Builder(Kernel& kernel) : kernel_(&kernel) {
  for (RegionId* region : {&kernel.draw, &kernel.prim, &kernel.wave}) {
    if (*region != 0) continue;
    *region = static_cast<RegionId>(kernel.regions.size());
    kernel.regions.emplace_back();
  }
  region_ = kernel.wave;
  const auto& wave = kernel.regions[kernel.wave].insts;
  while (local_count_ < wave.size() && kernel.at(wave[local_count_]).op == Op::kLocal) ++local_count_;
}

Value Builder::append(const Inst& inst) {
  const Value value{static_cast<uint32_t>(kernel_->insts.size())};
  kernel_->insts.push_back(inst);
  auto& wave = kernel_->regions[kernel_->wave].insts;
  if (inst.op == Op::kLocal) {  // at the head of the wave region, so that it dominates every use
    wave.insert(wave.begin() + local_count_++, value);
  } else {
    kernel_->regions[region_].insts.push_back(value);
  }
  return value;
}

// ---- sources --------------------------------------------------------------------------------------------------------------

Value Builder::constant(Type type, uint64_t bits) {
  return append({.op = Op::kConst, .type = type, .imm = bits & width_mask(type)});
}

Value Builder::fconst(Type type, double v) {
  if (std::isnan(v)) v = std::numeric_limits<double>::quiet_NaN();  // the one NaN that a Const may hold
  return append({.op = Op::kConst, .type = type, .imm = std::bit_cast<uint64_t>(v)});
}

Value Builder::zero(Type type) { return is_float(type) ? fconst(type, 0) : constant(type, 0); }

Value Builder::draw_ptr() { return append({.op = Op::kDrawPtr, .type = Type::kPtr}); }
Value Builder::thread_ptr() { return append({.op = Op::kThreadPtr, .type = Type::kPtr}); }
Value Builder::prim_ptr() { return append({.op = Op::kPrimPtr, .type = Type::kPtr}); }
Value Builder::wave_ptr() { return append({.op = Op::kWavePtr, .type = Type::kPtr}); }
Value Builder::lane() { return append({.op = Op::kLane, .type = Type::kI32}); }

// ---- operations -----------------------------------------------------------------------------------------------------------

Value Builder::op(Op op, Type type, std::initializer_list<Value> operands, uint64_t imm, uint8_t flags) {
  const Value* a = operands.begin();
  // identities that cost one look; passes/fold has the rest
  switch (op) {
    case Op::kIAdd:
    case Op::kOr:
    case Op::kXor:
      if (is_const(kernel_->at(a[0]), 0)) return a[1];
      [[fallthrough]];
    case Op::kISub:
    case Op::kShl:
    case Op::kLShr:
    case Op::kAShr:
    case Op::kPtrAdd:
      if (is_const(kernel_->at(a[1]), 0)) return a[0];
      break;
    case Op::kIMul:
      if (is_const(kernel_->at(a[0]), 1)) return a[1];
      if (is_const(kernel_->at(a[1]), 1)) return a[0];
      break;
    case Op::kAnd:
      if (is_const(kernel_->at(a[0]), width_mask(type))) return a[1];
      if (is_const(kernel_->at(a[1]), width_mask(type))) return a[0];
      break;
    case Op::kSelect:
      if (a[1] == a[2] || is_const(kernel_->at(a[0]), 1)) return a[1];
      if (is_const(kernel_->at(a[0]), 0)) return a[2];
      break;
    case Op::kFConvert:
    case Op::kZExt:
    case Op::kSExt:
    case Op::kTrunc:
    case Op::kBitcast:
      if (kernel_->at(a[0]).type == type) return a[0];
      break;
    case Op::kFAdd:
    case Op::kFSub:
    case Op::kFMul:
      flags |= float_flags_;
      break;
    default:
      break;
  }
  Inst inst{.op = op, .type = type, .flags = flags, .imm = imm};
  std::ranges::copy(operands, inst.operand.begin());
  return append(inst);
}

Value Builder::bitcast(Type to, Value a) {
  if (type(a) == to) return a;
  if (needs_canon(kernel_->at(a))) a = fcanon(a);
  return op(Op::kBitcast, to, {a});
}

// ---- memory ---------------------------------------------------------------------------------------------------------------

Value Builder::load(Type type, const Address& from, uint8_t flags) {
  const Value offset = from.offset ? from.offset : i32(0);
  return append({.op = Op::kLoad,
                 .type = type,
                 .flags = flags,
                 .operand = {from.base, offset, from.limit},
                 .imm = static_cast<uint64_t>(from.lane_stride) << 32});
}

void Builder::store(const Address& to, Value value, uint8_t flags) {
  if (needs_canon(kernel_->at(value))) value = fcanon(value);
  const Value offset = to.offset ? to.offset : i32(0);
  append({.op = Op::kStore,
          .flags = flags,
          .operand = {to.base, offset, value, to.limit},
          .imm = static_cast<uint64_t>(to.lane_stride) << 32});
}

Value Builder::atomic(AtomicOp op, const Address& at, Value value, Value comparand, uint8_t flags) {
  const Value offset = at.offset ? at.offset : i32(0);
  return append({.op = Op::kAtomic,
                 .type = type(value),
                 .flags = flags,
                 .operand = {at.base, offset, value, at.limit, comparand},
                 .imm = static_cast<uint64_t>(at.lane_stride) << 32 | static_cast<uint64_t>(op)});
}

// ---- control flow ---------------------------------------------------------------------------------------------------------

namespace {

RegionId add_region(Kernel& kernel) {
  kernel.regions.emplace_back();
  return static_cast<RegionId>(kernel.regions.size() - 1);
}

uint32_t add_list(Kernel& kernel, std::vector<Value> values) {
  kernel.lists.push_back(std::move(values));
  return static_cast<uint32_t>(kernel.lists.size() - 1);
}

}  // namespace

std::vector<Value> Builder::if_else(Value cond, const std::vector<Type>& results, const Body& then_body, const Body& else_body) {
  const Value branch = append({.op = Op::kIf, .operand = {cond}});
  const RegionId outer = region_;
  const Body* bodies[2] = {&then_body, &else_body};
  for (int side = 0; side < 2; ++side) {
    region_ = add_region(*kernel_);
    kernel_->at(branch).region[side] = region_;
    std::vector<Value> values = (*bodies[side])();
    append({.op = Op::kYield, .list = add_list(*kernel_, std::move(values))});
  }
  region_ = outer;
  std::vector<Value> out;
  for (Type t : results) out.push_back(append({.op = Op::kResult, .type = t, .operand = {branch}, .imm = out.size()}));
  return out;
}

void Builder::if_(Value cond, const std::function<void()>& then_body) {
  if_else(cond, then_body, [] {});
}

void Builder::if_else(Value cond, const std::function<void()>& then_body, const std::function<void()>& else_body) {
  const auto no_result = [](const std::function<void()>& body) {
    return [&body] {
      body();
      return std::vector<Value>();
    };
  };
  if_else(cond, {}, no_result(then_body), no_result(else_body));
}

std::vector<Value> Builder::loop(const std::vector<Value>& init,
                                 const std::function<LoopStep(std::span<const Value> carried)>& body) {
  const Value loop = append({.op = Op::kLoop, .list = add_list(*kernel_, init)});
  const RegionId outer = region_;
  region_ = add_region(*kernel_);
  kernel_->at(loop).region[0] = region_;
  std::vector<Value> carried;
  for (Value v : init) carried.push_back(append({.op = Op::kLoopArg, .type = type(v), .imm = carried.size()}));
  LoopStep step = body(carried);
  step.next.insert(step.next.begin(), step.again);
  append({.op = Op::kYield, .list = add_list(*kernel_, std::move(step.next))});
  region_ = outer;
  std::vector<Value> out;
  for (Value v : init) out.push_back(append({.op = Op::kResult, .type = type(v), .operand = {loop}, .imm = out.size()}));
  return out;
}

}  // namespace pineda::ir
