// Builders of whole kernels: vertex (fetch -> shader -> clip position and varyings), fragment (interpolation -> depth test -> shader -> blend -> pack) and
// compute. They produce unoptimised IR; compile.cpp runs the passes.
#pragma once

#include "compiler/compile.h"

namespace pineda::kernels {

struct FragmentKernel {
  ir::Kernel ir;
  std::vector<compiler::VaryingSlot> varyings;  // slot 4 + i of the vertex record holds varyings[i]; only those that are read after dce
  bool early_depth = true, reads_color = false, opaque = false, has_side_effects = false;
};

Result<FragmentKernel> build_fragment(const compiler::GraphicsSource& source);
Result<ir::Kernel> build_vertex(const compiler::GraphicsSource& source, std::span<const compiler::VaryingSlot> varyings);
Result<ir::Kernel> build_compute(const compiler::ComputeSource& source);

}  // namespace pineda::kernels
