// The rules a kernel must keep, beyond ir.h:
//   * each instruction stands in one region, each region belongs to one If, Loop or root; nesting is at most kMaxRegionDepth
//   deep;
//   * both regions of an If exist; every If/Loop region ends with its only Yield;
//   * the LoopArgs 0..n-1 are the first instructions of a loop body, all present and in order;
//   * Results follow their If or Loop at once;
//   * Locals stand in the wave region, before anything else that is not a Local, and take at most kMaxLocalBytes together;
//   * draw and prim hold only pure instructions and invariant loads that such a rate can know;
//   * a float constant that is a NaN is the canonical one.
// The type rules of ops.inc are check_types().
#include <bit>
#include <cmath>
#include <limits>

#include "compiler/ir/limits.h"
#include "compiler/ir/text.h"
#include "compiler/ir/walk.h"

namespace pineda::ir {
namespace {

// What one instruction's types must be; gives the fault or null.
class TypeCheck {
 public:
  TypeCheck(const Kernel& kernel, const Inst& inst) : kernel_(kernel), inst_(inst), type_(inst.type) {}

  const char* run() const {
    switch (op_info(inst_.op).rule) {
      case TypeRule::kAny:
        return any();
      case TypeRule::kPtr:
        return type_ == Type::kPtr ? nullptr : "result must be ptr";
      case TypeRule::kI32:
        return type_ == Type::kI32 ? nullptr : "result must be i32";
      case TypeRule::kSame:
        return same();
      case TypeRule::kCompare:
        return compare();
      case TypeRule::kFToI:
        return is_float(arg(0)) && is_int(type_) ? nullptr : "must convert float to integer";
      case TypeRule::kIToF:
        return is_int(arg(0)) && is_float(type_) ? nullptr : "must convert integer to float";
      case TypeRule::kFToF:
        return is_float(arg(0)) && is_float(type_) && arg(0) != type_ ? nullptr : "must convert between two float types";
      case TypeRule::kIToI:
        return int_to_int();
      case TypeRule::kBitcast:
        return is_bits(arg(0)) && is_bits(type_) && size_bytes(arg(0)) == size_bytes(type_) ? nullptr : "must keep the width";
      case TypeRule::kSelect:
        return arg(0) == Type::kB1 && type_ != Type::kVoid && arg(1) == type_ && arg(2) == type_ ? nullptr
                                                                                                 : "must be b1, T, T -> T";
      case TypeRule::kMaskToB1:
        return arg(0) == Type::kI32 && type_ == Type::kB1 ? nullptr : "must be i32 -> b1";
      case TypeRule::kB1ToMask:
        return arg(0) == Type::kB1 && type_ == Type::kI32 ? nullptr : "must be b1 -> i32";
      case TypeRule::kShuffle:
        return arg(0) == type_ && type_ != Type::kVoid && arg(1) == Type::kI32 ? nullptr : "must be T, i32 -> T";
      case TypeRule::kReduce:
        return reduce();
      case TypeRule::kPtrAdd:
        return arg(0) == Type::kPtr && (arg(1) == Type::kI32 || arg(1) == Type::kI64) && type_ == Type::kPtr
                   ? nullptr
                   : "must be ptr, i32 or i64 -> ptr";
      case TypeRule::kVoid:
        return no_result();
      case TypeRule::kAtomic:
        return atomic();
      case TypeRule::kLocalLd:
        return type_ == arg(0) && arg(1) == Type::kI32 ? nullptr : "must be the local's type, index i32";
    }
    return "has no type rule";
  }

 private:
  static bool is_bits(Type t) { return is_int(t) || is_float(t) || t == Type::kPtr; }
  Type arg(uint32_t i) const { return kernel_.at(inst_.operand[i]).type; }

  const char* any() const {
    if (type_ == Type::kVoid) return "needs a type";
    if (inst_.op == Op::kConst) return constant();
    if (inst_.op == Op::kLoad) return type_ == Type::kB1 ? "b1 is never in memory" : address();
    return nullptr;
  }

  const char* constant() const {
    if (type_ == Type::kPtr) return inst_.imm == 0 ? nullptr : "a ptr constant must be 0";
    if (is_float(type_)) {
      const bool nan = std::isnan(std::bit_cast<double>(inst_.imm));
      return nan && inst_.imm != std::bit_cast<uint64_t>(std::numeric_limits<double>::quiet_NaN()) ? "nan is not canonical"
                                                                                                   : nullptr;
    }
    const uint32_t bits = type_ == Type::kB1 ? 1 : 8 * size_bytes(type_);
    return bits < 64 && inst_.imm >> bits != 0 ? "constant does not fit its type" : nullptr;
  }

  const char* same() const {
    const Op op = inst_.op;
    for (uint32_t i = 0; i < op_info(op).operands; ++i) {
      if (arg(i) != type_) return "operands must have the result's type";
    }
    if (op == Op::kQuadSwizzle) return is_bits(type_) || type_ == Type::kB1 ? nullptr : "needs a value";
    const bool logic = op == Op::kAnd || op == Op::kOr || op == Op::kXor || op == Op::kNot;
    if (op == Op::kMAdd16) return type_ == Type::kI32 ? nullptr : "needs i32";
    if (op >= Op::kIAdd && op <= Op::kBitReverse) {
      return is_int(type_) || (logic && type_ == Type::kB1) ? nullptr : "needs integers";
    }
    if (is_transcendental(op)) return type_ == Type::kF32 || type_ == Type::kF16 ? nullptr : "needs f16 or f32";
    return is_float(type_) ? nullptr : "needs floats";
  }

  const char* reduce() const {
    if (arg(0) != type_) return "operands must have the result's type";
    const ReduceOp op = inst_.reduce_op();
    if (op >= ReduceOp::kFAdd) return is_float(type_) ? nullptr : "needs floats";
    const bool logic = op == ReduceOp::kAnd || op == ReduceOp::kOr || op == ReduceOp::kXor;
    return is_int(type_) || (logic && type_ == Type::kB1) ? nullptr : "needs integers";
  }

  const char* compare() const {
    if (type_ != Type::kB1) return "result must be b1";
    if (arg(0) != arg(1)) return "operands must have one type";
    const bool wants_int = inst_.op <= Op::kSLe;
    if (wants_int) return is_int(arg(0)) ? nullptr : "needs integers";
    return is_float(arg(0)) ? nullptr : "needs floats";
  }

  const char* int_to_int() const {
    if (!is_int(type_)) return "result must be an integer";
    if (inst_.op == Op::kTrunc) {
      return is_int(arg(0)) && size_bytes(arg(0)) > size_bytes(type_) ? nullptr : "must narrow an integer";
    }
    if (arg(0) == Type::kB1) return nullptr;
    return is_int(arg(0)) && size_bytes(arg(0)) < size_bytes(type_) ? nullptr : "must widen an integer or b1";
  }

  const char* address() const {
    if (arg(0) != Type::kPtr) return "base must be ptr";
    if (arg(1) != Type::kI32) return "offset must be i32";
    const Value limit = limit_of(inst_);
    if (limit && kernel_.at(limit).type != Type::kI32) return "limit must be i32";
    return nullptr;
  }

  const char* no_result() const {
    if (type_ != Type::kVoid) return "has no result";
    switch (inst_.op) {
      case Op::kStore:
        if (!is_bits(arg(2))) return "b1 is never in memory";
        return address();
      case Op::kCall:
        return arg(0) == Type::kPtr && arg(1) == Type::kPtr ? nullptr : "must be ptr, ptr";
      case Op::kLocalStore:
        return arg(1) == Type::kI32 && arg(2) == arg(0) ? nullptr : "must be index i32, value of the local's type";
      case Op::kIf:
        return arg(0) == Type::kB1 ? nullptr : "condition must be b1";
      default:
        return nullptr;
    }
  }

  const char* atomic() const {
    if (inst_.atomic_op() > AtomicOp::kCompareExchange) return "unknown atomic operation";
    if (type_ != Type::kI32 && type_ != Type::kI64) return "needs i32 or i64";
    if (arg(2) != type_) return "value must have the result's type";
    const Value comparand = inst_.operand[kComparandIndex];
    const bool wants_comparand = inst_.atomic_op() == AtomicOp::kCompareExchange;
    if (static_cast<bool>(comparand) != wants_comparand) return "comparand goes with compare_exchange";
    if (comparand && kernel_.at(comparand).type != type_) return "comparand must have the result's type";
    return address();
  }

  const Kernel& kernel_;
  const Inst& inst_;
  Type type_;
};

class Verifier {
 public:
  explicit Verifier(const Kernel& kernel)
      : kernel_(kernel), visible_(kernel.insts.size()), placed_(kernel.insts.size()), used_(kernel.regions.size()) {}

  std::string run() {
    if (kernel_.wave == 0) return "kernel has no wave region";
    for (RegionId root : {kernel_.draw, kernel_.prim, kernel_.wave}) {
      if (root != 0 && !region(root, 0)) return fault_;
    }
    return {};
  }

 private:
  bool fail(Value v, const std::string& text) {
    if (fault_.empty()) fault_ = "`" + instruction_text(kernel_, Names(kernel_), v) + "`: " + text;
    return false;
  }

  bool is_root(RegionId id) const { return id == kernel_.draw || id == kernel_.prim || id == kernel_.wave; }

  // `owner`: the If or Loop, or none for a root.
  bool region(RegionId id, int depth, Value owner = {}) {
    if (id == 0 || id >= kernel_.regions.size()) return fail(owner, "a region is missing");
    if (used_[id]) return fail(owner, "a region is used twice");
    used_[id] = true;
    if (depth > static_cast<int>(kMaxRegionDepth)) return fail(owner, "regions are nested too deeply");
    const auto& insts = kernel_.regions[id].insts;
    if (owner && (insts.empty() || !valid(insts.back()) || kernel_.at(insts.back()).op != Op::kYield)) {
      return fail(owner, "a region does not end with yield");
    }
    for (size_t i = 0; i < insts.size(); ++i) {
      const Value v = insts[i];
      if (!valid(v)) return fail(v, "is not an instruction");
      if (placed_[v.id]) return fail(v, "stands in two places");
      placed_[v.id] = true;
      if (!instruction(v, id, i, depth, owner)) return false;
      visible_[v.id] = true;
    }
    if (owner && !loop_args(id, owner)) return false;
    if (!is_root(id)) {
      for (Value v : insts) visible_[v.id] = false;
    }
    return true;
  }

  bool valid(Value v) const {
    return v.id != 0 && v.id < kernel_.insts.size() && kernel_.at(v).op > Op::kInvalid && kernel_.at(v).op < Op::kCount;
  }
  bool is_visible(Value v) const { return v.id != 0 && v.id < visible_.size() && visible_[v.id]; }

  bool instruction(Value v, RegionId id, size_t index, int depth, Value owner) {
    const Inst& inst = kernel_.at(v);
    if (inst.type > Type::kPtr || inst.rate > Rate::kLane) return fail(v, "type or rate is out of range");
    if (!operands(v)) return false;
    if (const char* fault = TypeCheck(kernel_, inst).run()) return fail(v, fault);
    if (const char* fault = flags_and_imm(inst)) return fail(v, fault);
    if (id != kernel_.wave && is_root(id)) {
      if (const char* fault = outer_rate(inst, id)) return fail(v, fault);
    }
    switch (inst.op) {
      case Op::kIf:
      case Op::kLoop:
        for (uint32_t r = 0; r < region_count(inst.op); ++r) {
          if (!region(inst.region[r], depth + 1, v)) return false;
        }
        return yields(v);
      case Op::kYield:
        return owner && index + 1 == kernel_.regions[id].insts.size() ? true : fail(v, "yield must end a region of if or loop");
      case Op::kResult:
        return result(v, id, index);
      case Op::kLoopArg:
        return owner && kernel_.at(owner).op == Op::kLoop ? true : fail(v, "must stand in a loop body");
      case Op::kLocal:
        return local(v, id, index);
      case Op::kLocalLoad:
      case Op::kLocalStore:
        return kernel_.at(inst.operand[0]).op == Op::kLocal ? true : fail(v, "first operand must be a local");
      default:
        return true;
    }
  }

  bool operands(Value v) {
    const Inst& inst = kernel_.at(v);
    const uint32_t count = op_info(inst.op).operands;
    for (uint32_t i = 0; i < kMaxOperands; ++i) {
      const bool optional = is_memory(inst.op) && (i == limit_index(inst.op) || (inst.op == Op::kAtomic && i == kComparandIndex));
      const Value operand = inst.operand[i];
      if (i >= count && !operand) continue;
      if (i >= count && !optional) return fail(v, "has too many operands");
      if (!is_visible(operand)) return fail(v, "operand " + std::to_string(i) + " is not defined before it");
      const Op source = kernel_.at(operand).op;
      if ((source == Op::kIf || source == Op::kLoop) != (inst.op == Op::kResult)) {
        return fail(v, "if and loop are operands of result only");
      }
      if (kernel_.at(operand).type == Type::kVoid && inst.op != Op::kResult) return fail(v, "an operand has no value");
      const bool uses_local = (inst.op == Op::kLocalLoad || inst.op == Op::kLocalStore) && i == 0;
      if (source == Op::kLocal && !uses_local) return fail(v, "a local is not a value");
    }
    if (!has_list(inst.op)) return inst.list == 0 ? true : fail(v, "has a list");
    if (inst.list >= kernel_.lists.size()) return fail(v, "list is out of range");
    for (Value value : kernel_.lists[inst.list]) {
      if (!is_visible(value)) return fail(v, "a listed value is not defined before it");
      if (kernel_.at(value).type == Type::kVoid || kernel_.at(value).op == Op::kLocal)
        return fail(v, "lists what is not a value");
    }
    return true;
  }

  static const char* flags_and_imm(const Inst& inst) {
    uint8_t allowed = 0;
    if (inst.op == Op::kLoad) allowed = kInvariant | kSpeculate | kVolatile;
    if (inst.op == Op::kStore) allowed = kAllLanes;
    if (inst.op == Op::kIf) allowed = kLikely;
    if (inst.op == Op::kAtomic) allowed = kPrivate;
    if (inst.op == Op::kFAdd || inst.op == Op::kFSub || inst.op == Op::kFMul) allowed = kNoContract;
    if (inst.flags & ~allowed) return "has a flag that it cannot have";
    if (!has_regions(inst.op) && (inst.region[0] != 0 || inst.region[1] != 0)) return "has a region";
    if (inst.op == Op::kLoop && inst.region[1] != 0) return "has a second region";
    switch (inst.op) {
      case Op::kConst:
        return nullptr;
      case Op::kQuadSwizzle:
        return inst.imm < 256 ? nullptr : "pattern is out of range";
      case Op::kReduce:
        return inst.reduce_op() < ReduceOp::kCount && inst.scan() <= Scan::kExclusive && inst.imm >> 16 <= 4
                   ? nullptr
                   : "imm is out of range";
      case Op::kLocal:
        return inst.imm > 0 && inst.imm <= kMaxLocalBytes ? nullptr : "count is out of range";
      case Op::kCall:
        return inst.imm > 0 && inst.imm <= kMaxRecordBytes ? nullptr : "the record's size is out of range";
      case Op::kLoopArg:
      case Op::kResult:
        return nullptr;  // checked against the list
      case Op::kLoad:
      case Op::kStore:
        return (inst.imm & 0xffffffff) == 0 ? nullptr : "imm is out of range";
      case Op::kAtomic:
        return nullptr;
      default:
        return inst.imm == 0 ? nullptr : "has an imm";
    }
  }

  // Why an instruction cannot stand in the draw or prim region.
  const char* outer_rate(const Inst& inst, RegionId id) const {
    switch (inst.op) {
      case Op::kWavePtr:
      case Op::kLane:
      case Op::kUnpackMask:
      case Op::kQuadSwizzle:
      case Op::kLocal:
        return "is not known before the wave";
      case Op::kPrimPtr:
        return id == kernel_.draw ? "is not known before the primitive" : nullptr;
      case Op::kLoad:
        if (!(inst.flags & kInvariant)) return "only invariant loads may stand here";
        if (inst.lane_stride() != 0) return "is not known before the wave";
        return limit_of(inst) || (inst.flags & kSpeculate) ? nullptr : "must be checked or speculate to stand here";
      default:
        return op_info(inst.op).effect == Effect::kPure ? nullptr : "is not pure";
    }
  }

  bool local(Value v, RegionId id, size_t index) {
    if (id != kernel_.wave) return fail(v, "must stand in the wave region");
    if (index > 0 && kernel_.at(kernel_.regions[id].insts[index - 1]).op != Op::kLocal) {
      return fail(v, "must stand at the head of the wave region");
    }
    local_bytes_ += kernel_.at(v).imm * size_bytes(kernel_.at(v).type);
    return local_bytes_ <= kMaxLocalBytes ? true : fail(v, "locals take more than " + std::to_string(kMaxLocalBytes) + " bytes");
  }

  bool loop_args(RegionId id, Value owner) {
    const Inst& inst = kernel_.at(owner);
    const auto& insts = kernel_.regions[id].insts;
    const std::vector<Value> none;
    const auto& init = inst.op == Op::kLoop ? kernel_.lists[inst.list] : none;
    for (size_t k = 0; k < init.size(); ++k) {
      const bool present = k < insts.size() && kernel_.at(insts[k]).op == Op::kLoopArg && kernel_.at(insts[k]).imm == k;
      if (!present) return fail(owner, "loop_arg " + std::to_string(k) + " is not at its place");
      if (kernel_.at(insts[k]).type != kernel_.at(init[k]).type) return fail(insts[k], "has not the type of its initial value");
    }
    for (size_t i = init.size(); i < insts.size(); ++i) {
      if (kernel_.at(insts[i]).op == Op::kLoopArg) return fail(insts[i], "no such carried value");
    }
    return true;
  }

  bool yields(Value v) {
    const Inst& inst = kernel_.at(v);
    const auto type = [&](Value x) { return kernel_.at(x).type; };
    const auto& first = yielded(kernel_, inst.region[0]);
    const auto same_types = [&](const std::vector<Value>& a, const std::vector<Value>& b, size_t skip) {
      if (a.size() != b.size() + skip) return false;
      for (size_t i = 0; i < b.size(); ++i) {
        if (type(a[i + skip]) != type(b[i])) return false;
      }
      return true;
    };
    if (inst.op == Op::kIf) {
      return same_types(first, yielded(kernel_, inst.region[1]), 0) ? true : fail(v, "its regions yield different types");
    }
    if (first.empty() || type(first[0]) != Type::kB1) return fail(v, "must yield b1 first");
    return same_types(first, kernel_.lists[inst.list], 1) ? true : fail(v, "must yield the types of its initial values");
  }

  bool result(Value v, RegionId id, size_t index) {
    const Inst& inst = kernel_.at(v);
    const Inst& owner = kernel_.at(inst.operand[0]);
    const auto& insts = kernel_.regions[id].insts;
    size_t at = index;
    while (at > 0 && kernel_.at(insts[at - 1]).op == Op::kResult) --at;
    if (at == 0 || insts[at - 1] != inst.operand[0]) return fail(v, "must follow its if or loop");
    const uint64_t skip = owner.op == Op::kLoop ? 1 : 0;
    const auto& values = yielded(kernel_, owner.region[0]);
    if (inst.imm >= values.size() - skip) return fail(v, "no such result");
    return kernel_.at(values[inst.imm + skip]).type == inst.type ? true : fail(v, "has not the type of what is yielded");
  }

  const Kernel& kernel_;
  std::vector<bool> visible_, placed_, used_;
  uint64_t local_bytes_ = 0;
  std::string fault_;
};

}  // namespace

std::string verify(const Kernel& kernel) { return Verifier(kernel).run(); }

}  // namespace pineda::ir
