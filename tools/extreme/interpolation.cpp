#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "shaders/extreme_coordinates_comp.h"
#include "shaders/extreme_derivative_frag.h"
#include "shaders/extreme_lod_comp.h"
#include "shaders/extreme_smooth_frag.h"
#include "tools/error.h"
#include "tools/extreme/rig.h"

namespace pineda::tools {
namespace {

constexpr RigTarget kFloats{.colour = VK_FORMAT_R32G32B32A32_SFLOAT, .bytes_per_pixel = 16};
constexpr double kUlp = 0x1p-23;

struct Worst {
  double error = 0, bound = 0;
  void take(double error_here, double bound_here) {
    if (error_here * bound >= error * bound_here) error = error_here, bound = bound_here;
    wrong |= !(error_here <= bound_here);
    exact &= error_here == 0;
  }
  bool wrong = false, exact = true;
  Verdict verdict() const { return wrong ? Verdict::kWrong : exact ? Verdict::kExact : Verdict::kWithin; }
};

// A plane seen in perspective: u = distance along it, 1 at the near edge and 10^6 at the far one.
Outcome perspective(ExtremeRig& rig) {
  constexpr float kFar = 1e6f;
  const auto at = [](float x, float y, float w) { return RigVertex{{x * w, y * w, 0, w}, {w, x * w, 1, 0.1f}}; };
  const std::array<RigVertex, 3> halves[] = {{at(-1, -1, 1), at(1, -1, 1), at(-1, 1, kFar)},
                                             {at(-1, 1, kFar), at(1, -1, 1), at(1, 1, kFar)}};
  Worst worst;
  std::string bytes;
  for (size_t first = 0; first < 3; ++first) {  // each vertex in turn, as a driver may interpolate from one of them
    RigDraw draw{.fragment = extreme_smooth_frag};
    for (const auto& half : halves) {
      for (size_t i = 0; i < 3; ++i) draw.vertices.push_back(half[(first + i) % 3]);
    }
    const std::vector<float> picture = rig.draw_as<float>(kFloats, std::span(&draw, 1));
    bytes += bytes_of(picture);
    for (int y = 0; y < 64; ++y) {
      // 1 / u is linear between 1 and 10^-6 in screen space.
      const auto truth = [](double row) { return 1 / (1 + (row / 64) * (1e-6 - 1)); };
      const double u = truth(y + 0.5), gradient = std::abs(truth(y + 0.6) - truth(y + 0.4)) / 0.2;
      for (int x = 0; x < 64; ++x) {
        worst.take(std::abs(picture[static_cast<size_t>(4 * (64 * y + x))] - u), gradient / 512 + 4 * 0x1p-24 * u);
      }
    }
  }
  return {.verdict = worst.verdict(),
          .measured = fmt::format("largest error {:.2e}", worst.error),
          .truth = "1 / (1 + t (1e-6 - 1))",
          .bound = fmt::format("{:.2e} there: a vertex moved by 1/512 px, and 2 ULP", worst.bound),
          .bytes = bytes};
}

// The position as a varying, over slanted strips so thin that moving a vertex to the grid of 1/256 px changes their shape: a
// driver that weighs the unmoved vertices extrapolates where only the moved strip covers a pixel.
Outcome slivers(ExtremeRig& rig) {
  constexpr int kStrips = 20000;
  constexpr float kSlant = 0.37f;
  RigDraw draw{.fragment = extreme_smooth_frag};
  const auto at = [](float x, float y) { return RigVertex{{x, y, 0, 1}, {x, y, 1, 0.1f}}; };
  const auto edge = [](int i) { return static_cast<float>(3.2 * i / kStrips - 1.6); };
  for (int i = 0; i < kStrips; ++i) {
    const RigVertex corners[] = {at(edge(i) - kSlant, -1.5f), at(edge(i + 1) - kSlant, -1.5f), at(edge(i) + kSlant, 1.5f),
                                 at(edge(i + 1) + kSlant, 1.5f)};
    for (const int corner : {0, 1, 2, 2, 1, 3}) draw.vertices.push_back(corners[corner]);
  }
  const std::vector<float> picture = rig.draw_as<float>(kFloats, std::span(&draw, 1));
  Worst worst;
  for (size_t pixel = 0; pixel < picture.size() / 4; ++pixel) {
    const size_t place[] = {pixel % 64, pixel / 64};
    for (const size_t axis : {0u, 1u}) {
      const double there_px = 32 * (double{picture[4 * pixel + axis]} + 1);
      worst.take(std::abs(there_px - (static_cast<double>(place[axis]) + 0.5)), 1);
    }
  }
  return {.verdict = worst.verdict(),
          .measured = fmt::format("largest error {:.2e} px", worst.error),
          .truth = "the pixel's centre",
          .bound = "the value of a neighbouring pixel; a vertex moved by 1/512 px makes 1.95e-03 px",
          .bytes = bytes_of(picture)};
}

// A varying that is the same at every vertex is that everywhere, whatever the perspective.
Outcome constant_varying(ExtremeRig& rig) {
  const auto at = [](float x, float y, float w) { return RigVertex{{x * w, y * w, 0, w}, {0.1f, 1e30f, -1e-30f, 1}}; };
  const RigDraw draws[] = {
      {.vertices = {at(-1.7f, -1.3f, 0.37f), at(5.1f, -1.9f, 911), at(-1.1f, 5.3f, 17.7f)}, .fragment = extreme_smooth_frag}};
  const std::vector<float> picture = rig.draw_as<float>(kFloats, draws);
  Worst worst;
  for (size_t i = 0; i < picture.size(); ++i) {
    const double truth = std::array<double, 4>{0.1f, 1e30f, -1e-30f, 1}[i % 4];
    worst.take(std::abs(picture[i] - truth) / std::abs(truth), 8 * kUlp);
  }
  return {.verdict = worst.verdict(),
          .measured = fmt::format("largest relative error {:.2e}", worst.error),
          .truth = "0.1, 1e30, -1e-30, 1",
          .bound = "8 ULP",
          .bytes = bytes_of(picture)};
}

Outcome derivatives(ExtremeRig& rig, float slope) {
  const auto at = [slope](float x, float y) { return RigVertex{{x, y, 0, 1}, {x * slope, y * slope, slope, 0}}; };
  const RigDraw draws[] = {
      {.vertices = {at(-1, -1), at(1, -1), at(-1, 1), at(-1, 1), at(1, -1), at(1, 1)}, .fragment = extreme_derivative_frag}};
  const std::vector<float> picture = rig.draw_as<float>(kFloats, draws);
  Worst worst;
  const double truth = double{slope} / 32;  // 64 px are 2 units
  for (size_t i = 0; i < picture.size(); i += 4) {
    // Two values of at most `slope`, each within a few units in the last place.
    for (const size_t channel : {0u, 1u}) worst.take(std::abs(picture[i + channel] - truth) / truth, 4 * 32 * kUlp);
    worst.take(std::abs(double{picture[i + 3]}) / truth, 4 * 32 * kUlp);  // fwidth of a constant
  }
  return {.verdict = worst.verdict(),
          .measured = fmt::format("largest relative error {:.2e}", worst.error),
          .truth = fmt::format("{:g} in each direction, 0 of a constant", truth),
          .bound = "4 ULP of the largest value",
          .bytes = bytes_of(picture)};
}

Outcome derivatives_tiny(ExtremeRig& rig) { return derivatives(rig, 1e-20f); }
Outcome derivatives_one(ExtremeRig& rig) { return derivatives(rig, 1); }
Outcome derivatives_huge(ExtremeRig& rig) { return derivatives(rig, 1e20f); }
Outcome derivatives_largest(ExtremeRig& rig) { return derivatives(rig, 1e38f); }

// ---- textures
// ----------------------------------------------------------------------------------------------------------------------

constexpr uint32_t kLevels = 11;

// The level's number in every texel: a trilinear sample is the level of detail.
Outcome lod(ExtremeRig& rig) {
  if (!rig.has_format(VK_FORMAT_R32_SFLOAT, VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT)) return {};
  const Texture texture = create_texture(
      rig.context(), {.extent = {1u << (kLevels - 1), 1u << (kLevels - 1), 1}, .levels = kLevels, .format = VK_FORMAT_R32_SFLOAT},
      [](const TexelPlace& place) { return std::bit_cast<uint32_t>(static_cast<float>(place.level)); });
  const SamplerHandle sampler = create_sampler(rig.context(), {.magFilter = VK_FILTER_LINEAR,
                                                               .minFilter = VK_FILTER_LINEAR,
                                                               .mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                                               .maxLod = VK_LOD_CLAMP_NONE});
  std::vector<std::array<float, 4>> gradients;  // du/dx, dv/dx, du/dy, dv/dy
  for (int tenth = -200; tenth <= 200; ++tenth) {
    const float g = static_cast<float>(std::pow(10.0, tenth / 10.0));
    // Both alike; either the longer one; none in one direction.
    for (const auto& [x, y] : {std::pair{g, g}, {g, g * 0x1p-10f}, {g * 0x1p-10f, g}, {-g, 0.0f}, {0.0f, -g}}) {
      gradients.push_back({x, 0, 0, y});
    }
  }
  const RigTexture bound{texture, sampler};
  const std::vector<float> levels =
      rig.compute_as<float>(extreme_lod_comp, gradients, gradients.size(), static_cast<uint32_t>(gradients.size()), &bound);
  const double step = 1.0 / (1u << rig.limits().mipmapPrecisionBits);
  Worst worst;
  size_t first_wrong = levels.size();
  for (size_t i = 0; i < levels.size(); ++i) {
    const double longer = std::max(std::abs(double{gradients[i][0]}), std::abs(double{gradients[i][3]}));
    const double truth = std::clamp(std::log2(longer * (1 << (kLevels - 1))), 0.0, kLevels - 1.0);
    worst.take(std::abs(levels[i] - truth), step);
    if (!(std::abs(levels[i] - truth) <= step)) first_wrong = std::min(first_wrong, i);
  }
  std::string measured = fmt::format("largest error {:.2e} levels", worst.error);
  if (first_wrong < levels.size()) {
    measured += fmt::format("; level {:g} for gradients of {:g} and {:g}", levels[first_wrong], gradients[first_wrong][0],
                            gradients[first_wrong][3]);
  }
  return {.verdict = worst.verdict(),
          .measured = measured,
          .truth = "log2 of the longer gradient in texels, clamped to the levels there are",
          .bound = fmt::format("{:.2e} (mipmapPrecisionBits)", step),
          .bytes = bytes_of(levels)};
}

Outcome coordinates(ExtremeRig& rig, VkSamplerAddressMode mode, bool defined) {
  constexpr uint32_t kTexels = 64;
  const Texture texture = create_texture(rig.context(), {.extent = {kTexels, 1, 1}, .format = VK_FORMAT_R8G8B8A8_UNORM},
                                         [](const TexelPlace& place) { return place.x; });
  const SamplerHandle sampler =
      create_sampler(rig.context(), {.addressModeU = mode, .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE});
  std::vector<float> places;
  if (defined) {
    // Every one a multiple of 1/16, so exactly a texel's left edge: floor() decides without rounding.
    for (const float base : {0.0f, 1e3f, 1e6f, 1048575.0f, -1e6f, -1048576.0f}) {
      for (int i = 0; i < 48; ++i) places.push_back(base + static_cast<float>(i) / 16);
    }
    for (const float whole : {0x1p24f, 0x1p31f, 0x1p32f, 0x1p62f, -0x1p63f, 1e20f, -1e30f})
      places.push_back(whole);  // whole turns
  } else {
    for (const float odd : {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                            std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::max(), 1e-45f}) {
      places.push_back(odd);
    }
  }
  const RigTexture bound{texture, sampler};
  const std::vector<float> texels =
      rig.compute_as<float>(extreme_coordinates_comp, places, places.size(), static_cast<uint32_t>(places.size()), &bound);
  size_t differing = 0, beyond = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    const double got = std::round(255.0 * texels[i]);
    if (!defined) {
      beyond += !(got >= 0 && got < kTexels);
      continue;
    }
    double texel = std::floor(double{places[i]} * kTexels);
    if (mode == VK_SAMPLER_ADDRESS_MODE_REPEAT) texel -= std::floor(texel / kTexels) * kTexels;
    if (mode == VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT) {
      texel -= std::floor(texel / (2 * kTexels)) * 2 * kTexels;
      if (texel >= kTexels) texel = 2 * kTexels - 1 - texel;
    }
    if (mode == VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE) texel = std::clamp(texel, 0.0, kTexels - 1.0);
    differing += got != texel;
    const double apart = std::abs(got - texel);
    beyond += std::min(apart, kTexels - apart) > 1;
  }
  return {.verdict = beyond                  ? Verdict::kWrong
                     : differing || !defined ? Verdict::kWithin
                                             : Verdict::kExact,
          .measured = defined ? fmt::format("{} of {} texels differ", differing, places.size())
                              : fmt::format("{} outside the texture", beyond),
          .truth = defined ? "floor(64 u), wrapped" : "any texel of the texture",
          .bound = defined ? "the neighbouring texel" : "a texel of the texture",
          .bytes = bytes_of(texels)};
}

Outcome coordinates_repeat(ExtremeRig& rig) { return coordinates(rig, VK_SAMPLER_ADDRESS_MODE_REPEAT, true); }
Outcome coordinates_mirror(ExtremeRig& rig) { return coordinates(rig, VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT, true); }
Outcome coordinates_clamp(ExtremeRig& rig) { return coordinates(rig, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE, true); }
Outcome coordinates_odd(ExtremeRig& rig) { return coordinates(rig, VK_SAMPLER_ADDRESS_MODE_REPEAT, false); }

constexpr const char* kAttributes =
    "exact perspective interpolation; Vulkan 1.3, Basic Polygon Rasterization (its rounding is the implementation's)";
constexpr const char* kDerivatives = "Vulkan 1.3, Derivative Operations: differences of neighbouring fragments";
constexpr const char* kLod = "Vulkan 1.3, Scale Factor Operation, LOD Operation and Image Level Selection";
constexpr const char* kWrapping = "Vulkan 1.3, Wrapping Operation, Integer Texel Coordinate Operations";

constexpr ExtremeCase kCases[] = {
    {"interpolation", "perspective 10^6 : 1", "The distance along a plane seen from 1 to 10^6, from each vertex on", kAttributes,
     perspective},
    {"interpolation", "slivers", "The position as a varying of 20,000 slanted strips of 0.005 px", kAttributes, slivers},
    {"interpolation", "constant varying", "Equal values at all vertices, w from 0.37 to 911", kAttributes, constant_varying},
    {"interpolation", "derivatives of 10^-20", "dFdx, dFdy of a linear varying; fwidth of a constant", kDerivatives,
     derivatives_tiny},
    {"interpolation", "derivatives of 1", "The same", kDerivatives, derivatives_one},
    {"interpolation", "derivatives of 10^20", "The same", kDerivatives, derivatives_huge},
    {"interpolation", "derivatives of 10^38", "The same, next to overflow", kDerivatives, derivatives_largest},
    {"interpolation", "LOD from 10^-20 to 10^20",
     "textureGrad of 2,005 gradients in a texture whose texels are their level's number", kLod, lod},
    {"interpolation", "coordinates of 10^6 and more, repeat", "Nearest texels at places that binary32 holds exactly", kWrapping,
     coordinates_repeat},
    {"interpolation", "coordinates of 10^6 and more, mirrored", "The same", kWrapping, coordinates_mirror},
    {"interpolation", "coordinates of 10^6 and more, clamped", "The same", kWrapping, coordinates_clamp},
    {"interpolation", "coordinates that are no number", "Infinity, NaN, 3.4e38, 1e-45: some texel, no crash", kWrapping,
     coordinates_odd},
};

}  // namespace

std::span<const ExtremeCase> interpolation_cases() { return kCases; }

}  // namespace pineda::tools
