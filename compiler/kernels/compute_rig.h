// Whole compute shaders in tests: GLSL -> SPIR-V -> kernel, run over a grid of workgroups in the evaluator and as machine code of
// every instruction set of this CPU, which must leave the same bytes.
#pragma once

#include <algorithm>

#include "compiler/ir/wave_frame.h"
#include "compiler/kernels/test_rig.h"
#include "compiler/spirv/test_shaders.h"

namespace pineda::kernels::test {

struct ComputeRig {
  std::vector<std::vector<uint32_t>> buffers;  // storage buffers: set 0, binding i
  std::array<uint32_t, 3> groups{1, 1, 1};
  std::vector<uint32_t> push_constants;
  std::vector<spirv::SpecializationConstant> specialization;
  std::string target = "vulkan1.0";
  bool optimize = true;  // false: the kernel as the translator leaves it

  // `buffers` then holds the evaluator's result. The error, or empty.
  std::string run(const std::string& glsl) { return run_words(spirv::test::glsl(VK_SHADER_STAGE_COMPUTE_BIT, glsl, target)); }
  std::string run_words(const std::vector<uint32_t>& words) {
    const auto module = spirv::parse(
        {.words = words, .entry_point = "main", .stage = VK_SHADER_STAGE_COMPUTE_BIT, .specialization = specialization});
    if (!module) return module.error().text;
    compiler::PipelineLayout layout;
    for (uint32_t i = 0; i < buffers.size(); ++i) {
      layout.bindings.push_back({.set = 0,
                                 .binding = i,
                                 .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                 .count = 1,
                                 .offset_bytes = static_cast<uint32_t>(i * sizeof(BufferDescriptor)),
                                 .stride_bytes = sizeof(BufferDescriptor)});
    }
    layout.push_constant_bytes = static_cast<uint32_t>(4 * push_constants.size());
    const Shader shader = shader_of(**module);
    Result<ir::Kernel> kernel = build_compute({.module = module->get(), .layout = &layout, .name = "test"}, shader);
    if (!kernel) return kernel.error().text;
    EXPECT_EQ(ir::verify(*kernel), "") << ir::print(*kernel);
    if (optimize) *kernel = optimized(std::move(*kernel), eval::Mode::kF32);
    if (getenv("PINEDA_TEST_PRINT")) printf("%s\n", ir::print(*kernel).c_str());
    local_size = shader.info.local_size;
    shared_bytes = shader.info.shared_memory_bytes;
    run_everywhere(*kernel);
    return "";
  }

  // ---- its own ----
  void run_everywhere(const ir::Kernel& kernel) {
    const auto initial = buffers;
    const eval::Program program(kernel, eval::Mode::kF32);
    run_grid(kernel, {&eval::Program::invoke, &program});
    const auto expected = buffers;
    std::string error;
    const jit::Api* api = jit::api(&error);
    ASSERT_NE(api, nullptr) << error;
    for (const jit::Isa isa : {jit::Isa::kSse42, jit::Isa::kAvx2, jit::Isa::kAvx512}) {
      if (!jit::isa_supported(isa)) continue;
      const jit::Code code = api->compile(kernel, {.isa = isa, .want_assembly = getenv("PINEDA_TEST_PRINT") != nullptr});
      ASSERT_EQ(code.error, "") << jit::isa_name(isa) << "\n" << ir::print(kernel);
      if (!code.assembly.empty()) printf("%s\n", code.assembly.c_str());
      buffers = initial;
      run_grid(kernel, {code.fn, nullptr});
      api->release(code.owner);
      for (size_t i = 0; i < buffers.size(); ++i) {
        const auto [got, want] = std::ranges::mismatch(buffers[i], expected[i]);
        if (got == buffers[i].end()) continue;
        ADD_FAILURE() << jit::isa_name(isa) << " differs from the evaluator in buffer " << i << " at word "
                      << got - buffers[i].begin() << ": " << *got << " instead of " << *want << "\n"
                      << ir::print(kernel);
      }
    }
    buffers = expected;
  }

  // What raster::dispatch does, one workgroup after the other.
  void run_grid(const ir::Kernel& kernel, const KernelHandle& handle) {
    std::vector<BufferDescriptor> set;
    for (auto& words : buffers) {
      set.push_back({reinterpret_cast<uint64_t>(words.data()), static_cast<uint32_t>(words.size() * 4), 0});
    }
    DrawContext draw{};
    draw.sets[0] = set.data();
    std::memcpy(draw.push_constants, push_constants.data(), 4 * push_constants.size());
    std::copy(groups.begin(), groups.end(), draw.workgroup_count);
    const uint32_t invocations = local_size[0] * local_size[1] * local_size[2];
    std::vector<ComputeWave> waves;
    for (uint32_t i = 0; i < invocations; i += kLanes) {
      waves.push_back({invocations - i >= kLanes ? 0xffff : (1u << (invocations - i)) - 1, i});
    }
    struct alignas(64) Line {
      uint8_t bytes[64];
    };
    std::vector<Line> frames(ir::wave_frame(kernel).bytes / 64 * waves.size()), shared(shared_bytes / 64 + 1);
    std::memset(frames.data(), 0xcd, frames.size() * sizeof(Line));  // whoever reads what nobody stored is found out
    ThreadContext thread{};
    thread.wave_frames = frames.empty() ? nullptr : frames[0].bytes;
    for (uint32_t z = 0; z < groups[2]; ++z) {
      for (uint32_t y = 0; y < groups[1]; ++y) {
        for (uint32_t x = 0; x < groups[0]; ++x) {
          std::memset(shared.data(), 0, shared.size() * sizeof(Line));
          const WorkgroupRecord group{.id = {x, y, z}, .shared_memory = shared.data()};
          const PrimRecord prim{&group, 0, static_cast<uint32_t>(waves.size())};
          handle(&draw, &thread, &prim, 1, waves.data());
        }
      }
    }
  }

  std::array<uint32_t, 3> local_size{};
  uint32_t shared_bytes = 0;
};

}  // namespace pineda::kernels::test
