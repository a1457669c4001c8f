#include "compiler/compile.h"

#include <algorithm>

#include "base/config.h"
#include "base/parallel_for.h"
#include "compiler/code_store.h"
#include "compiler/kernel_cache.h"
#include "compiler/kernels/kernels.h"

namespace pineda::compiler {
namespace {

Result<void> finish(Executable& executable, CodeStore* store) {
  if (Result<void> done = executable.finish(); !done) return done;
  if (CodeBlob blob = store ? executable.blob() : nullptr) store->insert(executable.key, blob);
  return {};
}

// Has a generator run the back end. What can fail in an application's hands fails now.
Result<void> start(const ExecutablePtr& executable, CodeStore* store, const CodeGenerator& generator) {
  if (executable->is_finished()) return finish(*executable, store);
  if (Result<void> available = back_end_available(); !available) return available;
  if (store) store->insert_when_finished(executable);
  generator(executable);
  return {};
}

// Both back ends at once: generating machine code takes more than nine tenths of a cold pipeline's time.
Result<void> finish_both(Executable& a, Executable& b, CodeStore* store) {
  Result<void> done[2];
  if (a.is_finished() || b.is_finished()) {  // not worth a thread
    done[0] = finish(a, store);
    done[1] = finish(b, store);
    return done[0] ? done[1] : done[0];
  }
  parallel_for(2, [&](uint32_t i) { done[i] = finish(i == 0 ? a : b, store); });
  return done[0] ? done[1] : done[0];
}

// PINEDA_DEBUG=nounread: the vertex outputs that the fragment kernel does not read as well.
void add_unread(const spirv::ModuleInfo& vertex, std::vector<VaryingSlot>& varyings) {
  for (const spirv::InterfaceScalar& out : vertex.outputs) {
    const VaryingSlot slot{out.location, out.component};
    if (out.built_in || ir::size_bytes(out.type) != 4 || out.component > 3) continue;
    if (std::find(varyings.begin(), varyings.end(), slot) == varyings.end()) varyings.push_back(slot);
  }
}

}  // namespace

Result<GraphicsKernels> compile_graphics(const GraphicsSource& source) {
  if (!source.vertex || !source.layout) return compile_error("A graphics pipeline needs a vertex shader and a layout.");
  // The fragment kernel first: it tells which varyings are read.
  kernels::Shader fragment_shader;
  if (source.fragment) fragment_shader = kernels::shader_of(*source.fragment);
  Result<kernels::FragmentKernel> fragment = kernels::build_fragment(source, source.fragment ? &fragment_shader : nullptr);
  if (!fragment) return std::unexpected(fragment.error());
  Result<ExecutablePtr> fragment_code = cached_executable(std::move(fragment->ir), source.store);
  if (!fragment_code) return std::unexpected(fragment_code.error());
  if (source.generator) {
    if (Result<void> done = start(*fragment_code, source.store, *source.generator); !done) return std::unexpected(done.error());
  }
  std::vector<VaryingSlot> varyings = (*fragment_code)->varyings;
  const kernels::Shader vertex_shader = kernels::shader_of(*source.vertex);
  if (debug(kDebugNoUnread)) add_unread(vertex_shader.info, varyings);
  const VertexOutputs outputs = kernels::add_vertex_outputs(vertex_shader.info, source.draws_points, varyings);
  Result<ir::Kernel> vertex = kernels::build_vertex(source, vertex_shader, varyings);
  if (!vertex) return std::unexpected(vertex.error());
  Result<ExecutablePtr> vertex_code = cached_executable(std::move(*vertex), source.store);
  if (!vertex_code) return std::unexpected(vertex_code.error());
  const Result<void> done = source.generator ? start(*vertex_code, source.store, *source.generator)
                                             : finish_both(**fragment_code, **vertex_code, source.store);
  if (!done) return std::unexpected(done.error());
  return GraphicsKernels{.vertex = *vertex_code,
                         .fragment = *fragment_code,
                         .vertex_slots = static_cast<uint32_t>(4 + varyings.size()),
                         .outputs = outputs,
                         .early_depth = fragment->early_depth,
                         .late_depth = fragment->late_depth,
                         .reads_color = fragment->reads_color,
                         .opaque = fragment->opaque,
                         .has_side_effects = fragment->has_side_effects,
                         .per_sample = fragment->per_sample};
}

Result<ComputeKernel> compile_compute(const ComputeSource& source) {
  if (!source.module || !source.layout) return compile_error("A compute pipeline needs a shader and a layout.");
  const kernels::Shader shader = kernels::shader_of(*source.module);
  Result<ir::Kernel> kernel = kernels::build_compute(source, shader);
  if (!kernel) return std::unexpected(kernel.error());
  Result<ExecutablePtr> code = cached_executable(std::move(*kernel), source.store);
  if (!code) return std::unexpected(code.error());
  const Result<void> done = source.generator ? start(*code, source.store, *source.generator) : finish(**code, source.store);
  if (!done) return std::unexpected(done.error());
  return ComputeKernel{*code, shader.info.local_size, shader.info.shared_memory_bytes, (*code)->frame_bytes};
}

Result<KernelPtr> compile_resolve(VkFormat format, uint32_t samples, VkResolveModeFlagBits mode) {
  Result<ir::Kernel> kernel = kernels::build_resolve(format, samples, mode);
  if (!kernel) return std::unexpected(kernel.error());
  return compile_kernel(std::move(*kernel));
}

Result<KernelPtr> compile_kernel(ir::Kernel kernel) {
  Result<ExecutablePtr> code = cached_executable(std::move(kernel), nullptr);
  if (!code) return std::unexpected(code.error());
  if (Result<void> done = (*code)->finish(); !done) return std::unexpected(done.error());
  return *code;
}

}  // namespace pineda::compiler
