#include "cts-subset/reference/texture.h"

#include <algorithm>
#include <cmath>

#include "cts-subset/reference/wrapping.h"

namespace pineda::cts {
namespace {

bool is_cube(Shape shape) { return shape == Shape::kCube || shape == Shape::kCubeArray; }
int dimensions(Shape shape) { return shape == Shape::k1D || shape == Shape::k1DArray ? 1 : shape == Shape::k3D ? 3 : 2; }

// "Cube Map Face Selection" and "Cube Map Coordinate Transformation"; z wins over y over x where magnitudes are equal.
FacePoint face_of(double x, double y, double z) {
  const double ax = std::abs(x), ay = std::abs(y), az = std::abs(z);
  int face;
  double sc, tc, rc;
  if (az >= ax && az >= ay) {
    face = z >= 0 ? 4 : 5, sc = z >= 0 ? x : -x, tc = -y, rc = az;
  } else if (ay >= ax) {
    face = y >= 0 ? 2 : 3, sc = x, tc = y >= 0 ? z : -z, rc = ay;
  } else {
    face = x >= 0 ? 0 : 1, sc = x >= 0 ? -z : z, tc = -y, rc = ax;
  }
  return {face, 0.5 * sc / rc + 0.5, 0.5 * tc / rc + 0.5};
}

std::array<double, 3> direction_of(const FacePoint& p) {
  const double sc = 2 * p.s - 1, tc = 2 * p.t - 1;
  switch (p.face) {
    case 0:
      return {1, -tc, -sc};
    case 1:
      return {-1, -tc, sc};
    case 2:
      return {sc, 1, tc};
    case 3:
      return {sc, -1, -tc};
    case 4:
      return {sc, -tc, 1};
    default:
      return {-sc, -tc, -1};
  }
}

struct Fetcher {
  const Texture& texture;
  const SamplerState& state;
  double reference;

  Colour texel(const TextureLevel& level, int layer, int i, int j, int k) const {
    const size_t at = ((static_cast<size_t>(layer) * level.depth + k) * level.height + j) * level.width + i;
    return compared(level.texels[at]);
  }

  // "Depth Compare Operation"
  Colour compared(Colour colour) const {
    if (!state.compare) return colour;
    const double d = colour[0];
    bool pass = true;
    switch (state.compare_op) {
      case VK_COMPARE_OP_NEVER:
        pass = false;
        break;
      case VK_COMPARE_OP_LESS:
        pass = reference < d;
        break;
      case VK_COMPARE_OP_EQUAL:
        pass = reference == d;
        break;
      case VK_COMPARE_OP_LESS_OR_EQUAL:
        pass = reference <= d;
        break;
      case VK_COMPARE_OP_GREATER:
        pass = reference > d;
        break;
      case VK_COMPARE_OP_NOT_EQUAL:
        pass = reference != d;
        break;
      case VK_COMPARE_OP_GREATER_OR_EQUAL:
        pass = reference >= d;
        break;
      default:
        break;
    }
    return {pass ? 1.0 : 0.0, 0, 0, 1};
  }

  Colour operator()(const TextureLevel& level, int layer, int i, int j, int k) const {
    if (is_cube(texture.shape)) return cube_texel(level, layer, i, j);
    const int x = wrapped(state.address[0], i, level.width);
    const int y = dimensions(texture.shape) > 1 ? wrapped(state.address[1], j, level.height) : 0;
    const int z = dimensions(texture.shape) > 2 ? wrapped(state.address[2], k, level.depth) : 0;
    if (x < 0 || y < 0 || z < 0) return compared(state.border);
    return texel(level, layer, x, y, z);
  }

  // "Cube Map Edge Handling": a texel beyond one edge is the neighbouring face's; at a corner, the mean of the three that meet.
  Colour cube_texel(const TextureLevel& level, int layer, int i, int j) const {
    const int size = level.width, face = layer % 6, cube = layer - face;
    const bool out_x = i < 0 || i >= size, out_y = j < 0 || j >= size;
    if (!out_x && !out_y) return texel(level, layer, i, j, 0);
    if (out_x && out_y) {
      const int ci = std::clamp(i, 0, size - 1), cj = std::clamp(j, 0, size - 1);
      const Colour a = texel(level, layer, ci, cj, 0), b = cube_texel(level, layer, i, cj), c = cube_texel(level, layer, ci, j);
      Colour mean;
      for (size_t n = 0; n < 4; ++n) mean[n] = (a[n] + b[n] + c[n]) / 3;
      return mean;
    }
    const std::array<double, 3> d = direction_of({face, (i + 0.5) / size, (j + 0.5) / size});
    const FacePoint p = face_of(d[0], d[1], d[2]);
    return texel(level, cube + p.face, std::clamp(static_cast<int>(p.s * size), 0, size - 1),
                 std::clamp(static_cast<int>(p.t * size), 0, size - 1), 0);
  }
};

struct Position {
  double u = 0, v = 0, w = 0;
  int layer = 0;
};

Position locate(const Texture& texture, const SamplerState& state, const TextureLevel& level, const std::array<double, 4>& c) {
  const auto layer_at = [&](double value) {  // "RNE(x), clamped"
    const int groups = is_cube(texture.shape) ? texture.layers / 6 : texture.layers;
    return std::clamp(static_cast<int>(std::nearbyint(value)), 0, groups - 1);
  };
  const double w = state.unnormalized ? 1 : level.width, h = state.unnormalized ? 1 : level.height;
  switch (texture.shape) {
    case Shape::k1D:
      return {c[0] * w};
    case Shape::k1DArray:
      return {c[0] * w, 0, 0, layer_at(c[1])};
    case Shape::k2D:
      return {c[0] * w, c[1] * h};
    case Shape::k2DArray:
      return {c[0] * w, c[1] * h, 0, layer_at(c[2])};
    case Shape::k3D:
      return {c[0] * w, c[1] * h, c[2] * level.depth};
    default: {
      const FacePoint p = face_of(c[0], c[1], c[2]);
      const int cube = texture.shape == Shape::kCubeArray ? layer_at(c[3]) : 0;
      return {p.s * level.width, p.t * level.height, 0, cube * 6 + p.face};
    }
  }
}

// One level's answer; `slack` gets the spread of the footprint times the weight that a sub-texel step can move.
Sample filter_level(const Fetcher& fetch, const TextureLevel& level, const Position& p, VkFilter filter,
                    std::array<int, 3> offset, int sub_texel_bits) {
  const int dims = dimensions(fetch.texture.shape);
  if (filter == VK_FILTER_NEAREST) {
    int i = static_cast<int>(std::floor(p.u)) + offset[0], j = static_cast<int>(std::floor(p.v)) + offset[1];
    const int k = static_cast<int>(std::floor(p.w)) + offset[2];
    if (is_cube(fetch.texture.shape)) i = std::clamp(i, 0, level.width - 1), j = std::clamp(j, 0, level.height - 1);
    return {fetch(level, p.layer, i, j, k), {}};
  }
  const double u = p.u - 0.5, v = p.v - 0.5, w = p.w - 0.5;
  const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v)), k = static_cast<int>(std::floor(w));
  const double fu = u - i, fv = v - j, fw = w - k;
  Sample out;
  Colour low, high;
  low.fill(1e300), high.fill(-1e300);
  for (int corner = 0; corner < 1 << dims; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2 & 1;
    double weight = x ? fu : 1 - fu;
    if (dims > 1) weight *= y ? fv : 1 - fv;
    if (dims > 2) weight *= z ? fw : 1 - fw;
    const Colour c = fetch(level, p.layer, i + x + offset[0], j + y + offset[1], k + z + offset[2]);
    for (size_t n = 0; n < 4; ++n) {
      out.value[n] += weight * c[n];
      low[n] = std::min(low[n], c[n]), high[n] = std::max(high[n], c[n]);
    }
  }
  for (size_t n = 0; n < 4; ++n) out.slack[n] = (high[n] - low[n]) * dims * std::exp2(-sub_texel_bits);
  return out;
}

}  // namespace

FacePoint cube_point(double x, double y, double z) { return face_of(x, y, z); }

Sample sample(const Texture& texture, const SamplerState& state, std::array<double, 4> coordinate, double lod, double reference,
              std::array<int, 3> offset, int sub_texel_bits, int mip_bits) {
  const Fetcher fetch{texture, state, reference};
  const double lambda = std::clamp(lod + state.bias, state.min_lod, state.max_lod);
  const VkFilter filter = lambda <= 0 ? state.mag : state.min;
  const double top = static_cast<double>(texture.levels.size()) - 1, d = std::clamp(lambda, 0.0, top);
  const auto at = [&](double level) {
    const TextureLevel& l = texture.levels[static_cast<size_t>(level)];
    return filter_level(fetch, l, locate(texture, state, l, coordinate), filter, offset, sub_texel_bits);
  };
  if (state.unnormalized) return at(0);
  if (state.mip == VK_SAMPLER_MIPMAP_MODE_NEAREST) return at(std::max(0.0, std::ceil(d + 0.5) - 1));
  const double floor_d = std::floor(d), fraction = d - floor_d;
  const Sample fine = at(floor_d), coarse = at(std::min(floor_d + 1, top));
  Sample out;
  for (size_t n = 0; n < 4; ++n) {
    out.value[n] = fine.value[n] * (1 - fraction) + coarse.value[n] * fraction;
    out.slack[n] = fine.slack[n] + coarse.slack[n] + std::abs(fine.value[n] - coarse.value[n]) * std::exp2(-mip_bits);
  }
  return out;
}

Colour gather(const Texture& texture, const SamplerState& state, std::array<double, 4> coordinate, size_t component,
              double reference, std::array<int, 3> offset) {
  const Fetcher fetch{texture, state, reference};
  const TextureLevel& level = texture.levels[0];
  const Position p = locate(texture, state, level, coordinate);
  const int i = static_cast<int>(std::floor(p.u - 0.5)) + offset[0], j = static_cast<int>(std::floor(p.v - 0.5)) + offset[1];
  return {fetch(level, p.layer, i, j + 1, 0)[component], fetch(level, p.layer, i + 1, j + 1, 0)[component],
          fetch(level, p.layer, i + 1, j, 0)[component], fetch(level, p.layer, i, j, 0)[component]};
}

}  // namespace pineda::cts
