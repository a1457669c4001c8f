// What the compiler left out of a pipeline's kernels, counted: for PINEDA_DEBUG=explain (icd/explain.h says it in words).
#pragma once

#include "compiler/compile.h"

namespace pineda::compiler {

struct KernelSizes {      // in IR instructions, transcendental functions as one each
  uint32_t built = 0;     // as the shader and the pipeline's state spell it out
  uint32_t kept = 0;      // after all passes
  uint32_t per_draw = 0;  // of those, done once for a draw ...
  uint32_t per_primitive = 0;
  uint32_t stores = 0, loads = 0;              // in the part for each wave
  uint32_t built_stores = 0, built_loads = 0;  // the same before the passes
};

struct GraphicsSizes {
  KernelSizes vertex, fragment;
  std::vector<VaryingSlot> varyings;  // that the fragment kernel reads
};

// Builds the kernels once more and counts; no machine code is made.
Result<GraphicsSizes> measure_graphics(const GraphicsSource& source);

}  // namespace pineda::compiler
