#include <algorithm>
#include <cmath>
#include <random>

#include "tools/error.h"
#include "tools/extreme/rig.h"

namespace pineda::tools {
namespace {

constexpr double kNear = 1, kFar = 1e7;
// Relative, of a depth: z * (1 / w), the viewport's transformation and interpolation, each a few roundings in binary32. The
// specification leaves them to the implementation; this is what a careful one stays within.
constexpr double kRounding = 16 * 0x1p-24;
constexpr uint32_t kCells = 64;  // a side: each pixel is one pair of surfaces

struct Depth {
  VkFormat format;
  bool reversed;
  // The step of the format at a depth: what it cannot tell apart.
  double step(double depth) const {
    if (format == VK_FORMAT_D16_UNORM) return 1.0 / 65535;
    if (format != VK_FORMAT_D32_SFLOAT) return 1.0 / 16777215;
    int exponent = 0;
    std::frexp(std::max(depth, 0x1p-126), &exponent);
    return std::ldexp(1.0, exponent - 24);
  }
  double round(double depth) const {
    if (format == VK_FORMAT_D32_SFLOAT) return static_cast<float>(depth);
    return std::nearbyint(depth / step(depth));
  }
};

bool lacks(const ExtremeRig& rig, VkFormat format) {
  return !rig.has_format(format, VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT);
}

constexpr VkFormat kD16 = VK_FORMAT_D16_UNORM, kD24 = VK_FORMAT_X8_D24_UNORM_PACK32, kD32 = VK_FORMAT_D32_SFLOAT;

VkFormat d24(const ExtremeRig& rig) { return lacks(rig, kD24) ? VK_FORMAT_D24_UNORM_S8_UINT : kD24; }

// The perspective of near : far = 1 : 10^7 as binary32 gives it to the driver; what the driver gets is what the truth starts
// from.
std::array<float, 4> project(float x, float y, float distance, bool reversed) {
  const double a = reversed ? -kNear / (kFar - kNear) : kFar / (kFar - kNear);
  const double b = kFar * kNear / (kFar - kNear);
  const double z = reversed ? a * distance + b : a * distance - b;
  return {x * distance, y * distance, static_cast<float>(z), distance};
}

double true_depth(const std::array<float, 4>& place) { return double{place[2]} / double{place[3]}; }

// A pair of surfaces at each pixel, at distances that are spread evenly over the magnitudes; drawn in either order.
Outcome ordering(ExtremeRig& rig, Depth depth) {
  if (lacks(rig, depth.format)) return {};
  std::mt19937 random(77);
  const auto uniform = [&] { return static_cast<double>(random() >> 8) / 16777216.0; };
  RigDraw draw{.depth_test = true, .compare = depth.reversed ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_LESS};
  std::vector<std::array<double, 2>> depths;
  std::vector<std::array<float, 2>> distances;
  for (uint32_t cell = 0; cell < kCells * kCells; ++cell) {
    const auto edge = [](uint32_t i) { return static_cast<float>(2.0 * i / kCells - 1); };
    const uint32_t x = cell % kCells, y = cell / kCells;
    const double first = std::pow(10.0, 7 * uniform());
    const double gap = std::pow(10.0, -6 * uniform());  // relative: 1 to 10^-6
    const float pair[] = {static_cast<float>(first), static_cast<float>(std::min(first * (1 + gap), kFar))};
    const bool swapped = random() & 1;
    std::array<double, 2> pair_depths{};
    for (int k = 0; k < 2; ++k) {
      const int which = swapped ? 1 - k : k;
      const std::array<float, 4> colour{which == 0 ? 1.0f : 0.0f, 0, 0, 0};
      const auto corner = [&](uint32_t i, uint32_t j) {
        return RigVertex{project(edge(x + i), edge(y + j), pair[which], depth.reversed), colour};
      };
      pair_depths[static_cast<size_t>(which)] = true_depth(corner(0, 0).place);
      for (const auto& [i, j] : {std::pair{0u, 0u}, {1u, 0u}, {0u, 1u}, {0u, 1u}, {1u, 0u}, {1u, 1u}})
        draw.vertices.push_back(corner(i, j));
    }
    depths.push_back(pair_depths);
    distances.push_back({pair[0], pair[1]});
  }
  const RigTarget target{.extent = {kCells, kCells}, .depth = depth.format, .clear_depth = depth.reversed ? 0.0f : 1.0f};
  const std::vector<float> winners = rig.draw_as<float>(target, std::span(&draw, 1));

  size_t wrong = 0, unexcused = 0, drawn = 0;
  for (size_t cell = 0; cell < winners.size(); ++cell) {
    if (distances[cell][0] == distances[cell][1]) continue;
    ++drawn;
    if (winners[cell] == 1) continue;  // the nearer one, red, is in front
    ++wrong;
    // Both depths may be off by a step of the format and by the rounding of the division and of the viewport's transformation.
    const double allowed = 2 * depth.step(depths[cell][0]) + kRounding * std::max(depths[cell][0], depths[cell][1]);
    unexcused += std::abs(depths[cell][0] - depths[cell][1]) > allowed;
  }
  return {.verdict = unexcused ? Verdict::kWrong
                     : wrong   ? Verdict::kWithin
                               : Verdict::kExact,
          .measured = fmt::format("{:.2f} % of {} pairs ordered wrongly",
                                  100.0 * static_cast<double>(wrong) / static_cast<double>(drawn), drawn),
          .truth = "0 %",
          .bound = "only pairs nearer than two steps of the format and 8 ULP of binary32",
          .bytes = bytes_of(winners)};
}

// kD24 stands for the one of its two formats that there is.
template <VkFormat kFormat, bool kReversed>
Outcome ordering(ExtremeRig& rig) {
  return ordering(rig, {kFormat == kD24 ? d24(rig) : kFormat, kReversed});
}

// Two planes that cross in a line through the middle of the picture, the angle between them small.
struct Crossing {
  static constexpr uint32_t kSide = 160;
  std::array<RigDraw, 2> draws;
  double flat, left, right;  // depths: of the first plane, and of the second one at the picture's sides

  Crossing(float distance, bool reversed) {
    constexpr float kTilt = 0.002f;
    const auto plane = [&](float at_left, float at_right, float red) {
      const auto corner = [&](float x, float y) {
        return RigVertex{project(x, y, x < 0 ? at_left : at_right, reversed), {red, 0, 0, 0}};
      };
      return RigDraw{.vertices = {corner(-1, -1), corner(1, -1), corner(-1, 1), corner(-1, 1), corner(1, -1), corner(1, 1)},
                     .depth_test = true,
                     .compare = reversed ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_LESS};
    };
    draws = {plane(distance, distance, 1), plane(distance * (1 - kTilt), distance * (1 + kTilt), 2)};
    flat = true_depth(draws[0].vertices[0].place);
    left = true_depth(draws[1].vertices[0].place);
    right = true_depth(draws[1].vertices[1].place);
  }
  // 1 / distance is linear in screen space, and so is depth.
  double tilted(uint32_t x) const { return left + (x + 0.5) / kSide * (right - left); }
};

// A picture of z-fighting; and how much of it there is over several distances, because what one distance shows is the luck of
// how its three depths round.
Outcome crossing(ExtremeRig& rig, Depth depth) {
  if (lacks(rig, depth.format)) return {};
  constexpr uint32_t kSide = Crossing::kSide;
  constexpr int kDistances = 16;
  Image picture{.width = kSide, .height = kSide, .rgba = std::vector<uint8_t>(size_t{4} * kSide * kSide, 255)};
  size_t wrong = 0, unexcused = 0, wrong_columns = 0;
  std::string bytes;
  for (int i = 0; i < kDistances; ++i) {
    const Crossing planes(2000 * static_cast<float>(std::exp2(i / 8.0)), depth.reversed);
    const RigTarget target{.extent = {kSide, kSide}, .depth = depth.format, .clear_depth = depth.reversed ? 0.0f : 1.0f};
    const std::vector<float> winners = rig.draw_as<float>(target, planes.draws);
    bytes += bytes_of(winners);
    for (uint32_t x = 0; x < kSide; ++x) {
      const auto in_front = [&](double tilted, double flat) { return depth.reversed ? tilted > flat : tilted < flat; };
      const double tilted = planes.tilted(x);
      const bool tilted_wins = in_front(tilted, planes.flat);
      wrong_columns += in_front(depth.round(tilted), depth.round(planes.flat)) != tilted_wins;
      const bool excused =
          std::abs(tilted - planes.flat) <= 2 * depth.step(planes.flat) + kRounding * std::max(tilted, planes.flat);
      for (uint32_t y = 0; y < kSide; ++y) {
        const float winner = winners[size_t{y} * kSide + x];
        const bool right = winner == (tilted_wins ? 2.0f : 1.0f);
        wrong += !right;
        unexcused += !right && !excused;
        const uint8_t colours[][3] = {{45, 92, 214}, {236, 200, 52}, {120, 30, 40}, {255, 120, 110}};
        if (i == 0) std::copy_n(colours[(winner == 2 ? 1 : 0) + (right ? 0 : 2)], 3, picture.pixel(x, y));
      }
    }
  }
  const auto percent = [](size_t count, size_t of) { return 100.0 * static_cast<double>(count) / static_cast<double>(of); };
  return {.verdict = unexcused ? Verdict::kWrong
                     : wrong   ? Verdict::kWithin
                               : Verdict::kExact,
          .measured = fmt::format("{:.2f} % of the pixels wrong", percent(wrong, size_t{kDistances} * kSide * kSide)),
          .truth = fmt::format("a straight line; {:.2f} % when exact depths are rounded to the format",
                               percent(wrong_columns, size_t{kDistances} * kSide)),
          .bound = "only where depths are nearer than two steps of the format and 8 ULP of binary32",
          .bytes = bytes,
          .pictures = {{"red shades: the wrong plane is in front", picture}}};
}

template <VkFormat kFormat, bool kReversed>
Outcome crossing(ExtremeRig& rig) {
  return crossing(rig, {kFormat == kD24 ? d24(rig) : kFormat, kReversed});
}

// Two surfaces in one slanted plane, of different triangles, the second with a bias towards the eye. With `on_grid` all vertices
// are binary fractions of a pixel, so that snapping them to the subpixel grid does not tilt the plane.
Outcome bias(ExtremeRig& rig, VkFormat format, float constant, float slope, bool on_grid = true) {
  if (lacks(rig, format)) return {};
  const auto at = [](float x, float y, float colour) {
    return RigVertex{{x, y, 0.5f + 0.1875f * x + 0.125f * y, 1}, {colour, 0, 0, 0}};
  };
  const RigDraw large = {.vertices = {at(-1, -1, 1), at(1, -1, 1), at(-1, 1, 1), at(-1, 1, 1), at(1, -1, 1), at(1, 1, 1)},
                         .depth_test = true};
  RigDraw biased{.vertices = {at(-1.3125f, -1.125f, 2), at(3.125f, -1.1875f, 2), at(-1.1875f, 3.3125f, 2)},
                 .depth_test = true,
                 .bias_constant = constant,
                 .bias_slope = slope};
  if (!on_grid) biased.vertices = {at(-1.3f, -1.1f, 2), at(3.1f, -1.2f, 2), at(-1.2f, 3.3f, 2)};
  const RigDraw draws[] = {large, biased};
  const std::vector<float> winners = rig.draw_as<float>({.depth = format}, draws);
  const auto behind = std::ranges::count_if(winners, [](float winner) { return winner != 2; });
  return {.verdict = behind ? Verdict::kWrong : Verdict::kExact,
          .measured = fmt::format("{} of {} pixels behind", behind, winners.size()),
          .truth = "0 pixels behind",
          .bytes = bytes_of(winners)};
}

Outcome bias_d16(ExtremeRig& rig) { return bias(rig, VK_FORMAT_D16_UNORM, -2, 0); }
Outcome bias_d24(ExtremeRig& rig) { return bias(rig, d24(rig), -4, 0); }
Outcome bias_d32(ExtremeRig& rig) { return bias(rig, VK_FORMAT_D32_SFLOAT, -8, 0); }
Outcome bias_slope(ExtremeRig& rig) { return bias(rig, VK_FORMAT_D32_SFLOAT, 0, -1, false); }

constexpr const char* kOrder =
    "exact order of the vertices given; Vulkan 1.3, Depth Test (how depths are rounded is left open: the bound is this case's "
    "own)";
constexpr const char* kBias = "Vulkan 1.3, Depth Bias: r is the smallest difference that is resolved throughout";

constexpr ExtremeCase kCases[] = {
    {"depth", "order in D16", "4,096 pairs of surfaces, near : far = 1 : 10^7", kOrder, ordering<kD16, false>},
    {"depth", "order in D24", "The same in D24", kOrder, ordering<kD24, false>},
    {"depth", "order in D32F", "The same in D32F: no better than D24, as all depths are near 1", kOrder, ordering<kD32, false>},
    {"depth", "order in D16, reversed", "Depth 1 at near, 0 at far: in fixed point nothing is won", kOrder, ordering<kD16, true>},
    {"depth", "order in D24, reversed", "The same in D24", kOrder, ordering<kD24, true>},
    {"depth", "order in D32F, reversed", "The same in D32F: binary32's exponent makes up for the perspective", kOrder,
     ordering<kD32, true>},
    {"depth", "z-fighting in D16",
     "Two planes, tilted by 0.2 %, cross in a straight line; at 16 distances from 2,000 times the near one", kOrder,
     crossing<kD16, false>},
    {"depth", "z-fighting in D24", "The same in D24", kOrder, crossing<kD24, false>},
    {"depth", "z-fighting in D32F", "The same in D32F", kOrder, crossing<kD32, false>},
    {"depth", "z-fighting in D16, reversed", "The same, reversed", kOrder, crossing<kD16, true>},
    {"depth", "z-fighting in D24, reversed", "The same in D24, reversed", kOrder, crossing<kD24, true>},
    {"depth", "z-fighting in D32F, reversed", "The same in D32F, reversed", kOrder, crossing<kD32, true>},
    {"depth", "constant bias in D16", "A coplanar surface of other triangles with a bias of -2 r is in front everywhere", kBias,
     bias_d16},
    {"depth", "constant bias in D24", "The same with -4 r, as interpolation in binary32 is no finer than the format", kBias,
     bias_d24},
    {"depth", "constant bias in D32F", "The same with -8 r", kBias, bias_d32},
    {"depth", "slope bias in D32F", "A bias of -1 times the slope, a whole pixel's worth; vertices off the subpixel grid", kBias,
     bias_slope},
};

}  // namespace

std::span<const ExtremeCase> depth_cases() { return kCases; }

}  // namespace pineda::tools
