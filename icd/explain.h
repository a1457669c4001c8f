// PINEDA_DEBUG=explain: what was left out of each pipeline and each render pass, and why, in words and numbers. Printed to
// stderr, or appended to explain.txt in PINEDA_DEBUG_DIR; what is said once is not said again, so an application that draws the
// same frame a thousand times explains it once.
#pragma once

#include <string>

#include "compiler/explain.h"
#include "raster/raster.h"

namespace pineda::icd {

// `name`: with the quotation mark that ends it, and what form of the pipeline it is.
std::string explain_pipeline(const std::string& name, const spirv::ModuleInfo& vertex, const spirv::ModuleInfo* fragment,
                             const compiler::FragmentState& state, const compiler::GraphicsKernels& kernels,
                             const compiler::GraphicsSizes& sizes);
std::string explain_pass(const raster::PassDesc& pass, const raster::PassStatistics& statistics);

void say_once(const std::string& text);

}  // namespace pineda::icd
