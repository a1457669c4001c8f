// Every dimension, filter, address mode and operation against the specification in double (sample_reference.h).
#include <bit>
#include <cmath>

#include "compiler/kernels/sample_reference.h"

namespace pineda::kernels::test {
namespace {

using compiler::TextureState;
using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::LodMode;
using spirv::SampleRequest;

constexpr uint32_t kDescriptorSlot = 240;  // push constant bytes that hold the descriptor's address
using Floats = std::vector<std::vector<float>>;
using Request = std::function<void(Builder&, const std::vector<Value>&, SampleRequest&)>;

std::vector<std::vector<uint32_t>> run(const TestImage& image, const TextureState& state, const Floats& in,
                                       const Request& request) {
  const ArrayKernel kernel(static_cast<uint32_t>(in.size()), [&](Builder& b, const std::vector<Value>& words) {
    const Value descriptor = b.load(Type::kPtr, b.draw_ptr(), offsetof(DrawContext, push_constants) + kDescriptorSlot);
    const Value sampler = b.ptr_add(descriptor, b.i32(offsetof(ImageDescriptor, lod_bias)));
    SampleRequest r;
    r.view_type = state.view_type;
    r.result = image.format.is_integer() ? Type::kI32 : Type::kF32;
    r.lod_mode = LodMode::kExplicit;
    std::vector<Value> floats;
    for (const Value v : words) floats.push_back(b.bitcast(Type::kF32, v));
    request(b, floats, r);
    const Result<Channels> texel = sample_image(b, {state, descriptor, sampler}, r);
    EXPECT_TRUE(texel) << (texel ? "" : texel.error().text);
    return std::vector<Value>(texel->begin(), texel->end());
  });
  DrawContext draw{};
  const void* descriptor = &image.descriptor;
  std::memcpy(draw.push_constants + kDescriptorSlot, &descriptor, 8);
  std::vector<std::vector<uint32_t>> words;
  for (const auto& array : in) {
    words.emplace_back();
    for (const float v : array) words.back().push_back(std::bit_cast<uint32_t>(v));
  }
  return kernel(words, draw);
}

std::vector<float> uniform(std::mt19937& random, double low, double high, uint32_t count) {
  std::vector<float> x(count);
  for (float& v : x) v = static_cast<float>(low + (high - low) * (random() / 0x1p32));
  return x;
}

uint32_t axes_of(VkImageViewType type) {  // of the shader's coordinate, without the layer
  switch (type) {
    case VK_IMAGE_VIEW_TYPE_1D:
    case VK_IMAGE_VIEW_TYPE_1D_ARRAY:
      return 1;
    case VK_IMAGE_VIEW_TYPE_2D:
    case VK_IMAGE_VIEW_TYPE_2D_ARRAY:
      return 2;
    default:
      return 3;
  }
}

bool is_layered(VkImageViewType type) {
  return type == VK_IMAGE_VIEW_TYPE_1D_ARRAY || type == VK_IMAGE_VIEW_TYPE_2D_ARRAY || type == VK_IMAGE_VIEW_TYPE_CUBE_ARRAY;
}

constexpr VkSamplerAddressMode kModes[] = {VK_SAMPLER_ADDRESS_MODE_REPEAT, VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT,
                                           VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER,
                                           VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE};
constexpr ImageShape kShapes[] = {
    {.type = VK_IMAGE_VIEW_TYPE_1D, .width = 21, .levels = 5},
    {.type = VK_IMAGE_VIEW_TYPE_1D_ARRAY, .width = 21, .levels = 5, .layers = 3},
    {.type = VK_IMAGE_VIEW_TYPE_2D, .width = 13, .height = 7, .levels = 4},
    {.type = VK_IMAGE_VIEW_TYPE_2D_ARRAY, .width = 13, .height = 7, .levels = 4, .layers = 3},
    {.type = VK_IMAGE_VIEW_TYPE_3D, .width = 9, .height = 6, .depth = 5, .levels = 4},
    {.type = VK_IMAGE_VIEW_TYPE_CUBE, .width = 6, .height = 6, .levels = 3, .layers = 6},
    {.type = VK_IMAGE_VIEW_TYPE_CUBE_ARRAY, .width = 5, .height = 5, .levels = 3, .layers = 18},
};

// Inputs 0..2 coordinates, 3 layer, 4 LOD, 5 depth reference.
Floats random_inputs(std::mt19937& random, const ImageShape& shape, uint32_t count) {
  const bool direction = shape.type == VK_IMAGE_VIEW_TYPE_CUBE || shape.type == VK_IMAGE_VIEW_TYPE_CUBE_ARRAY;
  const double low = direction ? -1 : -2.5, high = direction ? 1 : 3.5;
  Floats in;
  for (int a = 0; a < 3; ++a) in.push_back(uniform(random, low, high, count));
  in.push_back(uniform(random, -1.4, 3.4, count));
  in.push_back(uniform(random, -1, 5, count));
  in.push_back(uniform(random, -0.2, 1.2, count));
  return in;
}

Request explicit_request(const TextureState& state) {
  return [&state](Builder&, const std::vector<Value>& in, SampleRequest& r) {
    const uint32_t axes = axes_of(state.view_type);
    for (uint32_t a = 0; a < axes; ++a) r.coord[a] = in[a];
    if (is_layered(state.view_type)) r.coord[axes] = in[3];
    r.lod = in[4];
    if (state.compare_enable) r.depth_reference = in[5];
  };
}

SpecSample spec_sample(const Floats& in, size_t i) {
  return {.coord = {in[0][i], in[1][i], in[2][i]}, .layer = in[3][i], .lod = in[4][i], .depth_reference = in[5][i]};
}

// Sums of up to eight terms below one, and a coordinate that went through a division where the texture is a cube; what a rounding
// of the coordinate could change was left out.
constexpr double kTolerance = 16 * 0x1p-24;

void expect_samples(const TestImage& image, const TextureState& state, const Floats& in,
                    const std::vector<std::vector<uint32_t>>& out, uint32_t components = 4) {
  SpecSampler spec(image, state);
  size_t tested = 0;
  for (size_t i = 0; i < in[0].size(); ++i) {
    for (uint32_t c = 0; c < components; ++c) {
      spec.near_boundary = false;
      const double want = spec.sample(spec_sample(in, i), c);
      if (spec.near_boundary) continue;
      ++tested;
      ASSERT_NEAR(std::bit_cast<float>(out[c][i]), want, kTolerance)
          << "view type " << state.view_type << " component " << c << " at " << in[0][i] << ", " << in[1][i] << ", " << in[2][i]
          << " layer " << in[3][i] << " lod " << in[4][i] << " modes " << state.address[0] << state.address[1] << state.address[2]
          << " filters " << state.mag_filter << state.min_filter << state.mipmap_mode << " reduction " << state.reduction;
    }
  }
  EXPECT_GT(tested, in[0].size() / 2 * components);
}

TextureState random_state(std::mt19937& random, const ImageShape& shape) {
  const auto pick = [&](uint32_t n) { return static_cast<uint32_t>(random()) % n; };
  TextureState state{.format = shape.format,
                     .view_type = shape.type,
                     .mag_filter = static_cast<VkFilter>(pick(2)),
                     .min_filter = static_cast<VkFilter>(pick(4) != 0),
                     .mipmap_mode = static_cast<VkSamplerMipmapMode>(pick(2))};
  for (VkSamplerAddressMode& mode : state.address) mode = kModes[pick(5)];
  return state;
}

TEST(SampleDims, EveryDimensionFilterAndMode) {
  std::mt19937 random(kSeed);
  for (const ImageShape& shape : kShapes) {
    const TestImage image(shape, random);
    for (int turn = 0; turn < 24; ++turn) {
      const TextureState state = random_state(random, shape);
      const Floats in = random_inputs(random, shape, 96);
      expect_samples(image, state, in, run(image, state, in, explicit_request(state)));
      if (HasFatalFailure()) return;
    }
  }
}

// Directions close to edges and corners of a cube, magnified.
TEST(SampleDims, SeamsOfCubes) {
  std::mt19937 random(kSeed);
  for (const uint32_t size : {1u, 2u, 5u}) {
    const ImageShape shape{.type = VK_IMAGE_VIEW_TYPE_CUBE, .width = size, .height = size, .layers = 6};
    const TestImage image(shape, random);
    TextureState state{.format = shape.format,
                       .view_type = shape.type,
                       .single_level = true,
                       .mag_filter = VK_FILTER_LINEAR,
                       .min_filter = VK_FILTER_LINEAR};
    Floats in = random_inputs(random, shape, 1024);
    for (size_t i = 0; i < in[0].size(); ++i) {
      for (size_t a = 0; a < 3; ++a) {
        if (random() % 2) in[a][i] = std::copysign(static_cast<float>(0.7 + 0.3 * (random() / 0x1p32)), in[a][i]);
      }
    }
    expect_samples(image, state, in, run(image, state, in, explicit_request(state)));
    if (HasFatalFailure()) return;
  }
}

TEST(SampleDims, EveryComparison) {
  std::mt19937 random(kSeed);
  for (int op = VK_COMPARE_OP_NEVER; op <= VK_COMPARE_OP_ALWAYS; ++op) {
    ImageShape shape = kShapes[2 + static_cast<size_t>(op) % 2 * 3];  // 2D and cube
    shape.format = op % 3 == 0 ? VK_FORMAT_D16_UNORM : VK_FORMAT_D32_SFLOAT;
    const TestImage image(shape, random);
    TextureState state = random_state(random, shape);
    state.compare_enable = true;
    state.compare = static_cast<VkCompareOp>(op);
    const Floats in = random_inputs(random, shape, 256);
    expect_samples(image, state, in, run(image, state, in, explicit_request(state)), 1);
    if (HasFatalFailure()) return;
  }
}

TEST(SampleDims, MinimumAndMaximum) {
  std::mt19937 random(kSeed);
  for (const ImageShape& shape : kShapes) {
    const TestImage image(shape, random);
    for (const auto reduction : {VK_SAMPLER_REDUCTION_MODE_MIN, VK_SAMPLER_REDUCTION_MODE_MAX}) {
      TextureState state = random_state(random, shape);
      state.min_filter = VK_FILTER_LINEAR;
      state.reduction = reduction;
      const Floats in = random_inputs(random, shape, 128);
      expect_samples(image, state, in, run(image, state, in, explicit_request(state)));
      if (HasFatalFailure()) return;
    }
  }
}

// Anisotropy: the probes and their LOD, from explicit gradients.
TEST(SampleDims, Anisotropy) {
  std::mt19937 random(kSeed);
  for (const float most : {2.0f, 5.5f, 16.0f}) {
    const ImageShape shape{.width = 64, .height = 48, .levels = 6};
    TestImage image(shape, random);
    image.descriptor.max_anisotropy = most;
    TextureState state{.format = shape.format,
                       .mag_filter = VK_FILTER_LINEAR,
                       .min_filter = VK_FILTER_LINEAR,
                       .mipmap_mode = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                       .anisotropy = true};
    state.address = {VK_SAMPLER_ADDRESS_MODE_REPEAT, VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT};
    const uint32_t count = 512;
    Floats in{uniform(random, -1, 2, count), uniform(random, -1, 2, count)};
    for (int i = 0; i < 4; ++i) in.push_back(uniform(random, -0.15, 0.15, count));
    for (size_t i = 0; i < count; i += 2) in[4][i] *= 0.05f, in[5][i] *= 0.05f;  // some are long
    const auto out = run(image, state, in, [](Builder&, const std::vector<Value>& v, SampleRequest& r) {
      r.coord = {v[0], v[1]};
      r.ddx = {v[2], v[3]};
      r.ddy = {v[4], v[5]};
      r.lod_mode = LodMode::kGradient;
    });
    SpecSampler spec(image, state);
    size_t tested = 0;
    for (size_t i = 0; i < count; ++i) {
      spec.near_boundary = false;
      const SpecSample at{
          .coord = {in[0][i], in[1][i]}, .ddx = {in[2][i], in[3][i]}, .ddy = {in[4][i], in[5][i]}, .anisotropic = true};
      const double want = spec.sample(at, 1);
      // Sixteen probes have so many roundings to 1/256 texel that most samples have one that is near: each moves the sum by at
      // most 1/256 of a texel's difference, over the number of probes.
      const double tolerance = spec.near_boundary ? 4.0 / 256 : kTolerance;
      tested += !spec.near_boundary;
      ASSERT_NEAR(std::bit_cast<float>(out[1][i]), want, tolerance) << i << " at most " << most;
    }
    EXPECT_GT(tested, 10u);
  }
}

TEST(SampleDims, GatherFromPlanesAndCubesWithOffsets) {
  std::mt19937 random(kSeed);
  for (const ImageShape& shape : kShapes) {
    if (shape.type != VK_IMAGE_VIEW_TYPE_2D && shape.type != VK_IMAGE_VIEW_TYPE_2D_ARRAY && shape.type < VK_IMAGE_VIEW_TYPE_CUBE)
      continue;
    const bool cube = shape.type == VK_IMAGE_VIEW_TYPE_CUBE || shape.type == VK_IMAGE_VIEW_TYPE_CUBE_ARRAY;
    const TestImage image(shape, random);
    for (int turn = 0; turn < 8; ++turn) {
      TextureState state = random_state(random, shape);
      Floats in = random_inputs(random, shape, 128);
      in.push_back(uniform(random, cube ? 0 : -8, cube ? 0 : 8, 128));
      in.push_back(uniform(random, cube ? 0 : -8, cube ? 0 : 8, 128));
      const uint32_t component = static_cast<uint32_t>(turn) % 4;
      const auto out = run(image, state, in, [&](Builder& b, const std::vector<Value>& v, SampleRequest& r) {
        explicit_request(state)(b, v, r);
        r.lod = b.f32(0);
        r.gather_component = static_cast<int32_t>(component);
        if (cube) return;
        for (uint32_t a = 0; a < 2; ++a) r.dynamic_offset[a] = b.convert(ir::Op::kFToS, Type::kI32, v[6 + a]);
      });
      SpecSampler spec(image, state);
      for (size_t i = 0; i < in[0].size(); ++i) {
        SpecSample at = spec_sample(in, i);
        at.offset = {static_cast<int>(in[6][i]), static_cast<int>(in[7][i])};
        spec.near_boundary = false;
        const auto want = spec.gather(at, component);
        if (spec.near_boundary) continue;
        for (size_t k = 0; k < 4; ++k) {
          ASSERT_NEAR(std::bit_cast<float>(out[k][i]), want[k], kTolerance)
              << "view type " << shape.type << " sample " << i << " texel " << k << " modes " << state.address[0]
              << state.address[1];
        }
      }
    }
  }
}

// NaN, infinities, the largest numbers as coordinates, layers, LODs and gradients: some texel or the border colour, and the
// sanitizer sees no access outside.
TEST(SampleDims, AnyCoordinateGivesATexel) {
  std::mt19937 random(kSeed);
  const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-45f, -0.0f, 0.5f, 65536.0f, -1e9f};
  for (const ImageShape& shape : kShapes) {
    const TestImage image(shape, random);
    for (int turn = 0; turn < 6; ++turn) {
      TextureState state = random_state(random, shape);
      state.anisotropy = turn % 2 == 1;
      Floats in(11, std::vector<float>(160));
      for (auto& array : in) {
        for (float& v : array) v = odd[random() % std::size(odd)];
      }
      const auto out = run(image, state, in, [&](Builder& b, const std::vector<Value>& v, SampleRequest& r) {
        explicit_request(state)(b, v, r);
        if (turn < 3) return;
        r.lod_mode = LodMode::kGradient;
        r.ddx = {v[5], v[6], v[7]};
        r.ddy = {v[8], v[9], v[10]};
        r.bias = v[4];
      });
      for (const auto& component : out) {
        for (const uint32_t bits : component) {
          const float value = std::bit_cast<float>(bits);
          ASSERT_TRUE(value >= 0 && value <= 1.0000002f) << value << " view type " << shape.type;
        }
      }
    }
  }
}

// OpImageQueryLod: the LOD of a quad, from the differences to its first pixel, and the level that it accesses.
TEST(SampleDims, QueriedLod) {
  std::mt19937 random(kSeed);
  for (const auto mipmap_mode : {VK_SAMPLER_MIPMAP_MODE_NEAREST, VK_SAMPLER_MIPMAP_MODE_LINEAR}) {
    const ImageShape shape{.type = VK_IMAGE_VIEW_TYPE_2D_ARRAY, .width = 32, .height = 16, .levels = 4, .layers = 2};
    TestImage image(shape, random);
    image.descriptor.lod_bias = 0.25f;
    image.descriptor.min_lod = -2, image.descriptor.max_lod = 5;
    TextureState state{.format = shape.format, .view_type = shape.type, .mipmap_mode = mipmap_mode};
    const ArrayKernel kernel(2, [&](Builder& b, const std::vector<Value>& words) {
      const Value descriptor = b.load(Type::kPtr, b.draw_ptr(), offsetof(DrawContext, push_constants) + kDescriptorSlot);
      const Value sampler = b.ptr_add(descriptor, b.i32(offsetof(ImageDescriptor, lod_bias)));
      spirv::ImageQuery query{.kind = spirv::ImageQuery::Kind::kLod, .view_type = shape.type};
      query.coord = {b.bitcast(Type::kF32, words[0]), b.bitcast(Type::kF32, words[1])};
      const Result<Channels> answer = query_lod(b, {state, descriptor, sampler}, lod_request(b, query));
      EXPECT_TRUE(answer);
      return std::vector<Value>{(*answer)[0], (*answer)[1]};
    });
    DrawContext draw{};
    const void* descriptor = &image.descriptor;
    std::memcpy(draw.push_constants + kDescriptorSlot, &descriptor, 8);
    std::vector<std::vector<uint32_t>> in(2, std::vector<uint32_t>(256));
    for (auto& array : in) {
      for (uint32_t& bits : array) bits = std::bit_cast<uint32_t>(static_cast<float>(random() / 0x1p32 / (1 << random() % 8)));
    }
    const auto out = kernel(in, draw);
    const auto number = [](uint32_t bits) { return static_cast<double>(std::bit_cast<float>(bits)); };
    for (size_t i = 0; i < 256; ++i) {
      const size_t quad = i & ~size_t{3};
      double rho = 0;
      for (size_t d = 1; d <= 2; ++d) {
        rho = std::max(rho, std::hypot((number(in[0][quad + d]) - number(in[0][quad])) * shape.width,
                                       (number(in[1][quad + d]) - number(in[1][quad])) * shape.height));
      }
      const double lod = std::clamp(std::log2(rho) + 0.25, -2.0, 5.0);
      ASSERT_NEAR(number(out[1][i]), lod, 0x1p-13) << i;
      const double accessed = std::clamp(lod, 0.0, 3.0);
      if (mipmap_mode == VK_SAMPLER_MIPMAP_MODE_LINEAR) {
        ASSERT_NEAR(number(out[0][i]), accessed, 0x1p-13) << i;
      } else if (std::fabs(accessed - std::floor(accessed) - 0.5) > 0.001) {
        ASSERT_EQ(number(out[0][i]), std::ceil(accessed + 0.5) - 1) << i;
      }
    }
  }
}

}  // namespace
}  // namespace pineda::kernels::test
