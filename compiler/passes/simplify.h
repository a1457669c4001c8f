// Identities of single instructions, for passes/fold. Every one keeps all bits; where an operand may be a NaN, ir.h leaves the
// payload of the result open.
#pragma once

#include <optional>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/ir/semantics.h"

namespace pineda::passes {

// What a rule found: a value that the instruction equals, a change of the instruction, or nothing.
struct Outcome {
  ir::Value value;
  bool changed;
};

class Simplifier {
 public:
  Simplifier(ir::Kernel& kernel, ir::Floats floats) : kernel_(kernel), floats_(floats) {}

  // Looks at one instruction whose operands are final. Gives the value that it equals, or none after perhaps changing `inst` into
  // something simpler. New constants and instructions are appended to the kernel and to `before`; they belong in front of it.
  ir::Value simplify(ir::Inst& inst, std::vector<ir::Value>& before);

 private:
  static constexpr Outcome kNothing{{}, false};
  static Outcome is(ir::Value v) { return {v, false}; }
  Outcome is_const(ir::Type type, uint64_t imm) { return {constant(type, imm), false}; }
  static Outcome become(ir::Inst& inst, ir::Op op, std::initializer_list<ir::Value> operands);

  ir::Value constant(ir::Type type, uint64_t imm);  // integers and B1
  ir::Value float_constant(ir::Type type, double v);
  ir::Value negate(ir::Value v);
  ir::Value emit(const ir::Inst& inst);
  const ir::Inst& def(ir::Value v) const { return kernel_.at(v); }
  ir::Type type(ir::Value v) const { return kernel_.at(v).type; }
  // The value of an integer or B1 constant, of a float constant.
  std::optional<uint64_t> imm(ir::Value v) const;
  std::optional<double> number(ir::Value v) const;
  bool is_imm(ir::Value v, uint64_t bits) const { return imm(v) == bits; }

  bool rounds(ir::Value x, ir::Type through) const;

  Outcome rule(ir::Inst& inst);
  Outcome constants(const ir::Inst& inst);
  Outcome integer(ir::Inst& inst);
  Outcome add(ir::Inst& inst);
  Outcome logic(ir::Inst& inst);
  Outcome logic_not(ir::Inst& inst);
  Outcome shift(ir::Inst& inst);
  Outcome compare(ir::Inst& inst);
  Outcome compare_with_const(ir::Inst& inst);
  Outcome floating(ir::Inst& inst);
  Outcome divide(ir::Inst& inst);
  Outcome conversion(ir::Inst& inst);
  Outcome select(ir::Inst& inst);
  Outcome memory(ir::Inst& inst);

  ir::Kernel& kernel_;
  ir::Floats floats_;
  std::vector<ir::Value>* before_ = nullptr;
};

}  // namespace pineda::passes
