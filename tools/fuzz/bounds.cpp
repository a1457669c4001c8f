#include "tools/fuzz/bounds.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <span>
#include <stdexcept>
#include <vector>

#include "compiler/compile.h"
#include "compiler/ir/walk.h"
#include "compiler/ir/wave_frame.h"
#include "compiler/jit/jit.h"
#include "compiler/kernels/kernels.h"
#include "compiler/passes/passes.h"
#include "compiler/spirv/translate.h"
#include "raster/raster.h"
#include "shaders/histogram_comp.h"
#include "shaders/reduce_comp.h"
#include "shaders/saxpy_comp.h"
#include "shaders/scan_comp.h"
#include "shaders/sgemm_comp.h"
#include "shaders/transcendentals_comp.h"

namespace pineda::fuzz {
namespace {

// Bindings 0, 1 ... of set 0 are buffers of these sizes, all within the 2 MiB of a second-level cache: a shader that waits for
// memory has time for any check.
struct Work {
  std::span<const uint32_t> code;
  const char* name;
  std::vector<size_t> buffer_words;
  uint32_t push_constant;
  std::array<uint32_t, 2> groups;
};
const Work kWorks[] = {
    {sgemm_comp, "sgemm", {256 * 256, 256 * 256, 256 * 256}, 256, {16, 16}},
    {saxpy_comp, "saxpy", {1 << 16, 1 << 16}, 0x3f000000, {256, 1}},
    {transcendentals_comp, "transcendentals", {1 << 14}, 4, {256, 1}},
    {histogram_comp, "histogram", {1 << 18, 256}, 64, {16, 1}},
    {reduce_comp, "reduce", {1 << 18, 256}, 4, {256, 1}},
    {scan_comp, "scan", {1 << 16, 1 << 16}, 0, {256, 1}},
};

// What stands in limits only goes with them, as no check is left that reads it.
void drop_limits(ir::Kernel& kernel) {
  ir::for_each_inst(kernel, kernel.wave, [&](ir::Value v) {
    ir::Inst& inst = kernel.at(v);
    if (!ir::is_memory(inst.op) || !ir::limit_of(inst)) return;
    inst.operand[ir::limit_index(inst.op)] = {};
    if (inst.flags & ir::kInvariant) inst.flags |= ir::kSpeculate;  // so that it may be hoisted, as a checked one may
  });
}

class Program {
 public:
  // Throws what went wrong.
  Program(const Work& work, const jit::Api& api, const spirv::Module& module, bool checked) : api_(api) {
    compiler::PipelineLayout layout{.push_constant_bytes = 4};
    for (uint32_t i = 0; i < work.buffer_words.size(); ++i) {
      layout.bindings.push_back({.set = 0,
                                 .binding = i,
                                 .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                 .count = 1,
                                 .offset_bytes = static_cast<uint32_t>(i * sizeof(BufferDescriptor)),
                                 .stride_bytes = sizeof(BufferDescriptor)});
    }
    const kernels::Shader shader = kernels::shader_of(module);
    Result<ir::Kernel> kernel = kernels::build_compute({.module = &module, .layout = &layout, .name = "bounds"}, shader);
    if (!kernel) throw std::runtime_error(kernel.error().text);
    if (!checked) drop_limits(*kernel);
    passes::optimize(*kernel, passes::Form::kMachine);
    std::string error;
    code_ = api.compile(*kernel, {.isa = jit::select_isa(&error)});
    if (error += code_.error; !error.empty()) throw std::runtime_error(error);
    packet_.kernel = {code_.fn, nullptr};
    packet_.local_size = shader.info.local_size;
    packet_.count = {work.groups[0], work.groups[1], 1};
    packet_.shared_memory_bytes = shader.info.shared_memory_bytes;
    packet_.wave_frame_bytes = ir::wave_frame(*kernel).bytes;
  }
  ~Program() { api_.release(code_.owner); }
  Program(const Program&) = delete;

  double run_seconds(raster::ThreadPool& pool, const DrawContext& context) {
    packet_.context = &context;
    const auto start = std::chrono::steady_clock::now();
    raster::dispatch(pool, packet_);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

 private:
  const jit::Api& api_;
  jit::Code code_;
  raster::DispatchPacket packet_{};
};

void measure(const Work& work, const jit::Api& api) {
  const auto module = spirv::parse({.words = work.code, .entry_point = "main", .stage = VK_SHADER_STAGE_COMPUTE_BIT});
  if (!module) throw std::runtime_error(module.error().text);
  std::vector<std::vector<uint32_t>> buffers;
  std::vector<BufferDescriptor> set;
  for (const size_t count : work.buffer_words) buffers.emplace_back(count, 0);
  for (auto& buffer : buffers)
    set.push_back({reinterpret_cast<uint64_t>(buffer.data()), static_cast<uint32_t>(buffer.size() * 4), 0});
  DrawContext context{};
  context.sets[0] = set.data();
  std::memcpy(context.push_constants, &work.push_constant, 4);
  std::copy_n(work.groups.begin(), 2, context.workgroup_count);
  context.workgroup_count[2] = 1;

  raster::ThreadPool pool(1);
  Program checked(work, api, **module, true), unchecked(work, api, **module, false);
  // The least of many short turns, taken alternately: whatever else the machine does only adds.
  constexpr uint32_t kTurns = 300;
  double with = 1e9, without = 1e9;
  for (uint32_t turn = 0; turn < kTurns; ++turn) {
    with = std::min(with, checked.run_seconds(pool, context));
    without = std::min(without, unchecked.run_seconds(pool, context));
  }
  std::printf("%-16s %12.1f %14.1f %10.3f\n", work.name, 1e6 * with, 1e6 * without, without / with);
}

}  // namespace

int measure_bounds() {
  std::string error;
  const jit::Api* api = jit::api(&error);
  if (!api) return std::fprintf(stderr, "%s\n", error.c_str()), 1;
  std::printf("%-16s %12s %14s %10s\n", "shader", "checked us", "unchecked us", "speed left");
  int status = 0;
  for (const Work& work : kWorks) {
    try {
      measure(work, *api);
    } catch (const std::exception& failure) {
      std::fprintf(stderr, "%s: %s\n", work.name, failure.what());
      status = 1;
    }
  }
  return status;
}

}  // namespace pineda::fuzz
