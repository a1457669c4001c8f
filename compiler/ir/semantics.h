// What every pure operation of ops.inc computes: the one definition that passes/fold and the evaluator share, and that the JIT is
// tested against.
//
// A value of a lane is 64 raw bits: integers zero-extended, B1 as 0 or 1, floats as Floats says. Float operations need the
// default floating-point environment (base/float_environment.h).
#pragma once

#include <cstdint>

#include "compiler/ir/ir.h"

namespace pineda::ir {

// How raw bits hold floats.
enum class Floats : uint8_t {
  kNative,  // the type's own IEEE format; every operation rounds to it
  kDouble,  // F16 and F32 are doubles and round only where bits become visible: memory, Bitcast, FConvert to F16
};

// Computes kLanes lanes. Operands that the operation does not have are ignored. `out` may be one of the operands.
using LaneFn = void (*)(uint64_t* out, const uint64_t* a, const uint64_t* b, const uint64_t* c);

// Null for operations that are not lane-wise (sources, memory, control, Ballot, QuadSwizzle), and in kNative for transcendentals,
// which passes/lower_math must have replaced. `operand` is the type of operand 0 (of operand 1 for Select).
LaneFn lane_fn(Op op, Type result, Type operand, Floats floats);

// Raw bits of a Const's imm, and the imm of a Const that gives these raw bits. NaNs become the canonical one.
uint64_t const_raw(Type type, uint64_t imm, Floats floats);
uint64_t const_imm(Type type, uint64_t raw, Floats floats);

// imm of the Const that Reduce gives to inactive lanes, and to the first lane of an exclusive scan.
uint64_t reduce_identity(ReduceOp op, Type type, bool first_of_exclusive);

// Raw bits <-> the bits that memory holds. NaN payloads survive both ways.
uint64_t memory_raw(Type type, uint64_t bits, Floats floats);
uint64_t raw_memory(Type type, uint64_t raw, Floats floats);

// IEEE binary16, rounded to nearest even. A NaN keeps sign and upper payload bits.
uint16_t half_from_double(double v);
double double_from_half(uint16_t bits);

}  // namespace pineda::ir
