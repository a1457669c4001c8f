#include "compiler/kernels/sample_reference.h"

#include <cmath>

#include "cts-subset/reference/wrapping.h"

namespace pineda::kernels::test {
namespace {

using Point = std::array<double, 3>;

// The face's point (sc, tc) with |rc| = 1, after the table "Cube map face and coordinate selection".
Point point_on_face(uint32_t face, double s, double t) {
  const Point points[6] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t}, {s, -1, -t}, {s, -t, 1}, {-s, -t, -1}};
  return points[face];
}

double distance(const Point& a, const Point& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

bool compare(VkCompareOp op, double reference, double texel) {
  switch (op) {
    case VK_COMPARE_OP_NEVER:
      return false;
    case VK_COMPARE_OP_LESS:
      return reference < texel;
    case VK_COMPARE_OP_EQUAL:
      return reference == texel;
    case VK_COMPARE_OP_LESS_OR_EQUAL:
      return reference <= texel;
    case VK_COMPARE_OP_GREATER:
      return reference > texel;
    case VK_COMPARE_OP_NOT_EQUAL:
      return reference != texel;
    case VK_COMPARE_OP_GREATER_OR_EQUAL:
      return reference >= texel;
    default:
      return true;
  }
}

}  // namespace

// ---- image ----------------------------------------------------------------------------------------------------------------

TestImage::TestImage(const ImageShape& image_shape, std::mt19937& random)
    : shape(image_shape), format(*find_format(image_shape.format)) {
  uint32_t layer_bytes = 0;
  for (uint32_t l = 0; l < shape.levels; ++l) {
    const auto [w, h, d] = std::array{size(0, l), size(1, l), size(2, l)};
    const uint32_t row = static_cast<uint32_t>(w) * format.texel_bytes + 16;  // a gap: rows need not be packed
    descriptor.levels[l] = {.offset_bytes = layer_bytes, .row_pitch_bytes = row};
    layer_bytes += row * static_cast<uint32_t>(h * d);
  }
  bytes_.resize(layer_bytes * shape.layers);
  for (size_t at = 0; at + format.texel_bytes <= bytes_.size(); at += format.texel_bytes) {
    VkClearColorValue color;
    for (float& v : color.float32) v = static_cast<float>(random() / 0x1p31 - (format.is_depth() ? 0 : 1));
    if (format.numeric != Numeric::kSfloat) {
      for (uint32_t i = 0; i < format.texel_bytes; ++i) bytes_[at + i] = static_cast<uint8_t>(random());
    } else if (format.is_depth()) {
      pack_depth(format, color.float32[0] / 2, &bytes_[at]);
    } else {
      pack_clear_color(format, color, &bytes_[at]);
    }
  }
  descriptor.address = reinterpret_cast<uint64_t>(bytes_.data());
  descriptor.size_bytes = static_cast<uint32_t>(bytes_.size());
  descriptor.width = shape.width, descriptor.height = shape.height, descriptor.depth = shape.depth;
  descriptor.level_count = shape.levels, descriptor.layer_count = shape.layers;
  descriptor.layer_pitch_bytes = layer_bytes;
  descriptor.min_lod = -1000, descriptor.max_lod = 1000, descriptor.max_anisotropy = 16;
  const float border[4] = {0.25f, 0.5f, 0.125f, 0.75f};
  std::memcpy(descriptor.border, border, sizeof border);
}

int TestImage::size(uint32_t axis, uint32_t level) const {
  const uint32_t sizes[3] = {shape.width, shape.height, shape.depth};
  return static_cast<int>(std::max(sizes[axis] >> level, 1u));
}

double TestImage::texel(int x, int y, int z, uint32_t layer, uint32_t level, uint32_t component) const {
  const MipLevel& l = descriptor.levels[level];
  const size_t row = static_cast<size_t>(z * size(1, level) + y);
  const size_t at = layer * size_t{descriptor.layer_pitch_bytes} + l.offset_bytes + row * l.row_pitch_bytes +
                    static_cast<size_t>(x) * format.texel_bytes;
  return decode_reference(format, component, code_of(format, component, &bytes_[at]));
}

// ---- sampler --------------------------------------------------------------------------------------------------------------

bool SpecSampler::cube() const {
  return state_.view_type == VK_IMAGE_VIEW_TYPE_CUBE || state_.view_type == VK_IMAGE_VIEW_TYPE_CUBE_ARRAY;
}

uint32_t SpecSampler::axes() const {
  if (state_.view_type == VK_IMAGE_VIEW_TYPE_1D || state_.view_type == VK_IMAGE_VIEW_TYPE_1D_ARRAY) return 1;
  return state_.view_type == VK_IMAGE_VIEW_TYPE_3D ? 3 : 2;
}

// x: whether it is too near to a boundary at `phase` between integers.
void SpecSampler::guard(double x, double phase, double margin) {
  const double f = x - std::floor(x);
  const double d = std::fabs(f - phase);
  if (std::min(d, 1 - d) < margin) near_boundary = true;
}

double SpecSampler::border(uint32_t c) const {
  return image_.format.component[c].bits == 0 ? (c == 3 ? 1.0 : 0.0) : image_.descriptor.border[c];
}

double SpecSampler::outcome(double texel) const {
  if (!state_.compare_enable) return texel;
  return compare(state_.compare, depth_reference_, texel) ? 1 : 0;
}

double SpecSampler::tap(const std::array<int, 3>& index, uint32_t layer, uint32_t level, uint32_t c) const {
  std::array<int, 3> at{};
  for (uint32_t a = 0; a < axes(); ++a) {
    at[a] = cts::wrapped(state_.address[a], index[a], image_.size(a, level));
    if (at[a] < 0) return outcome(border(c));
  }
  return outcome(image_.texel(at[0], at[1], at[2], layer, level, c));
}

// Beyond an edge: the texel of another face that is nearest to the middle of the edge texel's outer side, found by looking at all
// of them. Beyond a corner: the average of the other three of the footprint, which the caller forms.
double SpecSampler::cube_tap(int i, int j, uint32_t layer, uint32_t level, uint32_t c) const {
  const int n = image_.size(0, level);
  if (i >= 0 && i < n && j >= 0 && j < n) return outcome(image_.texel(i, j, 0, layer, level, c));
  const auto middle = [&](int k) { return std::clamp((2.0 * k + 1) / n - 1, -1.0, 1.0); };
  const Point side = point_on_face(layer % 6, middle(i), middle(j));
  double best = 1e9, value = 0;
  for (uint32_t face = 0; face < 6; ++face) {
    if (face == layer % 6) continue;
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const double d = distance(side, point_on_face(face, (2.0 * x + 1) / n - 1, (2.0 * y + 1) / n - 1));
        if (d >= best) continue;
        best = d;
        value = image_.texel(x, y, 0, layer / 6 * 6 + face, level, c);
      }
    }
  }
  return outcome(value);
}

SpecSampler::Place SpecSampler::place(const SpecSample& request) {
  Place out{request.coord, 0};
  const uint32_t layers = cube() ? image_.shape.layers / 6 : image_.shape.layers;
  const double rounded = std::nearbyint(request.layer);
  guard(request.layer, 0.5, 1e-6);
  const auto layer = static_cast<uint32_t>(std::clamp(rounded, 0.0, layers - 1.0));
  out.layer = cube() ? 6 * layer : layer;
  if (!cube()) return out;
  const Point& r = request.coord;
  uint32_t major = 0;
  for (uint32_t a = 1; a < 3; ++a) major = std::fabs(r[a]) >= std::fabs(r[major]) ? a : major;
  for (uint32_t a = 0; a < 3; ++a) {
    if (a != major && std::fabs(r[a]) > 0.9999 * std::fabs(r[major])) near_boundary = true;
  }
  const uint32_t face = 2 * major + (r[major] < 0 ? 1 : 0);
  out.layer += face;
  const double sc[6] = {-r[2], r[2], r[0], r[0], r[0], -r[0]}, tc[6] = {-r[1], -r[1], r[2], -r[2], -r[1], -r[1]};
  const double rc = std::fabs(r[major]);
  out.coord = {0.5 * sc[face] / rc + 0.5, 0.5 * tc[face] / rc + 0.5, 0};
  return out;
}

double SpecSampler::combine(double first, double second, double weight2) const {
  if (state_.reduction == VK_SAMPLER_REDUCTION_MODE_WEIGHTED_AVERAGE || state_.compare_enable) {
    return first + weight2 * (second - first);
  }
  if (weight2 == 0) return first;
  return state_.reduction == VK_SAMPLER_REDUCTION_MODE_MIN ? std::min(first, second) : std::max(first, second);
}

double SpecSampler::one_level(const Place& at, uint32_t level, VkFilter filter, uint32_t c) {
  std::array<int, 3> lower{};
  std::array<double, 3> weight{};
  for (uint32_t a = 0; a < axes(); ++a) {
    double s = at.coord[a] * (state_.unnormalized ? 1 : image_.size(a, level)) + offset_[a];
    if (filter == VK_FILTER_NEAREST) {
      guard(s, 0);
      lower[a] = static_cast<int>(std::floor(s));
      continue;
    }
    s = (s - 0.5) * 256;
    guard(s, 0.5);
    s = std::floor(s + 0.5) / 256;
    lower[a] = static_cast<int>(std::floor(s));
    weight[a] = s - lower[a];
  }
  if (cube() && filter == VK_FILTER_NEAREST) {
    const int last = image_.size(0, level) - 1;
    return cube_tap(std::clamp(lower[0], 0, last), std::clamp(lower[1], 0, last), at.layer, level, c);
  }
  if (filter == VK_FILTER_NEAREST) return tap(lower, at.layer, level, c);
  std::array<double, 8> texel{};
  int corner = -1;
  for (int k = 0; k < 1 << axes(); ++k) {
    const std::array<int, 3> index{lower[0] + (k & 1), lower[1] + (k >> 1 & 1), lower[2] + (k >> 2)};
    if (!cube()) {
      texel[static_cast<size_t>(k)] = tap(index, at.layer, level, c);
      continue;
    }
    const int n = image_.size(0, level);
    const auto beyond = [&](int i) { return i < 0 || i >= n; };
    if (beyond(index[0]) && beyond(index[1])) {
      corner = k;
    } else {
      texel[static_cast<size_t>(k)] = cube_tap(index[0], index[1], at.layer, level, c);
    }
  }
  if (corner >= 0) texel[static_cast<size_t>(corner)] = (texel[0] + texel[1] + texel[2] + texel[3]) / 3;
  for (uint32_t a = 0; a < axes(); ++a) {
    for (size_t k = 0; k < size_t{1} << (axes() - 1 - a); ++k) texel[k] = combine(texel[2 * k], texel[2 * k + 1], weight[a]);
  }
  return texel[0];
}

double SpecSampler::levels(const Place& at, double lod, uint32_t c) {
  const VkFilter filter = lod <= 0 ? state_.mag_filter : state_.min_filter;
  if (state_.mag_filter != state_.min_filter && std::fabs(lod) < 1e-4) near_boundary = true;
  if (state_.single_level) return one_level(at, 0, filter, c);
  const uint32_t last = image_.shape.levels - 1;
  const double d = std::clamp(lod, 0.0, static_cast<double>(last));
  if (state_.mipmap_mode == VK_SAMPLER_MIPMAP_MODE_NEAREST) {
    guard(d, 0.5);
    return one_level(at, static_cast<uint32_t>(std::ceil(d + 0.5) - 1), filter, c);
  }
  if (d > 0 && d < last) guard(d * 256, 0.5);
  const double rounded = std::floor(d * 256 + 0.5) / 256;
  const auto high = static_cast<uint32_t>(rounded);
  const double first = one_level(at, high, filter, c);
  if (rounded == high) return first;
  return combine(first, one_level(at, std::min(high + 1, last), filter, c), rounded - high);
}

double SpecSampler::sample(const SpecSample& request, uint32_t c) {
  offset_ = request.offset;
  depth_reference_ = request.depth_reference;
  if (image_.format.numeric == Numeric::kUnorm) depth_reference_ = std::clamp(depth_reference_, 0.0, 1.0);
  const Place at = place(request);
  if (!request.anisotropic) return levels(at, request.lod, c);
  // Section 16.7 "Scale Factor Operation", 16.9.4 "Texel Anisotropic Filtering"; lod is ignored.
  double rho[2] = {0, 0};
  for (uint32_t a = 0; a < axes(); ++a) {
    rho[0] = std::hypot(rho[0], request.ddx[a] * image_.size(a, 0));
    rho[1] = std::hypot(rho[1], request.ddy[a] * image_.size(a, 0));
  }
  const double longer = std::max(rho[0], rho[1]), shorter = std::min(rho[0], rho[1]);
  const double eta = std::min(longer / shorter, static_cast<double>(image_.descriptor.max_anisotropy));
  guard(eta, 0, 1e-4);
  if (std::fabs(rho[0] - rho[1]) < 1e-4 * longer) near_boundary = true;
  const double n = std::ceil(eta), lod = std::log2(longer / eta);
  const auto& step = rho[0] > rho[1] ? request.ddx : request.ddy;
  double sum = 0;
  for (double i = 1; i <= n; ++i) {
    Place probe = at;
    for (uint32_t a = 0; a < axes(); ++a) probe.coord[a] += step[a] * (i / (n + 1) - 0.5);
    sum += levels(probe, lod, c);
  }
  return sum / n;
}

std::array<double, 4> SpecSampler::gather(const SpecSample& request, uint32_t c) {
  offset_ = request.offset;
  depth_reference_ = request.depth_reference;
  const Place at = place(request);
  int lower[2];
  for (uint32_t a = 0; a < 2; ++a) {
    const double s = at.coord[a] * image_.size(a, 0) + offset_[a] - 0.5;
    guard(s, 0);
    lower[a] = static_cast<int>(std::floor(s));
  }
  const std::array<std::array<int, 2>, 4> order{{{0, 1}, {1, 1}, {1, 0}, {0, 0}}};
  std::array<double, 4> out{};
  for (size_t k = 0; k < 4; ++k) {
    const int i = lower[0] + order[k][0], j = lower[1] + order[k][1];
    out[k] = cube() ? cube_tap(i, j, at.layer, 0, c) : tap({i, j, 0}, at.layer, 0, c);
  }
  if (cube()) {
    const int n = image_.size(0, 0);
    for (size_t k = 0; k < 4; ++k) {
      const int i = lower[0] + order[k][0], j = lower[1] + order[k][1];
      const bool corner = (i < 0 || i >= n) && (j < 0 || j >= n);
      if (corner) out[k] = (out[0] + out[1] + out[2] + out[3] - out[k]) / 3;
    }
  }
  return out;
}

}  // namespace pineda::kernels::test
