// Addresses that grow by one element from lane to lane become one vector access behind one scalar comparison. Of
//
//     v = load base, offset limit (index <= most ? limit : 0)          offset = index * scale + constant, index = first + lane *
//     step
//
// this makes
//
//     near = first < room                                              all lanes are in bounds, and nothing wraps at 2^32
//     v = if near { load base, offset of lane 0 stride 4 } else { the same access lane by lane, checked as before }
//
// where `room` depends on the limit alone and so is computed once for a draw. What the ranges of the operands tell is not
// compared (ir/ranges.h); what the Ifs and Loops around tell the back end knows (jit/emit_bounds.cpp): there the whole If falls
// away.
#include <bit>
#include <optional>
#include <unordered_map>

#include "base/abi.h"
#include "compiler/ir/ranges.h"
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
constexpr uint32_t kMaxStep = 1 << 16;  // between lanes, of what guards a limit: 15 of them are far from 2^32

class Rewriter {
 public:
  explicit Rewriter(ir::Kernel& kernel) : kernel_(kernel) {}

  bool run() {
    region(kernel_.wave);
    return changed_;
  }

 private:
  using Insts = std::vector<Value>;

  void region(RegionId id) {
    const Insts old = std::move(kernel_.regions[id].insts);
    Insts out;
    out.reserve(old.size());
    for (Value v : old) {
      out_ = &out;
      if (ir::is_memory(kernel_.at(v).op) && access(v)) continue;
      out.push_back(v);
      const Inst inst = kernel_.at(v);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) region(inst.region[r]);
    }
    kernel_.regions[id].insts = std::move(out);
  }

  // ---- values by lane -----------------------------------------------------------------------------------------------------

  bool varies(Value v) const { return v && kernel_.at(v).rate == Rate::kLane; }

  std::optional<uint32_t> constant(Value v) const {
    const Inst& inst = kernel_.at(v);
    return inst.op == Op::kConst ? std::optional(static_cast<uint32_t>(inst.imm)) : std::nullopt;
  }

  // By which a value grows from lane to lane; none when that is not one number.
  std::optional<uint32_t> step(Value v, int depth = 0) const {
    if (!varies(v)) return 0;
    const Inst& inst = kernel_.at(v);
    if (depth > kMaxDepth || inst.type != Type::kI32) return {};
    const auto of = [&](uint32_t i) { return step(inst.operand[i], depth + 1); };
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
          const auto k = constant(inst.operand[i]), a = k ? of(1 - i) : std::nullopt;
          if (a) return *a * *k;
        }
        return {};
      case Op::kShl: {
        const auto k = constant(inst.operand[1]), a = k ? of(0) : std::nullopt;
        return a ? std::optional(*a << (*k & 31)) : std::nullopt;
      }
      default:
        return {};
    }
  }

  // The value at lane 0, of what has a step. New instructions go in front of the access: what `v` was made of is visible wherever
  // `v` is.
  Value first_lane(Value v) {
    if (!varies(v)) return v;
    if (const auto known = first_.find(v.id); known != first_.end()) return known->second;
    const Value made = make_first_lane(v);
    first_.emplace(v.id, made);
    return made;
  }

  Value make_first_lane(Value v) {
    const Inst inst = kernel_.at(v);
    if (inst.op == Op::kLane) return i32(0);
    const Value a = first_lane(inst.operand[0]), b = first_lane(inst.operand[1]);
    const auto is_zero = [&](Value x) { return constant(x) == 0u; };
    if (is_zero(b) && inst.op != Op::kIMul) return a;
    if (is_zero(a) && inst.op != Op::kISub) return inst.op == Op::kIAdd ? b : a;
    return append({.op = inst.op, .type = Type::kI32, .rate = Rate::kWave, .operand = {a, b}});
  }

  // first + lane * step: what a value with a step is, made of what does not vary.
  Value by_lane(Value first, uint32_t step) {
    if (step == 0) return first;
    Value lane = append({.op = Op::kLane, .type = Type::kI32});
    if (step != 1) lane = append({.op = Op::kIMul, .type = Type::kI32, .operand = {lane, i32(step)}});
    return append({.op = Op::kIAdd, .type = Type::kI32, .operand = {first, lane}});
  }

  // ---- guards -------------------------------------------------------------------------------------------------------------

  // A condition that the translator puts on an access: left <= right. `right` is a constant, or a sum with `left` as one part:
  // the sum does not wrap (spirv/pointer.cpp).
  struct Guard {
    Value left, right;
    uint32_t left_step = 0, right_step = 0;
  };

  // The limit without its guards; none when they are of another kind.
  std::optional<Value> strip_guards(Value limit, std::vector<Guard>& guards) const {
    while (limit && ir::is_guarded_limit(kernel_.at(limit), kernel_)) {
      if (!add_guards(kernel_.at(limit).operand[0], guards)) return {};
      limit = kernel_.at(limit).operand[1];
    }
    return varies(limit) ? std::nullopt : std::optional(limit);
  }

  bool add_guards(Value condition, std::vector<Guard>& guards) const {
    const Inst& inst = kernel_.at(condition);
    if (inst.op == Op::kAnd) return add_guards(inst.operand[0], guards) && add_guards(inst.operand[1], guards);
    if (inst.op != Op::kULe || kernel_.at(inst.operand[0]).type != Type::kI32) return false;
    const Guard guard{inst.operand[0], inst.operand[1]};
    const Inst& right = kernel_.at(guard.right);
    const bool is_sum = right.op == Op::kIAdd && (right.operand[0] == guard.left || right.operand[1] == guard.left);
    const auto left_step = step(guard.left), right_step = step(guard.right);
    if (!left_step || !right_step || *left_step > kMaxStep || *right_step > kMaxStep) return false;
    if (right.op != Op::kConst && (!is_sum || *right_step < *left_step)) return false;
    guards.push_back({guard.left, guard.right, *left_step, *right_step});
    return true;
  }

  // ---- accesses -----------------------------------------------------------------------------------------------------------

  // offset = index * scale + constant, scale being a power of two
  struct Offset {
    Value whole, product, index;  // product = index * scale
    uint32_t log2_scale = 0, constant = 0;
  };

  Offset decompose(Value whole, uint32_t size_bytes) const {
    Offset out{.whole = whole, .product = whole, .index = whole};
    const Inst& sum = kernel_.at(whole);
    if (sum.op == Op::kIAdd && constant(sum.operand[1])) {
      out.product = sum.operand[0];
      out.constant = *constant(sum.operand[1]);
    }
    const Inst& product = kernel_.at(out.product);
    const auto factor = product.op == Op::kIMul || product.op == Op::kShl ? constant(product.operand[1]) : std::nullopt;
    const uint32_t scale = !factor ? 0 : product.op == Op::kIMul ? *factor : 1u << (*factor & 31);
    if (!std::has_single_bit(scale) || scale > size_bytes) return {.whole = whole, .product = whole, .index = whole};
    out.index = product.operand[0];
    out.log2_scale = static_cast<uint32_t>(std::countr_zero(scale));
    return out;
  }

  // Whether it was rewritten.
  bool access(Value v) {
    const Inst inst = kernel_.at(v);
    if (inst.op == Op::kAtomic || inst.lane_stride() != 0 || !varies(inst.operand[1]) || varies(inst.operand[0])) return false;
    const uint32_t size_bytes = ir::size_bytes(inst.op == Op::kStore ? kernel_.at(inst.operand[2]).type : inst.type);
    if (step(inst.operand[1]) != size_bytes) return false;
    std::vector<Guard> guards;
    const std::optional<Value> limit = strip_guards(ir::limit_of(inst), guards);
    if (!limit) return false;
    first_.clear();
    const std::optional<Value> near = near_condition(decompose(inst.operand[1], size_bytes), size_bytes, guards, *limit);
    if (!near) return false;
    changed_ = true;
    const Inst whole = vector_access(inst, size_bytes);
    if (!*near) {
      kernel_.at(v) = whole;
      out_->push_back(v);
    } else {
      branch(v, *near, whole, inst, *limit, guards);
    }
    return true;
  }

  Inst vector_access(const Inst& inst, uint32_t size_bytes) {
    Inst out = inst;
    out.operand[1] = first_lane(inst.operand[1]);
    out.operand[ir::limit_index(inst.op)] = {};
    out.imm = static_cast<uint64_t>(size_bytes) << 32;
    return out;
  }

  // B1 of wave rate: all lanes are in bounds and nothing wraps. A none Value: known; nothing: cannot be told.
  std::optional<Value> near_condition(const Offset& offset, uint32_t size_bytes, const std::vector<Guard>& guards, Value limit) {
    constexpr uint64_t kLast = ir::kAnyU32;
    const uint64_t scale = uint64_t{1} << offset.log2_scale;
    // In exact arithmetic the access ends at index * scale + constant + 16 * size; that is at most the limit when
    //     index < (limit - rest) / scale,  rest = constant + 16 * size - scale, for limit >= rest
    const uint64_t rest = offset.constant + uint64_t{kLanes} * size_bytes - scale;
    if (rest > kLast) return {};
    Value near;
    const auto require = [&](Value condition) { near = near ? append(b1(Op::kAnd, near, condition)) : condition; };
    const Value index = first_lane(offset.index);
    const auto most = limit ? constant(limit) : std::optional<uint32_t>(kLast);
    const uint64_t room = most && *most > rest ? (*most - rest) >> offset.log2_scale : 0;
    if (!most || ir::upper_bound(kernel_, index) >= room)
      require(append(b1(Op::kULt, index, most ? i32(room) : room_of(limit, rest, offset))));
    for (const Guard& guard : guards) {
      if (is_implied(guard, offset, size_bytes)) continue;
      const uint64_t left = uint64_t{kLanes - 1} * guard.left_step, right = uint64_t{kLanes - 1} * guard.right_step;
      const Value first = first_lane(guard.left);
      if (const auto bound = constant(guard.right)) {
        if (*bound < left) return {};
        if (ir::upper_bound(kernel_, first) > *bound - left) require(append(b1(Op::kULe, first, i32(*bound - left))));
        continue;
      }
      const Inst sum = kernel_.at(guard.right);
      const Value parts[] = {first_lane(sum.operand[0]), first_lane(sum.operand[1])};
      if (ir::upper_bound(kernel_, parts[0]) + ir::upper_bound(kernel_, parts[1]) + right <= kLast) continue;
      const Value total = first_lane(guard.right);
      require(append(b1(Op::kULe, first, total)));
      if (ir::upper_bound(kernel_, total) + right > kLast) require(append(b1(Op::kULe, total, i32(kLast - right))));
    }
    return near;
  }

  // What index < room implies: that neither the product nor its sum with the constant wraps, in any lane.
  bool is_implied(const Guard& guard, const Offset& offset, uint32_t size_bytes) const {
    const auto bound = constant(guard.right);
    if (!bound) return false;
    if (guard.left == offset.index && *bound >= ir::kAnyU32 >> offset.log2_scale) return true;
    return guard.left == offset.product && uint64_t{*bound} + offset.constant + size_bytes >= ir::kAnyU32;
  }

  // (limit -sat- rest) / scale
  Value room_of(Value limit, uint64_t rest, const Offset& offset) {
    const Value least = i32(rest);
    const auto op = [&](Op which, Value a, Value b) {
      return append({.op = which, .type = Type::kI32, .rate = kernel_.at(limit).rate, .operand = {a, b}});
    };
    const Value bytes = op(Op::kISub, op(Op::kUMax, limit, least), least);
    return offset.log2_scale == 0 ? bytes : op(Op::kLShr, bytes, i32(offset.log2_scale));
  }

  // If near { whole } else { each lane by itself }; v becomes the If of a store, or the Result of a load.
  void branch(Value v, Value near, const Inst& whole, const Inst& each, Value limit, const std::vector<Guard>& guards) {
    Insts* const outer = out_;
    Inst choice{.op = Op::kIf, .rate = Rate::kWave, .flags = ir::kLikely, .operand = {near}};
    for (uint32_t side = 0; side < 2; ++side) {
      Insts insts;
      out_ = &insts;
      const Value made = append(side == 0 ? whole : lane_by_lane(each, whole.operand[1], limit, guards));
      kernel_.lists.push_back(each.op == Op::kLoad ? Insts{made} : Insts{});
      append({.op = Op::kYield, .list = static_cast<uint32_t>(kernel_.lists.size() - 1)});
      choice.region[side] = static_cast<RegionId>(kernel_.regions.size());
      kernel_.regions.push_back({std::move(insts)});
    }
    out_ = outer;
    if (each.op == Op::kLoad) {
      kernel_.at(v) = {.op = Op::kResult, .type = each.type, .operand = {append(choice)}};
    } else {
      kernel_.at(v) = choice;
    }
    out_->push_back(v);
  }

  Inst lane_by_lane(const Inst& access, Value first_offset, Value limit, const std::vector<Guard>& guards) {
    Inst out = access;
    const Type type = access.op == Op::kStore ? kernel_.at(access.operand[2]).type : access.type;
    out.operand[1] = by_lane(first_offset, ir::size_bytes(type));
    if (!limit) return out;
    Value holds;
    for (const Guard& guard : guards) {
      // The first lanes stand in front of the If already where near_condition() needed them.
      const Value left = by_lane(first_lane(guard.left), guard.left_step),
                  right = by_lane(first_lane(guard.right), guard.right_step);
      const Value one = append(b1(Op::kULe, left, right));
      holds = holds ? append(b1(Op::kAnd, holds, one)) : one;
    }
    Value checked = limit;
    if (holds) checked = append({.op = Op::kSelect, .type = Type::kI32, .operand = {holds, limit, i32(0)}});
    out.operand[ir::limit_index(access.op)] = checked;
    return out;
  }

  // ---- instructions -------------------------------------------------------------------------------------------------------

  static Inst b1(Op op, Value a, Value b) { return {.op = op, .type = Type::kB1, .rate = Rate::kWave, .operand = {a, b}}; }

  Value i32(uint64_t value) { return append({.op = Op::kConst, .type = Type::kI32, .rate = Rate::kDraw, .imm = value}); }

  Value append(const Inst& inst) {
    const Value v = add_inst(kernel_, inst);
    out_->push_back(v);
    return v;
  }

  ir::Kernel& kernel_;
  Insts* out_ = nullptr;
  std::unordered_map<uint32_t, Value> first_;  // of the access at hand
  bool changed_ = false;
};

}  // namespace

bool consecutive_accesses(ir::Kernel& k) { return Rewriter(k).run(); }

}  // namespace pineda::passes
