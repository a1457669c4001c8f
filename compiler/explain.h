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

// What each step of the passes took away of a compute kernel, in IR instructions that are no constants.
struct Removed {
  uint32_t variables = 0;    // Locals that became values
  uint32_t accesses = 0;     // LocalLoads and LocalStores that went with them
  uint32_t dead = 0;         // then: no effect depends on them
  uint32_t constant = 0;     // then: computed at compile time, from literals and specialisation
  uint32_t decided = 0;      // Ifs among them, and among the dead
  uint32_t equal = 0;        // then: another instruction has the same value
  uint32_t equal_loads = 0;  // loads among them
};

struct Branches {          // If and Loop
  uint32_t built = 0;      // as the shader spells them out
  uint32_t unrolled = 0;   // Loops of a constant number of turns, now straight code
  uint32_t flattened = 0;  // short Ifs, now selections
  uint32_t uniform = 0;    // of those left: all lanes of a wave agree, so it jumps
  uint32_t divergent = 0;  // lanes may differ: both sides run, under masks
};

// Accesses of memory that a shader might leave: those with a limit.
struct BoundsChecks {
  uint32_t built = 0;
  uint32_t known = 0;     // left of them, but constants tell that they are inside, so there is no check
  uint32_t per_draw = 0;  // checked once a dispatch or workgroup
  uint32_t per_wave = 0;  // one comparison for 16 lanes
  uint32_t per_lane = 0;  // a comparison in each lane
  uint32_t indices = 0;   // that are compared in each lane on top, as their offsets in bytes might wrap
};

struct ComputeSizes {
  KernelSizes kernel;
  Removed removed;
  Branches branches;
  BoundsChecks checks;
  uint32_t barriers = 0;
  uint32_t group_constructs = 0;  // Ifs and Loops that hold a barrier: run by the whole workgroup
  uint64_t frame_bytes = 0;       // that a wave keeps from phase to phase
};

Result<ComputeSizes> measure_compute(const ComputeSource& source);
ComputeSizes measure_compute_kernel(ir::Kernel kernel);  // as it was built

}  // namespace pineda::compiler
