// Sampling against an independent implementation of the specification's formulas in double precision. Where a coordinate lies so
// near to a rounding boundary that binary32 may fall on its other side, the sample is left out.
#include "compiler/kernels/sample.h"

#include <bit>
#include <cmath>

#include "base/half.h"
#include "compiler/kernels/test_rig.h"
#include "cts-subset/reference/wrapping.h"

namespace pineda::kernels::test {
namespace {

using compiler::TextureState;
using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::LodMode;
using spirv::SampleRequest;

// An image with random texels, every level tightly packed.
struct Image {
  const FormatInfo& format;
  uint32_t width, height, levels, layers;
  ImageDescriptor descriptor{};
  std::vector<uint8_t> bytes;

  Image(VkFormat f, uint32_t w, uint32_t h, uint32_t level_count, std::mt19937& random, uint32_t layer_count = 1)
      : format(*find_format(f)), width(w), height(h), levels(level_count), layers(layer_count) {
    uint32_t size = 0;
    for (uint32_t l = 0; l < levels; ++l) {
      descriptor.levels[l] = {.offset_bytes = size, .row_pitch_bytes = level_width(l) * format.texel_bytes};
      size += level_width(l) * level_height(l) * format.texel_bytes;
    }
    descriptor.layer_pitch_bytes = size;
    bytes.resize(size * layers);
    for (size_t at = 0; at < bytes.size(); at += format.texel_bytes) random_texel(&bytes[at], random);
    descriptor.address = reinterpret_cast<uint64_t>(bytes.data());
    descriptor.size_bytes = static_cast<uint32_t>(bytes.size());
    descriptor.width = width, descriptor.height = height, descriptor.depth = 1;
    descriptor.level_count = levels, descriptor.layer_count = layers;
    descriptor.min_lod = -1000, descriptor.max_lod = 1000;
    const float border[4] = {0.25f, 0.5f, 0.125f, 0.75f};
    std::memcpy(descriptor.border, border, sizeof border);
  }

  void random_texel(uint8_t* texel, std::mt19937& random) const {
    if (format.is_float()) {
      VkClearColorValue color;
      for (float& v : color.float32) v = static_cast<float>(random() / 0x1p31 - (format.is_depth() ? 0 : 1));
      if (format.is_depth())
        pack_depth(format, color.float32[0] / 2, texel);
      else
        pack_clear_color(format, color, texel);
      return;
    }
    for (uint32_t i = 0; i < format.texel_bytes; ++i) texel[i] = static_cast<uint8_t>(random());
  }

  uint32_t level_width(uint32_t l) const { return std::max(width >> l, 1u); }
  uint32_t level_height(uint32_t l) const { return std::max(height >> l, 1u); }

  double texel(int x, int y, uint32_t level, uint32_t component, uint32_t layer = 0) const {
    const uint32_t at = layer * descriptor.layer_pitch_bytes + descriptor.levels[level].offset_bytes +
                        (static_cast<uint32_t>(y) * level_width(level) + static_cast<uint32_t>(x)) * format.texel_bytes;
    return decode_texel(format, component, &bytes[at]);
  }
};

double number(const FormatInfo& format, uint32_t bits) {
  if (format.numeric == Numeric::kUint) return bits;
  if (format.numeric == Numeric::kSint) return static_cast<int32_t>(bits);
  return std::bit_cast<float>(bits);
}

// ---- the reference --------------------------------------------------------------------------------------------------------

struct Reference {
  const Image& image;
  const TextureState& state;
  std::array<int, 2> offset{};
  uint32_t layer = 0;
  bool near_boundary = false;  // set when the answer hangs on a rounding
  bool compare = false;
  double depth_reference = 0;

  double tap(int i, int j, uint32_t level, uint32_t c) const {
    const int x = cts::wrapped(state.address[0], i, static_cast<int>(image.level_width(level)));
    const int y = cts::wrapped(state.address[1], j, static_cast<int>(image.level_height(level)));
    const bool absent = image.format.component[c].bits == 0;
    const double value = !absent && (x < 0 || y < 0) ? image.descriptor.border[c]
                         : absent                    ? (c == 3 ? 1.0 : 0.0)
                                                     : image.texel(x, y, level, c, layer);
    if (!compare) return value;
    return depth_reference <= value ? 1 : 0;  // the tests use LESS_OR_EQUAL
  }

  // x in units of 1 / steps: whether it is too near to a boundary at `phase` between integers.
  void guard(double x, double phase) {
    const double f = x - std::floor(x);
    if (std::min(std::fabs(f - phase), 1 - std::fabs(f - phase)) < 0.02) near_boundary = true;
  }

  double level(double u, double v, uint32_t l, VkFilter filter, uint32_t c) {
    double s = u, t = v;
    if (!state.unnormalized) s *= image.level_width(l), t *= image.level_height(l);
    s += offset[0], t += offset[1];
    if (filter == VK_FILTER_NEAREST) {
      guard(s, 0), guard(t, 0);
      return tap(static_cast<int>(std::floor(s)), static_cast<int>(std::floor(t)), l, c);
    }
    s = (s - 0.5) * 256, t = (t - 0.5) * 256;
    guard(s, 0.5), guard(t, 0.5);
    const double sr = std::floor(s + 0.5) / 256, tr = std::floor(t + 0.5) / 256;
    const int i = static_cast<int>(std::floor(sr)), j = static_cast<int>(std::floor(tr));
    const double a = sr - i, b = tr - j;
    return (1 - b) * ((1 - a) * tap(i, j, l, c) + a * tap(i + 1, j, l, c)) +
           b * ((1 - a) * tap(i, j + 1, l, c) + a * tap(i + 1, j + 1, l, c));
  }

  // lod: after bias and clamping to the sampler's range.
  double sample(double u, double v, double lod, uint32_t c) {
    const VkFilter filter = lod <= 0 ? state.mag_filter : state.min_filter;
    if (state.mag_filter != state.min_filter && std::fabs(lod) < 1e-4) near_boundary = true;
    if (state.single_level) return level(u, v, 0, filter, c);
    const double d = std::clamp(lod, 0.0, image.levels - 1.0);
    if (state.mipmap_mode == VK_SAMPLER_MIPMAP_MODE_NEAREST) {
      guard(d, 0.5);
      return level(u, v, static_cast<uint32_t>(std::ceil(d + 0.5) - 1), filter, c);
    }
    if (d > 0 && d < image.levels - 1) guard(d * 256, 0.5);
    const double rounded = std::floor(d * 256 + 0.5) / 256;
    const uint32_t high = static_cast<uint32_t>(rounded), low = std::min(high + 1, image.levels - 1);
    const double first = level(u, v, high, filter, c), fraction = rounded - high;
    return fraction == 0 ? first : first + fraction * (level(u, v, low, filter, c) - first);
  }
};

// ---- running the kernel ---------------------------------------------------------------------------------------------------

constexpr uint32_t kDescriptorSlot = 240;  // push constant bytes that hold the descriptor's address

using Request = std::function<void(Builder&, const std::vector<Value>&, SampleRequest&)>;

// Inputs: floats, as `request` uses them. Outputs: the four components.
std::vector<std::vector<uint32_t>> run(const Image& image, const TextureState& state, const std::vector<std::vector<float>>& in,
                                       const Request& request, eval::Mode mode = eval::Mode::kF32) {
  const ArrayKernel kernel(
      static_cast<uint32_t>(in.size()),
      [&](Builder& b, const std::vector<Value>& words) {
        const Value descriptor = b.load(Type::kPtr, b.draw_ptr(), offsetof(DrawContext, push_constants) + kDescriptorSlot);
        const Value sampler = b.ptr_add(descriptor, b.i32(offsetof(ImageDescriptor, lod_bias)));
        const SampleSource source{state, descriptor, sampler};
        SampleRequest r;
        r.view_type = state.view_type;
        r.result = image.format.is_integer() ? Type::kI32 : Type::kF32;
        std::vector<Value> floats;
        for (const Value v : words) floats.push_back(b.bitcast(Type::kF32, v));
        request(b, floats, r);
        const Result<Channels> texel = sample_image(b, source, r);
        EXPECT_TRUE(texel) << (texel ? "" : texel.error().text);
        return std::vector<Value>(texel->begin(), texel->end());
      },
      mode);
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

const Request kExplicitLod = [](Builder&, const std::vector<Value>& in, SampleRequest& r) {
  r.coord = {in[0], in[1]};
  r.lod = in[2];
  r.lod_mode = LodMode::kExplicit;
};

std::vector<float> uniform(std::mt19937& random, double low, double high, uint32_t count) {
  std::vector<float> x(count);
  for (float& v : x) v = static_cast<float>(low + (high - low) * (random() / 0x1p32));
  return x;
}

// Binary32 sums of a few terms below one; sRGB decoding adds nothing, because its table is exact.
constexpr double kTolerance = 8 * 0x1p-24;

void expect_samples(const Image& image, const TextureState& state, const std::vector<std::vector<float>>& in,
                    const std::vector<std::vector<uint32_t>>& out, const std::function<double(size_t)>& lod,
                    Reference reference) {
  size_t tested = 0;
  for (size_t i = 0; i < in[0].size(); ++i) {
    for (uint32_t c = 0; c < 4; ++c) {
      reference.near_boundary = false;
      const double want = reference.sample(in[0][i], in[1][i], lod(i), c);
      if (reference.near_boundary) continue;
      ++tested;
      const double got = number(image.format, out[c][i]);
      ASSERT_NEAR(got, want, image.format.is_integer() ? 0 : kTolerance)
          << image.format.name << " component " << c << " at " << in[0][i] << ", " << in[1][i] << " lod " << lod(i) << " modes "
          << state.address[0] << " " << state.address[1] << " filters " << state.mag_filter << state.min_filter
          << state.mipmap_mode;
    }
  }
  EXPECT_GT(tested, in[0].size());
}

constexpr VkSamplerAddressMode kModes[] = {VK_SAMPLER_ADDRESS_MODE_REPEAT, VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT,
                                           VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER,
                                           VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE};

TEST(Sample, EveryFilterAndAddressMode) {
  std::mt19937 random(kSeed);
  const Image image(VK_FORMAT_R8G8B8A8_UNORM, 13, 7, 4, random);
  for (int filters = 0; filters < 8; ++filters) {
    for (const VkSamplerAddressMode u : kModes) {
      for (const VkSamplerAddressMode v : kModes) {
        TextureState state{.format = image.format.format,
                           .mag_filter = static_cast<VkFilter>(filters & 1),
                           .min_filter = static_cast<VkFilter>(filters >> 1 & 1),
                           .mipmap_mode = static_cast<VkSamplerMipmapMode>(filters >> 2)};
        state.address = {u, v, u};
        const std::vector<std::vector<float>> in = {uniform(random, -2.5, 3.5, 64), uniform(random, -2.5, 3.5, 64),
                                                    uniform(random, -1, 4, 64)};
        const auto out = run(image, state, in, kExplicitLod);
        expect_samples(image, state, in, out, [&](size_t i) { return in[2][i]; }, {image, state});
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST(Sample, EverySampledFormat) {
  std::mt19937 random(kSeed);
  for (const FormatInfo* format : all_formats()) {
    if (!(format->uses & kUseSampled)) continue;
    const Image image(format->format, 16, 9, 3, random);
    TextureState state{.format = format->format, .mipmap_mode = VK_SAMPLER_MIPMAP_MODE_NEAREST};
    if (format->uses & kUseLinear) {
      state.mag_filter = state.min_filter = VK_FILTER_LINEAR;
      state.mipmap_mode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
    }
    state.address.fill(VK_SAMPLER_ADDRESS_MODE_REPEAT);
    const std::vector<std::vector<float>> in = {uniform(random, -1, 2, 256), uniform(random, -1, 2, 256),
                                                uniform(random, 0, 2, 256)};
    expect_samples(image, state, in, run(image, state, in, kExplicitLod), [&](size_t i) { return in[2][i]; }, {image, state});
    if (HasFatalFailure()) return;
  }
}

TEST(Sample, BilinearOfEightBitTexelsRoundsOnce) {
  std::mt19937 random(kSeed);
  const Image image(VK_FORMAT_R8G8B8A8_UNORM, 32, 32, 1, random);
  TextureState state{
      .format = image.format.format, .single_level = true, .mag_filter = VK_FILTER_LINEAR, .min_filter = VK_FILTER_LINEAR};
  state.address.fill(VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
  std::vector<std::vector<float>> in(3, std::vector<float>(4096));
  for (size_t i = 0; i < 4096; ++i) {  // positions on the 1/256 grid: the weights are exact
    in[0][i] = static_cast<float>(random() % (32 * 256)) / (32 * 256);
    in[1][i] = static_cast<float>(random() % (32 * 256)) / (32 * 256);
  }
  const auto out = run(image, state, in, kExplicitLod);
  for (size_t i = 0; i < 4096; ++i) {
    for (uint32_t c = 0; c < 4; ++c) {
      const double want = Reference{image, state}.level(in[0][i], in[1][i], 0, VK_FILTER_LINEAR, c);
      const float got = std::bit_cast<float>(out[c][i]);
      // The correctly rounded quotient, or its neighbour where the two-part reciprocal is 2^-24 off.
      ASSERT_LE(std::fabs(got - want), 0.5001 * std::ldexp(1.0, std::max(std::ilogb(want), -126) - 23));
    }
  }
}

TEST(Sample, TexelOffsets) {
  std::mt19937 random(kSeed);
  const Image image(VK_FORMAT_R8G8B8A8_UNORM, 5, 3, 1, random);
  for (const VkSamplerAddressMode mode : kModes) {
    for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
      TextureState state{.format = image.format.format, .single_level = true, .mag_filter = filter, .min_filter = filter};
      state.address.fill(mode);
      const std::vector<std::vector<float>> in = {uniform(random, -1.5, 2.5, 128), uniform(random, -1.5, 2.5, 128),
                                                  uniform(random, 0, 0, 128)};
      const auto out = run(image, state, in, [](Builder&, const std::vector<Value>& v, SampleRequest& r) {
        r.coord = {v[0], v[1]};
        r.offset = {-7, 4, 0};
      });
      expect_samples(image, state, in, out, [](size_t) { return 0; }, {.image = image, .state = state, .offset = {-7, 4}});
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Sample, ImplicitLodBiasAndClamps) {
  std::mt19937 random(kSeed);
  const Image base(VK_FORMAT_R8G8B8A8_UNORM, 64, 32, 7, random);
  for (const bool biased : {false, true}) {
    Image image = base;
    image.descriptor.address = reinterpret_cast<uint64_t>(image.bytes.data());
    image.descriptor.lod_bias = biased ? -0.4f : 0;
    image.descriptor.min_lod = biased ? 0.75f : -1000;
    image.descriptor.max_lod = biased ? 3.5f : 1000;
    TextureState state{.format = image.format.format,
                       .mag_filter = VK_FILTER_NEAREST,
                       .min_filter = VK_FILTER_LINEAR,
                       .mipmap_mode = VK_SAMPLER_MIPMAP_MODE_LINEAR};
    state.address.fill(VK_SAMPLER_ADDRESS_MODE_REPEAT);
    // Quads with random slopes: lanes 0, 1, 2, 3 at (0, 0), (1, 0), (0, 1), (1, 1).
    constexpr size_t kCount = 1024;
    std::vector<std::vector<float>> in(3, std::vector<float>(kCount));
    std::vector<double> lod(kCount);
    for (size_t q = 0; q < kCount; q += 4) {
      const double size = std::exp2(random() / 0x1p32 * 9 - 8), angle = random() / 0x1p32 * 6.28, u0 = random() / 0x1p32,
                   v0 = random() / 0x1p32;
      for (size_t i = 0; i < 4; ++i) {
        in[0][q + i] = static_cast<float>(u0 + size * ((i & 1) * std::cos(angle) - (i >> 1) * std::sin(angle)));
        in[1][q + i] = static_cast<float>(v0 + size * ((i & 1) * std::sin(angle) + (i >> 1) * 0.3));
        in[2][q + i] = biased ? 0.3f : 0;
      }
      double rho = 0;
      for (const size_t other : {q + 1, q + 2}) {
        rho = std::max(rho, std::hypot((static_cast<double>(in[0][other]) - in[0][q]) * 64,
                                       (static_cast<double>(in[1][other]) - in[1][q]) * 32));
      }
      const double biased_lod = std::log2(rho) + image.descriptor.lod_bias + in[2][q];
      for (size_t i = 0; i < 4; ++i)
        lod[q + i] = std::clamp<double>(biased_lod, image.descriptor.min_lod, image.descriptor.max_lod);
    }
    const auto out = run(image, state, in, [&](Builder&, const std::vector<Value>& v, SampleRequest& r) {
      r.coord = {v[0], v[1]};
      if (biased) r.bias = v[2];
      r.lod_mode = LodMode::kImplicit;
    });
    expect_samples(image, state, in, out, [&](size_t i) { return lod[i]; }, {image, state});
    // The same slopes given explicitly.
    std::vector<std::vector<float>> gradients = in;
    gradients.resize(6, std::vector<float>(kCount));
    for (size_t i = 0; i < kCount; ++i) {
      const size_t q = i & ~3u;
      gradients[2][i] = in[0][q + 1] - in[0][q], gradients[3][i] = in[1][q + 1] - in[1][q];
      gradients[4][i] = in[0][q + 2] - in[0][q], gradients[5][i] = in[1][q + 2] - in[1][q];
    }
    const auto graded = run(image, state, gradients, [](Builder&, const std::vector<Value>& v, SampleRequest& r) {
      r.coord = {v[0], v[1]};
      r.lod_mode = LodMode::kGradient;
      r.ddx = {v[2], v[3]};
      r.ddy = {v[4], v[5]};
    });
    if (!biased) {
      EXPECT_EQ(graded, out);
    }
  }
}

TEST(Sample, DepthComparison) {
  std::mt19937 random(kSeed);
  for (const VkFormat format : {VK_FORMAT_D16_UNORM, VK_FORMAT_X8_D24_UNORM_PACK32, VK_FORMAT_D32_SFLOAT}) {
    const Image image(format, 8, 8, 1, random);
    TextureState state{.format = format,
                       .single_level = true,
                       .mag_filter = VK_FILTER_LINEAR,
                       .min_filter = VK_FILTER_LINEAR,
                       .compare_enable = true,
                       .compare = VK_COMPARE_OP_LESS_OR_EQUAL};
    state.address.fill(VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
    const std::vector<std::vector<float>> in = {uniform(random, 0, 1, 256), uniform(random, 0, 1, 256),
                                                uniform(random, 0, 1, 256)};
    const auto out = run(image, state, in, [](Builder&, const std::vector<Value>& v, SampleRequest& r) {
      r.coord = {v[0], v[1]};
      r.depth_reference = v[2];
    });
    for (size_t i = 0; i < 256; ++i) {
      Reference reference{.image = image, .state = state, .compare = true, .depth_reference = in[2][i]};
      const double want = reference.level(in[0][i], in[1][i], 0, VK_FILTER_LINEAR, 0);
      if (!reference.near_boundary) {
        ASSERT_EQ(std::bit_cast<float>(out[0][i]), want);
      }
    }
  }
}

TEST(Sample, GatherTakesTheFootprintCounterClockwise) {
  std::mt19937 random(kSeed);
  const Image image(VK_FORMAT_R8G8B8A8_UNORM, 6, 5, 1, random);
  TextureState state{.format = image.format.format, .swizzle = {2, 1, 0, 5}, .single_level = true};
  state.address.fill(VK_SAMPLER_ADDRESS_MODE_REPEAT);
  const std::vector<std::vector<float>> in = {uniform(random, -1, 2, 128), uniform(random, -1, 2, 128)};
  for (int component = 0; component < 4; ++component) {
    const auto out = run(image, state, in, [&](Builder&, const std::vector<Value>& v, SampleRequest& r) {
      r.coord = {v[0], v[1]};
      r.gather_component = component;
    });
    for (size_t i = 0; i < 128; ++i) {
      Reference reference{image, state};
      const double s = in[0][i] * 6.0 - 0.5, t = in[1][i] * 5.0 - 0.5;
      reference.guard(s, 0), reference.guard(t, 0);
      if (reference.near_boundary) continue;
      const int x = static_cast<int>(std::floor(s)), y = static_cast<int>(std::floor(t));
      const int dx[4] = {0, 1, 1, 0}, dy[4] = {1, 1, 0, 0};
      for (uint32_t k = 0; k < 4; ++k) {
        const double want = component == 3 ? 1 : reference.tap(x + dx[k], y + dy[k], 0, state.swizzle[component]);
        ASSERT_NEAR(std::bit_cast<float>(out[k][i]), want, 0x1p-25);
      }
    }
  }
}

TEST(Sample, FetchIsBounded) {
  std::mt19937 random(kSeed);
  for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R32G32B32A32_UINT, VK_FORMAT_R16_SFLOAT}) {
    const Image image(format, 6, 5, 3, random, 2);
    const TextureState state{.format = format, .view_type = VK_IMAGE_VIEW_TYPE_2D_ARRAY};
    std::vector<std::vector<float>> in(4, std::vector<float>(2000));
    for (size_t i = 0; i < 2000; ++i) {
      const int v[4] = {static_cast<int>(random() % 10) - 2, static_cast<int>(random() % 9) - 2,
                        static_cast<int>(random() % 4) - 1, static_cast<int>(random() % 5) - 1};
      for (uint32_t k = 0; k < 4; ++k)
        in[k][i] = std::bit_cast<float>(i % 16 == 0 ? static_cast<uint32_t>(random()) : static_cast<uint32_t>(v[k]));
    }
    const auto out = run(image, state, in, [](Builder& b, const std::vector<Value>& v, SampleRequest& r) {
      for (uint32_t k = 0; k < 3; ++k) r.coord[k] = b.bitcast(Type::kI32, v[k]);
      r.lod = b.bitcast(Type::kI32, v[3]);
      r.lod_mode = LodMode::kFetch;
    });
    for (size_t i = 0; i < 2000; ++i) {
      const auto word = [&](uint32_t k) { return std::bit_cast<uint32_t>(in[k][i]); };
      const uint32_t level = word(3);
      const bool inside = level < 3 && word(2) < 2 && word(0) < image.level_width(level) && word(1) < image.level_height(level);
      for (uint32_t c = 0; c < 4; ++c) {
        const double absent = image.format.component[c].bits == 0 && c == 3 ? 1 : 0;
        const double want =
            inside ? image.texel(static_cast<int>(word(0)), static_cast<int>(word(1)), level, c, word(2)) : absent;
        const double got = number(image.format, out[c][i]);
        ASSERT_NEAR(got, want, image.format.is_integer() ? 0 : 0x1p-24);
      }
    }
  }
}

TEST(Sample, NullImageAndWildCoordinatesReadNothing) {
  std::mt19937 random(kSeed);
  Image image(VK_FORMAT_R8G8B8A8_UNORM, 8, 8, 4, random);
  std::vector<std::vector<float>> in(3, std::vector<float>(1024));
  for (auto& array : in) {
    for (float& v : array) v = std::bit_cast<float>(static_cast<uint32_t>(random()));  // NaN and infinities among them
  }
  for (const VkSamplerAddressMode mode : kModes) {
    TextureState state{.format = image.format.format,
                       .mag_filter = VK_FILTER_LINEAR,
                       .min_filter = VK_FILTER_NEAREST,
                       .mipmap_mode = VK_SAMPLER_MIPMAP_MODE_LINEAR};
    state.address.fill(mode);
    for (const auto& channel : run(image, state, in, kExplicitLod)) {
      for (const uint32_t bits : channel) ASSERT_TRUE(std::bit_cast<float>(bits) >= 0 && std::bit_cast<float>(bits) <= 1);
    }
    Image null = image;
    null.descriptor = {};
    for (const auto& channel : run(null, state, in, kExplicitLod)) {
      for (const uint32_t bits : channel) ASSERT_EQ(bits, 0u);
    }
  }
}

TEST(Sample, UnnormalizedCoordinates) {
  std::mt19937 random(kSeed);
  const Image image(VK_FORMAT_R8G8B8A8_UNORM, 9, 6, 1, random);
  for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
    TextureState state{.format = image.format.format, .mag_filter = filter, .min_filter = filter, .unnormalized = true};
    state.address.fill(VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER);
    const std::vector<std::vector<float>> in = {uniform(random, -2, 11, 256), uniform(random, -2, 8, 256),
                                                uniform(random, 0, 0, 256)};
    expect_samples(image, state, in, run(image, state, in, kExplicitLod), [](size_t) { return 0; }, {image, state});
  }
}

TEST(Sample, UnsupportedViewsAreErrors) {
  ir::Kernel kernel;
  Builder b(kernel);
  const TextureState state{.format = VK_FORMAT_R8G8B8A8_UNORM, .view_type = VK_IMAGE_VIEW_TYPE_CUBE};
  const Result<Channels> texel = sample_image(b, {state, b.draw_ptr(), b.draw_ptr()}, {});
  ASSERT_FALSE(texel);
  EXPECT_FALSE(texel.error().text.empty());
}

}  // namespace
}  // namespace pineda::kernels::test
