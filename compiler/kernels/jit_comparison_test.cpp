// Kernels as machine code against the evaluator, byte for byte, on every instruction set of this CPU: one test for each family of
// kernels.
#include <bit>
#include <cmath>

#include "compiler/kernels/sample.h"
#include "compiler/kernels/test_rig.h"
#include "compiler/kernels/texel.h"

namespace pineda::kernels::test {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;
using spirv::StageInterface;

class JitComparison : public testing::Test {
 protected:
  void SetUp() override { Runner::compare_machine_code = true; }
  void TearDown() override { Runner::compare_machine_code = false; }
};

std::vector<uint32_t> random_words(std::mt19937& random, size_t count) {
  std::vector<uint32_t> words(count);
  for (uint32_t& w : words) w = static_cast<uint32_t>(random());
  return words;
}

TEST_F(JitComparison, Transcendentals) {
  std::mt19937 random(kSeed);
  for (uint32_t op = static_cast<uint32_t>(Op::kFSin); op <= static_cast<uint32_t>(Op::kFPow); ++op) {
    const ArrayKernel kernel(2, [&](Builder& b, const std::vector<Value>& in) {
      const Value x = b.bitcast(Type::kF32, in[0]), y = b.bitcast(Type::kF32, in[1]);
      const bool two = ir::op_info(static_cast<Op>(op)).operands == 2;
      return std::vector{two ? b.op(static_cast<Op>(op), Type::kF32, {x, y}) : b.op(static_cast<Op>(op), Type::kF32, {x})};
    });
    kernel({random_words(random, 4096), random_words(random, 4096)});
    if (HasFailure()) return;
  }
}

TEST_F(JitComparison, PackAndUnpack) {
  std::mt19937 random(kSeed);
  for (const VkFormat f : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_SNORM, VK_FORMAT_B8G8R8A8_SRGB,
                           VK_FORMAT_R5G6B5_UNORM_PACK16, VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_R16G16B16A16_SFLOAT,
                           VK_FORMAT_R16G16_SINT, VK_FORMAT_X8_D24_UNORM_PACK32}) {
    const FormatInfo& format = *find_format(f);
    const ArrayKernel kernel(4, [&](Builder& b, const std::vector<Value>& in) {
      Channels values;
      for (uint32_t c = 0; c < 4; ++c) values[c] = b.bitcast(channel_type(format), in[c]);
      const Words words = pack(b, format, values);
      std::vector<Value> out(words.begin(), words.begin() + word_count(format));
      Words texel{in[0], in[1]};
      for (const Value v : unpack(b, format, texel)) out.push_back(v);
      return out;
    });
    std::vector<std::vector<uint32_t>> in;
    for (int c = 0; c < 4; ++c) {
      in.push_back(random_words(random, 2048));
      for (size_t i = 0; i < 1024; ++i) in.back()[i] = std::bit_cast<uint32_t>(static_cast<float>(random() / 0x1p31 - 0.5));
    }
    kernel(in);
    if (HasFailure()) return;
  }
}

// Depth test, discard, varyings, blending of three attachments of different sizes.
TEST_F(JitComparison, Fragment) {
  std::mt19937 random(kSeed);
  const auto number = [&](double low, double high) { return static_cast<float>(low + (high - low) * (random() / 0x1p32)); };
  const VkFormat colors[][3] = {{VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8_UNORM, VK_FORMAT_R32_UINT},
                                {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16G16_UINT},
                                {VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R5G6B5_UNORM_PACK16, VK_FORMAT_R8_UINT}};
  const VkFormat depths[] = {VK_FORMAT_D32_SFLOAT, VK_FORMAT_D16_UNORM, VK_FORMAT_X8_D24_UNORM_PACK32};
  for (int i = 0; i < 3; ++i) {
    FragmentRig rig;
    rig.shader.body = [](Builder& b, StageInterface& stage) -> Result<spirv::Translation> {
      Value alpha;
      for (uint32_t c = 0; c < 4; ++c) {
        const Value v = stage.input(b, {.location = 1, .component = c});
        stage.output(b, color_output(0, c), b.fmul(v, v));
        stage.output(
            b, color_output(1, c),
            b.fdiv(v, stage.input(b, {.location = 0, .component = 2, .interpolation = spirv::Interpolation::kNoPerspective})));
        stage.output(b, color_output(2, c),
                     stage.input(b, {.location = 3, .type = Type::kI32, .interpolation = spirv::Interpolation::kFlat}));
        alpha = v;
      }
      return spirv::Translation{b.flt(alpha, b.f32(0.2))};
    };
    rig.source.state.color_count = 3;
    for (int a = 0; a < 3; ++a) {
      rig.source.state.color[a] = {.format = colors[i][a],
                                   .blend_enable = a < 2,
                                   .src_color = VK_BLEND_FACTOR_SRC_ALPHA,
                                   .dst_color = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
                                   .src_alpha = VK_BLEND_FACTOR_CONSTANT_ALPHA,
                                   .dst_alpha = VK_BLEND_FACTOR_ONE,
                                   .write_mask = a == 0 ? 0xbu : 0xfu};
    }
    rig.source.state.depth = {.format = depths[i], .test_enable = true, .write_enable = true, .compare = VK_COMPARE_OP_LESS};
    rig.build(eval::Mode::kF32);
    for (int round = 0; round < 200; ++round) {
      rig.prim = {.x0_px = number(0, 20),
                  .y0_px = number(0, 20),
                  .l1_dx = number(-0.2, 0.2),
                  .l1_dy = number(-0.2, 0.2),
                  .l2_dx = number(-0.2, 0.2),
                  .l2_dy = number(-0.2, 0.2),
                  .z0 = number(0, 1),
                  .dz1 = number(-0.3, 0.3),
                  .dz2 = number(-0.3, 0.3),
                  .iw0 = number(0.1, 2),
                  .iw1 = number(0.1, 2),
                  .iw2 = number(0.1, 2)};
      for (auto& vertex : rig.vertices) {
        vertex.resize(12 * kLanes);
        for (float& v : vertex) v = number(-0.5, 1.5);
      }
      rig.draw.blend_constants[3] = number(0, 1);
      rig.wave.coverage = static_cast<uint32_t>(random()) & 0xffff;
      rig.wave.x_px = 4 * (random() % 4);
      rig.wave.block_index = 1;
      for (uint32_t a = 0; a < 3; ++a) {
        rig.color[a].resize(32 * texel_bytes(colors[i][a]));
        for (uint8_t& byte : rig.color[a]) byte = static_cast<uint8_t>(random()) & 0x3f;  // no NaN
      }
      rig.depth.resize(32 * texel_bytes(depths[i]));
      for (uint32_t lane = 0; lane < 32; ++lane)
        pack_depth(*find_format(depths[i]), number(0, 1), &rig.depth[lane * texel_bytes(depths[i])]);
      rig.run();
      if (HasFailure()) return;
    }
  }
}

TEST_F(JitComparison, Sampling) {
  std::mt19937 random(kSeed);
  for (const VkFormat format : {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT}) {
    ImageDescriptor image{.width = 16, .height = 8, .depth = 1, .level_count = 3, .layer_count = 1};
    uint32_t size = 0;
    for (uint32_t l = 0; l < 3; ++l) {
      image.levels[l] = {size, (16u >> l) * texel_bytes(format)};
      size += (16u >> l) * (8u >> l) * texel_bytes(format);
    }
    std::vector<uint8_t> bytes(size);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random()) & 0x3f;
    image.address = reinterpret_cast<uint64_t>(bytes.data());
    image.size_bytes = size;
    image.max_lod = 100;
    for (const VkSamplerAddressMode mode : {VK_SAMPLER_ADDRESS_MODE_REPEAT, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER}) {
      compiler::TextureState state{.format = format,
                                   .mag_filter = VK_FILTER_NEAREST,
                                   .min_filter = VK_FILTER_LINEAR,
                                   .mipmap_mode = VK_SAMPLER_MIPMAP_MODE_LINEAR};
      state.address.fill(mode);
      const ArrayKernel kernel(2, [&](Builder& b, const std::vector<Value>& in) {
        const Value descriptor = b.load(Type::kPtr, b.draw_ptr(), offsetof(DrawContext, push_constants) + 240, ir::kInvariant);
        spirv::SampleRequest request;
        request.coord = {b.bitcast(Type::kF32, in[0]), b.bitcast(Type::kF32, in[1])};
        const auto texel =
            sample_image(b, {state, descriptor, b.ptr_add(descriptor, b.i32(offsetof(ImageDescriptor, lod_bias)))}, request);
        return std::vector<Value>(texel->begin(), texel->end());
      });
      std::vector<std::vector<uint32_t>> in(2);
      for (int i = 0; i < 2048; ++i) {
        for (auto& axis : in)
          axis.push_back(std::bit_cast<uint32_t>(static_cast<float>((random() / 0x1p31 - 1) * std::exp2(i % 8 - 6))));
      }
      for (int i = 0; i < 256; ++i)
        in[0].push_back(static_cast<uint32_t>(random())), in[1].push_back(static_cast<uint32_t>(random()));
      DrawContext draw{};
      const void* descriptor = &image;
      std::memcpy(draw.push_constants + 240, &descriptor, 8);
      kernel(in, draw);
      if (HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace pineda::kernels::test
