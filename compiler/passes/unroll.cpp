// Loops that count up to a constant become straight code: what their turns have in common (coordinates of neighbouring samples,
// rows of an image) then meets in cse, and counters fold away. A loop is unrolled when walking through it with nothing but the
// constants known tells after how many turns all its lanes leave, and when its copies stay short.
#include <algorithm>
#include <optional>
#include <unordered_map>

#include "base/abi.h"
#include "compiler/ir/ranges.h"
#include "compiler/ir/semantics.h"
#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Value;

constexpr uint32_t kMaxTurns = 17;  // 16, and the one that finds the end
// Of all copies together, of what the walk does not decide. Loops that sample images inline stand in kernels that are compiled in
// the background, and their copies share the most; others must not make an application wait for its pipelines.
constexpr uint32_t kMaxInsts = 128, kMaxSamplingInsts = 4000;

// Something about some values. forget() takes no longer than setting did, so that a kernel of many loops takes linear time.
template <typename T>
class Notes {
 public:
  const T& get(Value v) const {
    static const T kNothing{};
    return v.id < notes_.size() ? notes_[v.id] : kNothing;
  }
  void set(Value v, T note) {
    if (v.id >= notes_.size()) notes_.resize(v.id + v.id / 2 + 1);
    notes_[v.id] = note;
    set_.push_back(v.id);
  }
  void forget() {
    for (const uint32_t id : set_) notes_[id] = {};
    set_.clear();
  }

 private:
  std::vector<T> notes_;  // by value
  std::vector<uint32_t> set_;
};

// Integers and B1 that are the same for all lanes and do not depend on what the kernel reads.
class KnownValues {
 public:
  explicit KnownValues(const ir::Kernel& kernel) : kernel_(kernel) {}

  std::optional<uint64_t> get(Value v) const {
    const Inst& inst = kernel_.at(v);
    if (inst.op == Op::kConst && !ir::is_float(inst.type)) return ir::const_raw(inst.type, inst.imm, ir::Floats::kNative);
    return known_.get(v);
  }
  void set(Value v, std::optional<uint64_t> raw) { known_.set(v, raw); }
  void forget() { known_.forget(); }

  // Walks through a region. What depends on an If that is not decided stays unknown. Gives how many instructions would be left of
  // a copy.
  uint32_t walk(RegionId id) {
    uint32_t left = 0;
    for (const Value v : kernel_.regions[id].insts) {
      const Inst& inst = kernel_.at(v);
      if (inst.op == Op::kIf) {
        const auto cond = get(inst.operand[0]);
        left += cond ? walk(inst.region[*cond != 0 ? 0 : 1])
                     : 1 + count_insts(kernel_, inst.region[0]) + count_insts(kernel_, inst.region[1]);
      } else if (inst.op == Op::kResult) {
        known_.set(v, result(inst));
      } else if (inst.op != Op::kLoopArg) {
        known_.set(v, compute(inst));
        left += counts(inst) && !known_.get(v) && !is_decided_select(inst);
      }
    }
    return left;
  }

  static bool counts(const Inst& inst) { return inst.op != Op::kConst && inst.op != Op::kYield && inst.op != Op::kResult; }

  static uint32_t count_insts(const ir::Kernel& kernel, RegionId id) {
    uint32_t count = 0;
    ir::for_each_inst(kernel, id, [&](Value v) { count += counts(kernel.at(v)); });
    return count;
  }

 private:
  bool is_decided_select(const Inst& inst) const { return inst.op == Op::kSelect && get(inst.operand[0]); }

  // As ir::upper_bound.
  uint64_t bound(Value v, uint32_t depth) const {
    constexpr uint32_t kMaxDepth = 6;
    if (depth > kMaxDepth || kernel_.at(v).type != ir::Type::kI32) return ir::kAnyU32;
    if (const auto raw = get(v)) return *raw;
    return ir::expression_bound(kernel_, kernel_.at(v), [&](Value operand) { return bound(operand, depth + 1); });
  }

  std::optional<uint64_t> result(const Inst& inst) const {
    const Inst& branch = kernel_.at(inst.operand[0]);
    if (branch.op != Op::kIf) return {};
    const auto cond = get(branch.operand[0]);
    if (!cond) return {};
    return get(ir::yielded(kernel_, branch.region[*cond != 0 ? 0 : 1])[inst.imm]);
  }

  std::optional<uint64_t> compute(const Inst& inst) const {
    if (ir::is_known_true(kernel_, inst, [&](Value v) { return bound(v, 0); })) return 1;
    if (ir::op_info(inst.op).effect != ir::Effect::kPure || !inst.operand[0] || inst.operand[3]) return {};
    if (!is_known_type(inst.type)) return {};
    const Value typed = inst.op == Op::kSelect ? inst.operand[1] : inst.operand[0];
    if (!is_known_type(kernel_.at(typed).type)) return {};
    const ir::LaneFn fn = ir::lane_fn(inst.op, inst.type, kernel_.at(typed).type, ir::Floats::kNative);
    if (fn == nullptr) return {};
    uint64_t lanes[3][kLanes] = {}, out[kLanes];
    for (uint32_t i = 0; i < 3 && inst.operand[i]; ++i) {
      const auto raw = get(inst.operand[i]);
      if (!raw) return {};
      std::fill_n(lanes[i], kLanes, *raw);
    }
    fn(out, lanes[0], lanes[1], lanes[2]);
    return out[0];
  }

  static bool is_known_type(ir::Type type) { return ir::is_int(type) || type == ir::Type::kB1; }

  const ir::Kernel& kernel_;
  Notes<std::optional<uint64_t>> known_;
};

class Unroller {
 public:
  explicit Unroller(ir::Kernel& kernel) : kernel_(kernel), aliases_(kernel), known_(kernel) {}

  bool run() {
    region(kernel_.wave);
    return changed_;
  }

 private:
  void region(RegionId id) {
    const std::vector<Value> old = std::move(kernel_.regions[id].insts);
    std::vector<Value> out;
    out.reserve(old.size());
    for (const Value v : old) {
      aliases_.apply(kernel_, v);
      const Inst inst = kernel_.at(v);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) region(inst.region[r]);
      if (inst.op == Op::kResult && kernel_.at(inst.operand[0]).op == Op::kLoop && next_of(inst.operand[0]) != nullptr) {
        aliases_.set(v, (*next_of(inst.operand[0]))[inst.imm]);
      } else if (const uint32_t turns = inst.op == Op::kLoop ? count_turns(inst) : 0; turns != 0) {
        unroll(v, turns, out);
      } else {
        out.push_back(v);
      }
    }
    kernel_.regions[id].insts = std::move(out);
  }

  // The carried values after the last turn; null: the loop stays.
  const std::vector<Value>* next_of(Value loop) const {
    const auto found = unrolled_.find(loop.id);
    return found == unrolled_.end() ? nullptr : &found->second;
  }

  std::vector<Value> args_of(const Inst& loop) const {
    const std::vector<Value>& body = kernel_.regions[loop.region[0]].insts;
    return {body.begin(), body.begin() + static_cast<ptrdiff_t>(kernel_.lists[loop.list].size())};
  }

  // 0: the loop stays.
  uint32_t count_turns(const Inst& loop) {
    bool fits = true, samples = false;
    ir::for_each_inst(kernel_, loop.region[0], [&](Value v) {
      const Inst& inst = kernel_.at(v);
      fits &= inst.op != Op::kBarrier && inst.op != Op::kCall && inst.op != Op::kLoop && inst.op != Op::kLocal;
      // Texels are read at bounded offsets, without a limit.
      samples |=
          inst.op == Op::kLoad && (inst.flags & (ir::kInvariant | ir::kSpeculate)) == ir::kInvariant && !ir::limit_of(inst);
    });
    const uint32_t most = samples ? kMaxSamplingInsts : kMaxInsts;
    if (!fits || KnownValues::count_insts(kernel_, loop.region[0]) > most) return 0;
    const std::vector<Value> args = args_of(loop);
    const std::vector<Value>& next = ir::yielded(kernel_, loop.region[0]);
    known_.forget();
    for (size_t k = 0; k < args.size(); ++k) known_.set(args[k], known_.get(kernel_.lists[loop.list][k]));
    uint32_t insts = 0;
    for (uint32_t turn = 1; turn <= kMaxTurns; ++turn) {
      insts += known_.walk(loop.region[0]);
      if (insts > most) return 0;
      const auto again = known_.get(next[0]);
      if (!again) return 0;
      if (*again == 0) return turn;
      std::vector<std::optional<uint64_t>> values;
      for (size_t k = 0; k < args.size(); ++k) values.push_back(known_.get(next[k + 1]));
      for (size_t k = 0; k < args.size(); ++k) known_.set(args[k], values[k]);
    }
    return 0;
  }

  void unroll(Value v, uint32_t turns, std::vector<Value>& out) {
    const Inst loop = kernel_.at(v);
    const std::vector<Value> args = args_of(loop);
    std::vector<Value> carried = kernel_.lists[loop.list];
    for (uint32_t turn = 0; turn < turns; ++turn) {
      copy_of_.forget();
      for (size_t k = 0; k < args.size(); ++k) copy_of_.set(args[k], carried[k]);
      const std::vector<Value> yielded = copy_insts(loop.region[0], args.size(), out);
      carried.assign(yielded.begin() + 1, yielded.end());
    }
    unrolled_.emplace(v.id, carried);
    changed_ = true;
  }

  // Copies the instructions of a region from number `first` on, but for its Yield. Returns what that yields.
  std::vector<Value> copy_insts(RegionId id, size_t first, std::vector<Value>& out) {
    const std::vector<Value> insts = kernel_.regions[id].insts;
    for (size_t i = first; i + 1 < insts.size(); ++i) out.push_back(copy(insts[i]));
    std::vector<Value> yielded = kernel_.lists[kernel_.at(insts.back()).list];
    for (Value& value : yielded) value = mapped(value);
    return yielded;
  }

  Value copy(Value v) {
    Inst inst = kernel_.at(v);
    for (Value& operand : inst.operand) operand = mapped(operand);
    for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) inst.region[r] = copy_region(inst.region[r]);
    const Value to = add_inst(kernel_, inst);
    copy_of_.set(v, to);
    return to;
  }

  RegionId copy_region(RegionId id) {
    std::vector<Value> insts;
    std::vector<Value> yielded = copy_insts(id, 0, insts);
    Inst yield = kernel_.at(kernel_.regions[id].insts.back());
    kernel_.lists.push_back(std::move(yielded));
    yield.list = static_cast<uint32_t>(kernel_.lists.size() - 1);
    insts.push_back(add_inst(kernel_, yield));
    kernel_.regions.push_back({std::move(insts)});
    return static_cast<RegionId>(kernel_.regions.size() - 1);
  }

  Value mapped(Value v) const {
    const Value copy = copy_of_.get(v);
    return copy ? copy : v;
  }

  ir::Kernel& kernel_;
  Aliases aliases_;
  KnownValues known_;
  Notes<Value> copy_of_;                                       // in this turn
  std::unordered_map<uint32_t, std::vector<Value>> unrolled_;  // by loop: the carried values after the last turn
  bool changed_ = false;
};

}  // namespace

bool unroll(ir::Kernel& k) { return Unroller(k).run(); }

}  // namespace pineda::passes
