#include "compiler/explain.h"

#include "base/deep_stack.h"
#include "compiler/explain_walk.h"
#include "compiler/kernels/kernels.h"
#include "compiler/passes/passes.h"

namespace pineda::compiler {
namespace {

struct Counts {
  uint32_t instructions = 0, loads = 0, stores = 0;
};

Counts count(const ir::Kernel& kernel, ir::RegionId region) {
  Counts counts;
  if (region == 0) return counts;
  for_each_likely(kernel, region, false, [&](const ir::Inst& inst, bool) {
    ++counts.instructions;
    counts.loads += inst.op == ir::Op::kLoad;
    counts.stores += inst.op == ir::Op::kStore;
  });
  return counts;
}

// Optimises the kernel. The form of the truth has every pass but those that replace functions by polynomials, which would drown
// what was left out in what they add.
KernelSizes measure(ir::Kernel& kernel) {
  KernelSizes sizes;
  with_deep_stack([&] {
    for (const ir::RegionId root : {kernel.draw, kernel.prim, kernel.wave}) {
      const Counts counts = count(kernel, root);
      sizes.built += counts.instructions;
      sizes.built_loads += counts.loads;
      sizes.built_stores += counts.stores;
    }
    passes::optimize(kernel, passes::Form::kTruth);
    const Counts wave = count(kernel, kernel.wave);
    sizes.per_draw = count(kernel, kernel.draw).instructions;
    sizes.per_primitive = count(kernel, kernel.prim).instructions;
    sizes.kept = sizes.per_draw + sizes.per_primitive + wave.instructions;
    sizes.loads = wave.loads;
    sizes.stores = wave.stores;
  });
  return sizes;
}

}  // namespace

Result<GraphicsSizes> measure_graphics(const GraphicsSource& source) {
  GraphicsSizes sizes;
  kernels::Shader fragment_shader;
  if (source.fragment) fragment_shader = kernels::shader_of(*source.fragment);
  Result<kernels::FragmentKernel> fragment = kernels::build_fragment(source, source.fragment ? &fragment_shader : nullptr);
  if (!fragment) return std::unexpected(fragment.error());
  sizes.fragment = measure(fragment->ir);
  sizes.varyings = kernels::compact_varyings(fragment->ir);
  std::vector<VaryingSlot> outputs = sizes.varyings;
  const kernels::Shader vertex_shader = kernels::shader_of(*source.vertex);
  kernels::add_vertex_outputs(vertex_shader.info, source.draws_points, outputs);
  Result<ir::Kernel> vertex = kernels::build_vertex(source, vertex_shader, outputs);
  if (!vertex) return std::unexpected(vertex.error());
  sizes.vertex = measure(*vertex);
  return sizes;
}

}  // namespace pineda::compiler
