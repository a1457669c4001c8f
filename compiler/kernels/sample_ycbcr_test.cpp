// YCbCr conversions against the specification's formulas in double: every model, range, chroma location and filter, two and three
// planes.
#include "compiler/kernels/sample_ycbcr.h"

#include <bit>
#include <cmath>

#include "compiler/kernels/test_rig.h"

namespace pineda::kernels::test {
namespace {

using compiler::TextureState;
using ir::Builder;
using ir::Type;
using ir::Value;

constexpr uint32_t kDescriptorSlot = 240, kWidth = 14, kHeight = 10;

struct PlanarImage {
  bool three_planes;
  std::vector<uint8_t> bytes;
  ImageDescriptor descriptor{};

  PlanarImage(bool three, std::mt19937& random) : three_planes(three), bytes(kWidth * kHeight * 2) {
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
    const uint32_t luma = kWidth * kHeight, chroma = luma / 4;
    descriptor.address = reinterpret_cast<uint64_t>(bytes.data());
    descriptor.size_bytes = static_cast<uint32_t>(bytes.size());
    descriptor.width = kWidth, descriptor.height = kHeight, descriptor.depth = 1;
    descriptor.level_count = descriptor.layer_count = 1;
    descriptor.levels[0] = {0, kWidth};
    descriptor.levels[1] = {luma, three ? kWidth / 2 : kWidth};
    descriptor.levels[2] = {luma + chroma, kWidth / 2};
  }
  // c: 0 luma, 1 blue, 2 red
  double texel(uint32_t c, int x, int y) const {
    const int w = static_cast<int>(c == 0 ? kWidth : kWidth / 2), h = static_cast<int>(c == 0 ? kHeight : kHeight / 2);
    x = std::clamp(x, 0, w - 1), y = std::clamp(y, 0, h - 1);
    const uint32_t plane = c == 0 ? 0 : three_planes ? c : 1;
    const uint32_t stride = c > 0 && !three_planes ? 2 : 1, first = c == 2 && !three_planes ? 1 : 0;
    const MipLevel& l = descriptor.levels[plane];
    return bytes[l.offset_bytes + static_cast<uint32_t>(y) * l.row_pitch_bytes + static_cast<uint32_t>(x) * stride + first] /
           255.0;
  }
};

struct Spec {
  const PlanarImage& image;
  const TextureState& state;
  bool near_boundary = false;

  void guard(double x, double phase) {
    const double d = std::fabs(x - std::floor(x) - phase);
    if (std::min(d, 1 - d) < 0.02) near_boundary = true;
  }
  double plane(uint32_t c, double x, double y) {
    const auto& ycbcr = *state.ycbcr;
    double at[2] = {x, y};
    for (int a = 0; a < 2 && c > 0; ++a) {
      const bool cosited = ycbcr.chroma_offset[static_cast<size_t>(a)] == VK_CHROMA_LOCATION_COSITED_EVEN;
      at[a] = 0.5 * (at[a] + (cosited ? 0.5 : 0));
    }
    if ((c == 0 ? state.mag_filter : ycbcr.chroma_filter) == VK_FILTER_NEAREST) {
      guard(at[0], 0), guard(at[1], 0);
      return image.texel(c, static_cast<int>(std::floor(at[0])), static_cast<int>(std::floor(at[1])));
    }
    int i[2];
    double w[2];
    for (int a = 0; a < 2; ++a) {
      const double s = (at[a] - 0.5) * 256;
      guard(s, 0.5);
      const double rounded = std::floor(s + 0.5) / 256;
      i[a] = static_cast<int>(std::floor(rounded));
      w[a] = rounded - i[a];
    }
    const auto row = [&](int j) { return (1 - w[0]) * image.texel(c, i[0], j) + w[0] * image.texel(c, i[0] + 1, j); };
    return (1 - w[1]) * row(i[1]) + w[1] * row(i[1] + 1);
  }
  std::array<double, 3> sample(double u, double v) {
    double y = plane(0, u * kWidth, v * kHeight), cb = plane(1, u * kWidth, v * kHeight), cr = plane(2, u * kWidth, v * kHeight);
    const auto model = state.ycbcr->model;
    if (model == VK_SAMPLER_YCBCR_MODEL_CONVERSION_RGB_IDENTITY) return {cr, y, cb};
    if (state.ycbcr->range == VK_SAMPLER_YCBCR_RANGE_ITU_FULL) {
      cb -= 128.0 / 255, cr -= 128.0 / 255;
    } else {
      y = (y * 255 - 16) / 219, cb = (cb * 255 - 128) / 224, cr = (cr * 255 - 128) / 224;
    }
    switch (model) {  // the matrices of the specification, as they are printed
      case VK_SAMPLER_YCBCR_MODEL_CONVERSION_YCBCR_601:
        return {y + 1.402 * cr, y - 0.202008 / 0.587 * cb - 0.419198 / 0.587 * cr, y + 1.772 * cb};
      case VK_SAMPLER_YCBCR_MODEL_CONVERSION_YCBCR_709:
        return {y + 1.5748 * cr, y - 0.13397432 / 0.7152 * cb - 0.33480248 / 0.7152 * cr, y + 1.8556 * cb};
      case VK_SAMPLER_YCBCR_MODEL_CONVERSION_YCBCR_2020:
        return {y + 1.4746 * cr, y - 0.11156702 / 0.6780 * cb - 0.38737742 / 0.6780 * cr, y + 1.8814 * cb};
      default:
        return {cr, y, cb};
    }
  }
};

TEST(SampleYcbcr, EveryModelRangeLocationAndFilter) {
  std::mt19937 random(kSeed);
  for (uint32_t turn = 0; turn < 5 * 2 * 4 * 2 * 2; ++turn) {
    const PlanarImage image(turn & 1, random);
    compiler::YcbcrState ycbcr{
        .format = image.three_planes ? VK_FORMAT_G8_B8_R8_3PLANE_420_UNORM : VK_FORMAT_G8_B8R8_2PLANE_420_UNORM,
        .model = static_cast<VkSamplerYcbcrModelConversion>(turn / 32),
        .range = static_cast<VkSamplerYcbcrRange>(turn >> 1 & 1),
        .chroma_offset = {static_cast<VkChromaLocation>(turn >> 2 & 1), static_cast<VkChromaLocation>(turn >> 3 & 1)},
        .chroma_filter = static_cast<VkFilter>(turn >> 4 & 1)};
    TextureState state{.format = VK_FORMAT_R8_UNORM, .single_level = true, .mag_filter = ycbcr.chroma_filter};
    state.ycbcr = ycbcr;
    const ArrayKernel kernel(2, [&](Builder& b, const std::vector<Value>& words) {
      const Value descriptor = b.load(Type::kPtr, b.draw_ptr(), offsetof(DrawContext, push_constants) + kDescriptorSlot);
      spirv::SampleRequest r;
      r.view_type = VK_IMAGE_VIEW_TYPE_2D;
      r.lod_mode = spirv::LodMode::kExplicit;
      r.lod = b.f32(0);
      r.coord = {b.bitcast(Type::kF32, words[0]), b.bitcast(Type::kF32, words[1])};
      const Result<Channels> texel = sample_image(b, {state, descriptor, descriptor}, r);
      EXPECT_TRUE(texel) << (texel ? "" : texel.error().text);
      return std::vector<Value>(texel->begin(), texel->end());
    });
    DrawContext draw{};
    const void* descriptor = &image.descriptor;
    std::memcpy(draw.push_constants + kDescriptorSlot, &descriptor, 8);
    std::vector<std::vector<uint32_t>> in(2, std::vector<uint32_t>(64));
    for (auto& array : in) {
      for (uint32_t& bits : array) bits = std::bit_cast<uint32_t>(static_cast<float>(random() / 0x1p32 * 1.2 - 0.1));
    }
    const auto out = kernel(in, draw);
    Spec spec{image, state};
    size_t tested = 0;
    for (size_t i = 0; i < 64; ++i) {
      spec.near_boundary = false;
      const auto want = spec.sample(std::bit_cast<float>(in[0][i]), std::bit_cast<float>(in[1][i]));
      if (spec.near_boundary) continue;
      ++tested;
      // Three products of numbers below two, and matrices that are printed with seven digits.
      for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(std::bit_cast<float>(out[c][i]), want[c], 2e-6) << "turn " << turn;
      ASSERT_EQ(std::bit_cast<float>(out[3][i]), 1.0f);
    }
    EXPECT_GT(tested, 20u);
  }
}

}  // namespace
}  // namespace pineda::kernels::test
