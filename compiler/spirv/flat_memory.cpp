#include "compiler/spirv/flat_memory.h"

#include <numeric>

namespace pineda::spirv {

FlatMemory::FlatMemory(std::vector<ir::Type> types, uint32_t step) : types_(std::move(types)), step_(step) {
  is_array_ = step_ != 0 && size() / step_ > kMaxCandidates;
}

uint32_t FlatMemory::array_bytes() const {
  if (!is_array_) return 0;
  std::array<uint32_t, kTypes> element_bytes{};
  for (ir::Type t : types_) element_bytes[slot(t)] = ir::size_bytes(t);
  return size() * std::accumulate(element_bytes.begin(), element_bytes.end(), 0u);
}

void FlatMemory::allocate(ir::Builder& b) {
  for (ir::Type t : types_) {
    if (!is_array_) {
      vars_.push_back(b.variable(t));
    } else if (!arrays_[slot(t)]) {
      arrays_[slot(t)] = b.local(t, size());
    }
  }
}

ir::Value FlatMemory::array_of(const Instruction& inst, ir::Type type) const {
  const ir::Value array = arrays_[slot(type)];
  if (!array) inst.fail("the pointer does not fit its variable");
  return array;
}

void FlatMemory::check(const Instruction& inst, uint32_t at, ir::Value index, ir::Type type) const {
  if (at >= size()) inst.fail("the pointer is outside its variable");
  if (types_[at] != type) inst.fail("the pointer does not fit its variable");
  if (index && step_ == 0) inst.fail("the pointer was computed before its base");
}

ir::Value FlatMemory::load(ir::Builder& b, const Instruction& inst, uint32_t at, ir::Value index, ir::Type type) const {
  check(inst, at, index, type);
  if (is_array_) return b.local_load(array_of(inst, type), index ? b.iadd(index, b.i32(at)) : b.i32(at));
  if (!index) return b.get(vars_[at]);
  uint32_t candidate = at + (size() - 1 - at) / step_ * step_;  // the last one needs no comparison
  ir::Value out = types_[candidate] == type ? b.get(vars_[candidate]) : b.zero(type);
  while (candidate > at) {
    candidate -= step_;
    if (types_[candidate] != type) continue;
    out = b.select(b.ieq(index, b.i32(candidate - at)), b.get(vars_[candidate]), out);
  }
  return out;
}

void FlatMemory::store(ir::Builder& b, const Instruction& inst, uint32_t at, ir::Value index, ir::Value value) const {
  const ir::Type type = b.type(value);
  check(inst, at, index, type);
  if (is_array_) return b.local_store(array_of(inst, type), index ? b.iadd(index, b.i32(at)) : b.i32(at), value);
  if (!index) return b.set(vars_[at], value);
  for (uint32_t candidate = at; candidate < size(); candidate += step_) {
    if (types_[candidate] != type) continue;
    b.set(vars_[candidate], b.select(b.ieq(index, b.i32(candidate - at)), value, b.get(vars_[candidate])));
  }
}

}  // namespace pineda::spirv
