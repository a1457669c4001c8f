// PINEDA_DEBUG=explain: what was left out of each pipeline, render pass and dispatch, and why, in words and numbers. Printed to
// stderr, or appended to explain.txt in PINEDA_DEBUG_DIR; what is said once is not said again, so an application that draws the
// same frame a thousand times explains it once.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "compiler/explain.h"
#include "raster/raster.h"

namespace pineda::icd {

// The quotation mark that ends a pipeline's name, and which of its forms (pipeline.h) it is.
std::string form_text(bool samples, bool specialized);

// `name`: with its form.
std::string explain_pipeline(const std::string& name, const spirv::ModuleInfo& vertex, const spirv::ModuleInfo* fragment,
                             const compiler::FragmentState& state, const compiler::GraphicsKernels& kernels,
                             const compiler::GraphicsSizes& sizes);
std::string explain_pass(const raster::PassDesc& pass, const raster::PassStatistics& statistics);

// The same kernel with the values that the shader itself gives its specialisation constants.
struct Unspecialized {
  uint32_t given;  // constants that the application specialised
  compiler::ComputeSizes sizes;
};
std::string explain_compute_pipeline(const std::string& name, const spirv::ModuleInfo& info, const compiler::ComputeSizes& sizes,
                                     const std::optional<Unspecialized>& unspecialized);
std::string explain_dispatch(const std::string& name, const std::array<uint32_t, 3>& groups,
                             const std::array<uint32_t, 3>& local_size);

void say_once(const std::string& text);

}  // namespace pineda::icd
