// Hash-consing over the tree of regions: a value found in the same or an enclosing region stands for a later equal one.
//
// Two loads are equal when nothing can have written in between: the key of a load holds a version of memory, which every write
// and every loop whose body writes makes new. Invariant loads have version 0. Operands of commutative operations are ordered in
// the key, but not those of FAdd: fuse_fma takes the left product first, and which expression a kernel also holds must not change
// the bits.
#include <bit>
#include <unordered_map>

#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Value;

struct Key {
  uint32_t op_type_flags = 0;
  uint32_t version = 0;
  uint64_t imm = 0;
  std::array<Value, 3> operand{};
  bool operator==(const Key&) const = default;
};

struct KeyHash {
  size_t operator()(const Key& key) const {
    uint64_t h = key.imm ^ (static_cast<uint64_t>(key.op_type_flags) << 32 | key.version);
    for (Value v : key.operand) h = (std::rotl(h, 23) ^ v.id) * 0x9E3779B97F4A7C15ull;  // multiplicative (Fibonacci) hashing
    return h ^ h >> 29;
  }
};

class Eliminator {
 public:
  explicit Eliminator(ir::Kernel& kernel)
      : kernel_(kernel), aliases_(kernel), writes_(kernel.regions.size()), local_version_(kernel.insts.size()) {
    table_.reserve(kernel.insts.size());
  }

  void run() {
    for (RegionId root : {kernel_.draw, kernel_.prim, kernel_.wave}) {
      if (root == 0) continue;
      find_writes(root);
      region(root, /*scoped=*/false);
    }
  }

 private:
  struct Writes {
    bool memory = false, locals = false;
  };

  static bool writes_memory(const Inst& inst) { return writes(inst) && inst.op != Op::kLocalStore; }

  Writes find_writes(RegionId id) {
    Writes out;
    for (Value v : kernel_.regions[id].insts) {
      const Inst& inst = kernel_.at(v);
      out.memory |= writes_memory(inst);
      out.locals |= inst.op == Op::kLocalStore;
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) {
        const Writes inner = find_writes(inst.region[r]);
        out.memory |= inner.memory;
        out.locals |= inner.locals;
      }
    }
    return writes_[id] = out;
  }

  void region(RegionId id, bool scoped) {
    const size_t scope = added_.size();
    auto insts = std::move(kernel_.regions[id].insts);
    size_t kept = 0;
    for (Value v : insts) {
      aliases_.apply(kernel_, v);
      if (const Value same = find_or_add(v)) {
        aliases_.set(v, same);
        continue;
      }
      insts[kept++] = v;
      after(v);
    }
    insts.resize(kept);
    kernel_.regions[id].insts = std::move(insts);
    for (; scoped && added_.size() > scope; added_.pop_back()) table_.erase(added_.back());
  }

  // What an instruction that stays does to memory's versions.
  void after(Value v) {
    const Inst& inst = kernel_.at(v);
    if (inst.op == Op::kLocalStore) local_version_[inst.operand[0].id] = ++next_version_;
    if (writes_memory(inst)) memory_version_ = ++next_version_;
    for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) {
      const RegionId inner = inst.region[r];
      if (inst.op == Op::kLoop) renew(writes_[inner]);  // the body may see what an earlier iteration wrote
      region(inner, /*scoped=*/true);
      renew(writes_[inner]);
    }
  }

  void renew(Writes writes) {
    if (writes.memory) memory_version_ = ++next_version_;
    if (writes.locals) all_locals_version_ = ++next_version_;
  }

  Value find_or_add(Value v) {
    Key key;
    if (!make_key(kernel_.at(v), key)) return {};
    const auto [found, added] = table_.emplace(key, v);
    if (!added) return found->second;
    added_.push_back(key);
    return {};
  }

  bool make_key(const Inst& inst, Key& key) const {
    switch (inst.op) {
      case Op::kLocal:
      case Op::kLoopArg:
      case Op::kResult:
        return false;
      case Op::kLoad:
        if (inst.flags & ir::kVolatile) return false;
        if (!(inst.flags & ir::kInvariant)) key.version = memory_version_;
        break;
      case Op::kLocalLoad:
        key.version = std::max(local_version_[inst.operand[0].id], all_locals_version_);
        break;
      default:
        if (ir::op_info(inst.op).effect != ir::Effect::kPure) return false;
    }
    key.op_type_flags = static_cast<uint32_t>(inst.op) << 16 | static_cast<uint32_t>(inst.type) << 8 | inst.flags;
    key.imm = inst.imm;
    key.operand = {inst.operand[0], inst.operand[1], inst.operand[2]};
    if (ir::is_commutative(inst.op) && key.operand[0].id > key.operand[1].id) std::swap(key.operand[0], key.operand[1]);
    return true;
  }

  ir::Kernel& kernel_;
  Aliases aliases_;
  std::vector<Writes> writes_;  // by region
  std::unordered_map<Key, Value, KeyHash> table_;
  std::vector<Key> added_;  // in order, so that a region's keys can be removed at its end
  std::vector<uint32_t> local_version_;
  uint32_t memory_version_ = 1, all_locals_version_ = 1, next_version_ = 1;
};

}  // namespace

void cse(ir::Kernel& k) { Eliminator(k).run(); }

}  // namespace pineda::passes
