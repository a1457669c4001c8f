#include "compiler/compile.h"

#include <system_error>
#include <thread>

#include "base/blocked_signals.h"
#include "base/config.h"
#include "compiler/ir/wave_frame.h"
#include "compiler/kernel_cache.h"
#include "compiler/kernels/kernels.h"

namespace pineda::compiler {
namespace {

// Both back ends at once: generating machine code takes more than nine tenths of a cold pipeline's time.
Result<void> finish_both(Executable& a, Executable& b) {
  Result<void> b_done;
  std::thread helper;
  if (config().mode == Mode::kJit || config().mode == Mode::kCheck) {
    try {
      const BlockedSignals blocked;
      helper = std::thread([&] { b_done = b.finish(); });
    } catch (const std::system_error&) {  // no thread to be had: one after the other
    }
  }
  Result<void> a_done = a.finish();
  if (helper.joinable()) {
    helper.join();
  } else {
    b_done = b.finish();
  }
  return a_done ? b_done : a_done;
}

Result<ExecutablePtr> finished_executable(ir::Kernel kernel) {
  Result<ExecutablePtr> code = cached_executable(std::move(kernel));
  if (!code) return code;
  if (Result<void> done = (*code)->finish(); !done) return std::unexpected(done.error());
  return code;
}

}  // namespace

Result<GraphicsKernels> compile_graphics(const GraphicsSource& source) {
  if (!source.vertex || !source.layout) return compile_error("A graphics pipeline needs a vertex shader and a layout.");
  // The fragment kernel first: it tells which varyings are read.
  kernels::Shader fragment_shader;
  if (source.fragment) fragment_shader = kernels::shader_of(*source.fragment);
  Result<kernels::FragmentKernel> fragment = kernels::build_fragment(source, source.fragment ? &fragment_shader : nullptr);
  if (!fragment) return std::unexpected(fragment.error());
  Result<ExecutablePtr> fragment_code = cached_executable(std::move(fragment->ir));
  if (!fragment_code) return std::unexpected(fragment_code.error());
  std::vector<VaryingSlot> varyings = (*fragment_code)->varyings;
  const kernels::Shader vertex_shader = kernels::shader_of(*source.vertex);
  const VertexOutputs outputs = kernels::add_vertex_outputs(vertex_shader.info, source.draws_points, varyings);
  Result<ir::Kernel> vertex = kernels::build_vertex(source, vertex_shader, varyings);
  if (!vertex) return std::unexpected(vertex.error());
  Result<ExecutablePtr> vertex_code = cached_executable(std::move(*vertex));
  if (!vertex_code) return std::unexpected(vertex_code.error());
  if (Result<void> done = finish_both(**fragment_code, **vertex_code); !done) return std::unexpected(done.error());
  return GraphicsKernels{.vertex = *vertex_code,
                         .fragment = *fragment_code,
                         .vertex_slots = static_cast<uint32_t>(4 + varyings.size()),
                         .outputs = outputs,
                         .early_depth = fragment->early_depth,
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
  Result<ExecutablePtr> code = finished_executable(std::move(*kernel));
  if (!code) return std::unexpected(code.error());
  return ComputeKernel{*code, shader.info.local_size, shader.info.shared_memory_bytes, ir::wave_frame((*code)->ir).bytes};
}

Result<KernelPtr> compile_resolve(VkFormat format, uint32_t samples, VkResolveModeFlagBits mode) {
  Result<ir::Kernel> kernel = kernels::build_resolve(format, samples, mode);
  if (!kernel) return std::unexpected(kernel.error());
  return compile_kernel(std::move(*kernel));
}

Result<KernelPtr> compile_kernel(ir::Kernel kernel) {
  Result<ExecutablePtr> code = finished_executable(std::move(kernel));
  if (!code) return std::unexpected(code.error());
  return *code;
}

}  // namespace pineda::compiler
