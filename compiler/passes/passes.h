// The passes over the IR, in the order in which optimize() runs them. Each leaves a kernel that verify() accepts and that computes the same bits,
// but for lower_math and fuse_fma, which *define* the bits of the f32 form.
#pragma once

#include "compiler/ir/ir.h"

namespace pineda::passes {

void ssa(ir::Kernel& k);          // one-element Locals become values, If results and loop-carried values
void lower_math(ir::Kernel& k);   // transcendentals -> polynomials (PINEDA_PRECISION); their bounds are in lower_math.h
void fold(ir::Kernel& k);         // constants and algebraic identities that hold bit for bit; constant Ifs
void cse(ir::Kernel& k);          // common subexpressions, scoped by region; invariant loads too
void fuse_fma(ir::Kernel& k);     // fadd(fmul(a, b), c) -> fma, left operand first, whatever the other uses of the product;
                                  // never across kNoContract. Context-free: depends on the expression alone.
void dce(ir::Kernel& k);          // dead instructions, unused If results and loop-carried values, empty Ifs
void rates(ir::Kernel& k);        // Inst::rate
void hoist(ir::Kernel& k);        // pure Draw/Prim-rate instructions move to Kernel::draw / prim

enum class Form : uint8_t {
  kMachine,  // for the JIT and the f32 evaluator
  kTruth,    // for the f64 evaluator: no lower_math, no fuse_fma
};
void optimize(ir::Kernel& k, Form form);

}  // namespace pineda::passes
