// Builders of whole kernels: vertex (fetch -> shader -> clip position and varyings), fragment (interpolation -> depth test ->
// shader -> blend -> pack) and compute. They produce unoptimised IR; compile.cpp runs the passes.
#pragma once

#include <functional>

#include "compiler/compile.h"

namespace pineda::kernels {

// What a builder needs of a shader: what it declares, and its code. Tests write the code in C++; shader_of() takes it from
// SPIR-V.
struct Shader {
  spirv::ModuleInfo info;
  std::function<Result<spirv::Translation>(ir::Builder&, spirv::StageInterface&)> body;
};
Shader shader_of(const spirv::Module& module);  // keeps a reference

struct FragmentKernel {
  ir::Kernel ir;  // varyings are in provisional slots
  spirv::DepthMode late_depth = spirv::DepthMode::kAny;
  bool early_depth = true, reads_color = false, opaque = false, has_side_effects = false, per_sample = false;
};

// Pipeline state apart from the shader modules: `source.vertex` and `source.fragment` are not looked at. A null shader: depth
// only.
Result<FragmentKernel> build_fragment(const compiler::GraphicsSource& source, const Shader* shader);
Result<ir::Kernel> build_vertex(const compiler::GraphicsSource& source, const Shader& shader,
                                std::span<const compiler::VaryingSlot> varyings);
Result<ir::Kernel> build_compute(const compiler::ComputeSource& source, const Shader& shader);

// Resolves ThreadContext::color[0] (blocks of `samples` samples) to color[1] (blocks of one), for each FragmentWave.
Result<ir::Kernel> build_resolve(VkFormat format, uint32_t samples, VkResolveModeFlagBits mode);

// After the passes: renumbers the varyings that a fragment kernel still reads (its loads through FragmentPrim::vertex) to slots
// 4, 5, ... and tells which they are: slot 4 + i of the vertex record holds the i-th. Before, the slot is provisional_slot().
std::vector<compiler::VaryingSlot> compact_varyings(ir::Kernel& kernel);
constexpr uint32_t provisional_slot(uint32_t location, uint32_t component) { return 4 + location * 4 + component; }
// Built-in outputs of the vertex stage that are kept in the record have locations behind all others; none for those that are
// not. An element is a component, eight of them two locations.
std::optional<compiler::VaryingSlot> built_in_slot(spirv::BuiltIn built_in, uint32_t element);

// Appends the built-in outputs of a vertex shader that geometry needs, and tells where they are.
VertexOutputs add_vertex_outputs(const spirv::ModuleInfo& vertex, bool draws_points,
                                 std::vector<compiler::VaryingSlot>& varyings);

}  // namespace pineda::kernels
