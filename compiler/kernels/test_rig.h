// Runs kernels in tests, in the evaluator: small compute kernels over arrays, and fragment kernels over one 4x4 block.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "base/format.h"
#include "base/srgb.h"
#include "compiler/compile.h"
#include "compiler/eval/eval.h"
#include "compiler/jit/jit.h"
#include "compiler/kernels/kernels.h"
#include "compiler/passes/passes.h"

namespace pineda::kernels::test {

inline constexpr uint32_t kSeed = 20240501;

inline ir::Kernel optimized(ir::Kernel kernel, eval::Mode mode) {
  EXPECT_EQ(ir::verify(kernel), "");
  passes::optimize(kernel, mode == eval::Mode::kF64 ? passes::Form::kTruth : passes::Form::kMachine);
  EXPECT_EQ(ir::verify(kernel), "");
  return kernel;
}

// Runs a kernel in the evaluator; while `compare_machine_code` is set (JitComparison), also as machine code of every instruction
// set that this CPU has, and expects the same stored bytes. Memory holds the evaluator's result afterwards.
class Runner {
 public:
  static inline bool compare_machine_code = false;

  Runner(const ir::Kernel& kernel, eval::Mode mode) : program_(kernel, mode) {
    if (!compare_machine_code || mode != eval::Mode::kF32) return;
    std::string error;
    const jit::Api* api = jit::api(&error);
    if (!api) {
      ADD_FAILURE() << error;
      return;
    }
    for (const jit::Isa isa : {jit::Isa::kSse42, jit::Isa::kAvx2, jit::Isa::kAvx512}) {
      if (!jit::isa_supported(isa)) continue;
      jit::Code code = api->compile(kernel, {.isa = isa});
      EXPECT_EQ(code.error, "");
      if (!code.error.empty()) continue;
      codes_.push_back({isa, code.fn, std::shared_ptr<void>(code.owner, api->release)});
    }
  }

  void run(const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count, const void* waves) const {
    std::vector<eval::WrittenByte> expected, before;
    if (!codes_.empty()) {
      expected = program_.dry_run(draw, thread, prims, prim_count, waves);
      before = expected;
      for (eval::WrittenByte& byte : before) byte.value = *reinterpret_cast<const uint8_t*>(byte.address);
    }
    for (const MachineCode& code : codes_) {
      const KernelHandle handle{code.fn, nullptr};
      handle(draw, thread, prims, prim_count, waves);
      for (const eval::WrittenByte& byte : expected) {
        if (*reinterpret_cast<const uint8_t*>(byte.address) == byte.value) continue;
        ADD_FAILURE() << jit::isa_name(code.isa) << " differs from the evaluator at " << std::hex << byte.address;
        break;
      }
      for (const eval::WrittenByte& byte : before) *reinterpret_cast<uint8_t*>(byte.address) = byte.value;
    }
    program_.run(draw, thread, prims, prim_count, waves);
  }

 private:
  struct MachineCode {
    jit::Isa isa;
    KernelFn fn;
    std::shared_ptr<void> owner;
  };
  eval::Program program_;
  std::vector<MachineCode> codes_;
};

// A kernel that maps arrays of 32-bit words to arrays of 32-bit words, 16 elements a wave. The arrays' addresses stand in the
// push constants.
class ArrayKernel {
 public:
  // body: values of the inputs' i-th elements -> values of the outputs' i-th elements
  using Body = std::function<std::vector<ir::Value>(ir::Builder&, const std::vector<ir::Value>&)>;

  ArrayKernel(uint32_t inputs, const Body& body, eval::Mode mode = eval::Mode::kF32) : inputs_(inputs) {
    ir::Kernel kernel{.name = "array", .kind = ir::KernelKind::kCompute, .wave_stride_bytes = sizeof(Wave)};
    ir::Builder b(kernel);
    const ir::Value first = b.shl(b.load(ir::Type::kI32, b.wave_ptr(), offsetof(Wave, index)), b.i32(6));
    const auto array = [&](uint32_t i) {
      const uint32_t at = static_cast<uint32_t>(offsetof(DrawContext, push_constants) + 8 * i);
      return ir::Address{.base = b.load(ir::Type::kPtr, b.draw_ptr(), at, ir::kInvariant), .offset = first, .lane_stride = 4};
    };
    std::vector<ir::Value> in;
    for (uint32_t i = 0; i < inputs; ++i) in.push_back(b.load(ir::Type::kI32, array(i)));
    const std::vector<ir::Value> out = body(b, in);
    outputs_ = static_cast<uint32_t>(out.size());
    for (uint32_t i = 0; i < outputs_; ++i) b.store(array(inputs + i), out[i]);
    runner_ = std::make_unique<Runner>(optimized(std::move(kernel), mode), mode);
  }

  std::vector<std::vector<uint32_t>> operator()(std::vector<std::vector<uint32_t>> in, DrawContext draw = {}) const {
    const size_t count = in[0].size(), padded = (count + 15) / 16 * 16;
    std::vector<std::vector<uint32_t>> out(outputs_, std::vector<uint32_t>(padded));
    set_srgb_tables(draw);
    for (uint32_t i = 0; i < inputs_ + outputs_; ++i) {
      if (i < inputs_) in[i].resize(padded);
      const void* address = i < inputs_ ? in[i].data() : out[i - inputs_].data();
      std::memcpy(draw.push_constants + 8 * i, &address, 8);
    }
    std::vector<Wave> waves;
    for (uint32_t i = 0; i < padded / 16; ++i) waves.push_back({0xffff, i});
    const PrimRecord prim{nullptr, 0, static_cast<uint32_t>(waves.size())};
    ThreadContext thread{};
    runner_->run(&draw, &thread, &prim, 1, waves.data());
    for (auto& array : out) array.resize(count);
    return out;
  }

 private:
  struct Wave {
    uint32_t mask, index;
  };
  uint32_t inputs_, outputs_ = 0;
  std::unique_ptr<Runner> runner_;
};

// One 4x4 block under one triangle, every pipeline state, a shader written in C++.
struct FragmentRig {
  compiler::PipelineLayout layout;
  compiler::GraphicsSource source{.layout = &layout, .name = "test"};
  Shader shader;
  DrawContext draw{};
  FragmentPrim prim{};
  FragmentWave wave{.exec_mask = 0xffff, .coverage = 0xffff};
  std::array<std::vector<uint8_t>, kMaxColorAttachments> color;  // tile buffers; sized by run() when empty
  std::vector<uint8_t> depth, stencil;
  std::vector<uint8_t> equal{0};           // with several samples; for block 0
  std::array<uint16_t, kLanes> samples{};  // likewise: covered samples
  bool per_sample = false;                 // the kernel runs for each sample: block_index is the sample's
  uint64_t samples_passed = 0;
  std::vector<float> vertices[3];  // slot s at s * 16
  bool early_depth = false, reads_color = false, opaque = false;

  static FragmentRig with(std::function<void(ir::Builder&, spirv::StageInterface&)> body) {
    FragmentRig rig;
    rig.shader.body = [body](ir::Builder& b, spirv::StageInterface& stage) -> Result<spirv::Translation> {
      body(b, stage);
      return spirv::Translation{};
    };
    return rig;
  }

  // Builds and compiles; varyings read are returned.
  std::vector<compiler::VaryingSlot> build(eval::Mode mode, bool depth_only = false) {
    source.layout = &layout;  // the rig may have been moved
    Result<FragmentKernel> built = build_fragment(source, depth_only ? nullptr : &shader);
    EXPECT_TRUE(built) << (built ? "" : built.error().text);
    if (!built) return {};
    early_depth = built->early_depth;
    reads_color = built->reads_color;
    opaque = built->opaque;
    per_sample = built->per_sample;
    ir::Kernel kernel = optimized(std::move(built->ir), mode);
    const std::vector<compiler::VaryingSlot> varyings = compact_varyings(kernel);
    EXPECT_EQ(ir::verify(kernel), "");
    runner_ = std::make_shared<Runner>(kernel, mode);
    return varyings;
  }

  void run() {
    set_srgb_tables(draw);
    ThreadContext thread{};
    const uint32_t n = per_sample ? 1 : source.state.samples;
    for (uint32_t a = 0; a < source.state.color_count; ++a) {
      color[a].resize(
          std::max<size_t>(color[a].size(), (wave.block_index + 1) * n * 16 * texel_bytes(source.state.color[a].format)));
      thread.color[a] = color[a].data();
    }
    depth.resize(std::max<size_t>(depth.size(), (wave.block_index + 1) * n * 16 * texel_bytes(source.state.depth.format)));
    stencil.resize(std::max<size_t>(stencil.size(), (wave.block_index + 1) * n * 16));
    thread.depth = depth.data();
    thread.stencil = stencil.data();
    thread.equal_samples = equal.data();
    for (uint32_t v = 0; v < 3; ++v) prim.vertex[v] = vertices[v].data();
    const PrimRecord record{&prim, 0, 1};
    if (n > 1) {
      FragmentSampleWave sample_wave{wave, {}};
      std::ranges::copy(samples, sample_wave.samples);
      runner_->run(&draw, &thread, &record, 1, &sample_wave);
    } else {
      runner_->run(&draw, &thread, &record, 1, &wave);
    }
    samples_passed = thread.samples_passed;
  }

 private:
  std::shared_ptr<Runner> runner_;
};

inline uint32_t lane_x(uint32_t lane) { return (lane & 1) + 2 * (lane >> 2 & 1); }
inline uint32_t lane_y(uint32_t lane) { return (lane >> 1 & 1) + 2 * (lane >> 3); }

inline spirv::InterfaceScalar color_output(uint32_t location, uint32_t component) {
  return {.location = location, .component = component};
}

// Every plain row of the table: kernels see no other.
inline std::vector<const FormatInfo*> all_formats() {
  std::vector<const FormatInfo*> formats;
  for (const FormatInfo& info : pineda::all_formats()) {
    if (info.is_plain()) formats.push_back(&info);
  }
  return formats;
}

// The component's bits of a texel in memory.
inline uint32_t code_of(const FormatInfo& format, uint32_t component, const uint8_t* texel) {
  const ComponentBits where = format.component[component];
  uint64_t code = 0;
  for (uint32_t i = 0; i < where.bits; ++i) {
    const uint32_t bit = where.first_bit + i;
    code |= static_cast<uint64_t>(texel[bit / 8] >> bit % 8 & 1) << i;
  }
  return static_cast<uint32_t>(code);
}

// What the component means, after the specification's formulas, in double: of its bits (mantissas of E5B9G9R9: unscaled), of a
// texel in memory.
double decode_reference(const FormatInfo& format, uint32_t component, uint32_t code);
double decode_texel(const FormatInfo& format, uint32_t component, const uint8_t* texel);

}  // namespace pineda::kernels::test
