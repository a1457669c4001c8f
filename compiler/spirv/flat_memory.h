// The memory of one Function, Private, Input or Output variable, in one of two forms. Usually each scalar is a Var, which
// passes/ssa turns into values; a dynamic index then chooses among the scalars that it can reach. Where that would be many
// (kMaxCandidates), each scalar type gets a Local array instead, indexed by the scalar's number.
#pragma once

#include <array>
#include <vector>

#include "compiler/ir/builder.h"
#include "compiler/spirv/instruction.h"

namespace pineda::spirv {

class FlatMemory {
 public:
  static constexpr uint32_t kMaxCandidates = 16;

  FlatMemory() = default;
  // `step`: Variable::dynamic_step. Makes nothing yet: the owner counts what it is about to allocate.
  FlatMemory(std::vector<ir::Type> types, uint32_t step);

  uint32_t size() const { return static_cast<uint32_t>(types_.size()); }
  ir::Type type(uint32_t scalar) const { return types_[scalar]; }
  uint32_t var_count() const { return is_array_ ? 0 : size(); }
  uint32_t array_bytes() const;  // of all arrays, for each lane
  void allocate(ir::Builder& b);

  // Scalar `at` + `index`; index unset or a multiple of the step. Indices that lead outside give some scalar of the variable or
  // zero, and store nothing or to the variable (in SPIR-V they are undefined). Fails when the type is not what is there.
  ir::Value load(ir::Builder& b, const Instruction& inst, uint32_t at, ir::Value index, ir::Type type) const;
  void store(ir::Builder& b, const Instruction& inst, uint32_t at, ir::Value index, ir::Value value) const;

 private:
  ir::Value array_of(const Instruction& inst, ir::Type type) const;
  void check(const Instruction& inst, uint32_t at, ir::Value index, ir::Type type) const;
  static constexpr uint32_t kTypes = static_cast<uint32_t>(ir::Type::kPtr) + 1;
  static uint32_t slot(ir::Type type) { return static_cast<uint32_t>(type); }

  std::vector<ir::Type> types_;  // of each scalar
  uint32_t step_ = 0;
  bool is_array_ = false;
  std::vector<ir::Var> vars_;
  std::array<ir::Value, kTypes> arrays_;  // by slot()
};

}  // namespace pineda::spirv
