// The passes over the IR; optimize() has their order. Each leaves a kernel that verify() accepts and that computes the same bits,
// but for lower_math and fuse_fma, which *define* the bits of the f32 form.
#pragma once

#include "base/config.h"
#include "compiler/ir/ir.h"

namespace pineda::passes {

enum class Form : uint8_t {
  kMachine,  // for the JIT and the f32 evaluator
  kTruth,    // for the f64 evaluator: no lower_math, no fuse_fma; fold computes as that evaluator does
};

// Locals become values, results of Ifs and carried values of Loops.
void ssa(ir::Kernel& k);

// Removes dead instructions, unused results and carried values, Ifs and Loops without effect.
void dce(ir::Kernel& k);

// fadd(fmul(a, b), c) -> fma, the left product first, whatever the other uses of the product; never across kNoContract, which all
// the rest has afterwards. Context-free: depends on the expression alone.
void fuse_fma(ir::Kernel& k);

// Constants, identities that hold bit for bit, Ifs that are decided.
void fold(ir::Kernel& k, Form form = Form::kMachine);

// Common subexpressions, scoped by region; loads too.
void cse(ir::Kernel& k);

// Short loops whose number of turns is constant become straight code, for fold and cse to follow. Whether there were any.
bool unroll(ir::Kernel& k);

// Ifs whose sides are short and pure become selects. Wants rates().
void flatten_ifs(ir::Kernel& k);

// Carried values of loops with a break become uniform where lanes that go on agree. Wants rates() and dce().
void narrow_loops(ir::Kernel& k);

// Transcendentals -> polynomials; see lower_math.h.
void lower_math(ir::Kernel& k, Precision precision = Precision::kDefault);

// Loads and stores whose addresses are consecutive from lane to lane become one access behind one comparison. Wants rates.
// Whether there were any.
bool consecutive_accesses(ir::Kernel& k);

// What depends on the draw or the primitive alone moves to Kernel::draw and Kernel::prim.
void hoist(ir::Kernel& k);

// What a Loop computes from values of before it moves in front of it.
void hoist_loops(ir::Kernel& k);

// Sets Inst::rate.
void rates(ir::Kernel& k);

// All of them. Renumbers the instructions: Values from before mean nothing afterwards. (The single passes keep them.)
void optimize(ir::Kernel& k, Form form, Precision precision = Precision::kDefault);

}  // namespace pineda::passes
