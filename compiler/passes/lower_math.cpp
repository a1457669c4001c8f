// Empty until the polynomials land; the f32 evaluator and the JIT report a transcendental that was not lowered.
#include "compiler/passes/passes.h"

namespace pineda::passes {

void lower_math(ir::Kernel&) {}

}  // namespace pineda::passes
