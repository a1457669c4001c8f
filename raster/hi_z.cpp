#include "raster/hi_z.h"

#include <cmath>
#include <limits>

#if defined(__x86_64__)
#include <immintrin.h>
#else
#error "Hi-Z has an x86-64 implementation only"
#endif

namespace pineda::raster {
namespace {

constexpr float kFixedPointMargin = 4;  // steps of a fixed-point depth: rounding to it, by the kernel and here

// Largest of `count` numbers, a multiple of 16; NaN count for nothing (no comparison with them passes).
float largest(const float* v, uint32_t count, bool negate) {
  const __m128 sign = negate ? _mm_set1_ps(-0.0f) : _mm_setzero_ps();
  __m128 m = _mm_set1_ps(-std::numeric_limits<float>::infinity());
  for (uint32_t first = 0; first < count; first += kLanes) {
    for (uint32_t i = first; i < first + kLanes; i += 4)
      m = _mm_max_ps(_mm_xor_ps(_mm_load_ps(v + i), sign), m);  // maxps gives its second operand for NaN
  }
  m = _mm_max_ps(m, _mm_movehl_ps(m, m));
  m = _mm_max_ss(m, _mm_shuffle_ps(m, m, 1));
  return _mm_cvtss_f32(m);
}

template <class T>
float largest_fixed(const uint8_t* texels, uint32_t count, uint32_t bits, bool negate) {
  const uint32_t all = (1u << bits) - 1;
  uint32_t low = all, high = 0;
  for (uint32_t i = 0; i < count; ++i) {
    T v;
    std::memcpy(&v, texels + i * sizeof(T), sizeof(T));
    low = std::min(low, v & all);
    high = std::max(high, v & all);
  }
  const float value = negate ? -static_cast<float>(low) : static_cast<float>(high);
  return (value + kFixedPointMargin) / static_cast<float>(all);
}

uint32_t depth_bytes(VkFormat format) { return format == VK_FORMAT_D16_UNORM ? 2 : 4; }

}  // namespace

bool hi_z_supports(VkFormat format) {
  return format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D16_UNORM || format == VK_FORMAT_X8_D24_UNORM_PACK32;
}

namespace {

// What bounding a triangle's depth starts with; depths are negated when the test asks for greater ones.
struct SignedDepth {
  float sign, z0, dz1, dz2;
  float x, y;    // of the tile's first pixel, from vertex 0
  float margin;  // of rounding, anywhere in the tile
};

inline SignedDepth signed_depth(const FragmentPrim& prim, const Draw& draw, const TilePosition& tile) {
  SignedDepth d;
  d.sign = draw.hi_z == HiZMode::kGreater ? -1.0f : 1.0f;
  d.z0 = d.sign * prim.z0;
  d.dz1 = d.sign * prim.dz1;
  d.dz2 = d.sign * prim.dz2;
  d.x = static_cast<float>(tile.x_px) + 0.5f - prim.x0_px;
  d.y = static_cast<float>(tile.y_px) + 0.5f - prim.y0_px;
  const auto last = static_cast<float>(tile.size_px - 1);
  const float half = draw.samples > 1 ? 0.5f : 0.0f;  // from a pixel's centre to its samples
  const float far_x = std::max(std::fabs(d.x), std::fabs(d.x + last)) + half;
  const float far_y = std::max(std::fabs(d.y), std::fabs(d.y + last)) + half;
  const float s1 = std::fabs(prim.l1_dx) * far_x + std::fabs(prim.l1_dy) * far_y;
  const float s2 = std::fabs(prim.l2_dx) * far_x + std::fabs(prim.l2_dy) * far_y;
  d.margin = kHiZMargin * (std::fabs(d.z0) + (1 + s1) * std::fabs(d.dz1) + (1 + s2) * std::fabs(d.dz2));
  return d;
}

inline float least(const SignedDepth& d) { return std::min(d.z0, std::min(d.z0 + d.dz1, d.z0 + d.dz2)) - d.margin; }

}  // namespace

float depth_ceiling(const Draw& draw, uint32_t viewport) {
  const VkViewport& v = viewport == 0 ? draw.packet.viewport : draw.packet.viewports->viewport[viewport];
  return draw.hi_z == HiZMode::kGreater ? -std::max(0.0f, std::min(v.minDepth, v.maxDepth))
                                        : std::min(1.0f, std::max(v.minDepth, v.maxDepth));
}

TriangleDepth triangle_depth(const FragmentPrim& prim, const Draw& draw, const TilePosition& tile) {
  const SignedDepth d = signed_depth(prim, draw, tile);
  const float zx = prim.l1_dx * d.dz1 + prim.l2_dx * d.dz2, zy = prim.l1_dy * d.dz1 + prim.l2_dy * d.dz2;
  constexpr float kLast = kBlockDim - 1;  // from a block's first pixel to its least corner
  TriangleDepth depth;
  depth.least = least(d);
  depth.at_origin = d.z0 + zx * d.x + zy * d.y + kLast * (std::min(zx, 0.0f) + std::min(zy, 0.0f)) - d.margin;
  if (draw.samples > 1) depth.at_origin -= 0.5f * (std::fabs(zx) + std::fabs(zy));
  depth.dx_block = zx * kBlockDim;
  depth.dy_block = zy * kBlockDim;
  depth.ceiling = depth_ceiling(draw, prim.viewport_index);
  return depth;
}

float least_depth(const FragmentPrim& prim, const Draw& draw, const TilePosition& tile) {
  const SignedDepth d = signed_depth(prim, draw, tile);
  const float z = least(d), limit = depth_ceiling(draw, prim.viewport_index);
  return z > limit ? limit : z;  // a NaN stays and hides nothing
}

void HiZ::begin_tile(VkFormat format, const uint8_t* depth_buffer, int32_t size_px, uint32_t samples, bool uniform) {
  samples_ = samples;
  format_ = format;
  depth_ = depth_buffer;
  macros_ = static_cast<uint32_t>(size_px * size_px) / 256;
  uniform_ = uniform;
  direction_ = HiZMode::kNone;
}

void HiZ::forget() {
  direction_ = HiZMode::kNone;
  uniform_ = false;
}

void HiZ::begin_draw(const Draw& draw) {
  const bool was_uniform = uniform_;
  uniform_ &= !draw.writes_depth;
  breaks_bounds_ = draw.writes_depth && draw.hi_z == HiZMode::kNone;
  if (draw.hi_z == HiZMode::kNone || draw.hi_z == direction_) return;
  direction_ = draw.hi_z;
  std::fill_n(queued_, macros_, uint16_t{0});
  std::fill_n(stale_, macros_, was_uniform ? uint16_t{0} : uint16_t{0xFFFF});
  if (was_uniform) {
    refresh(0);
    std::fill_n(farthest_, macros_ * kLanes, farthest_[0]);
  } else {
    std::fill_n(farthest_, macros_ * kLanes, std::numeric_limits<float>::infinity());
  }
}

void HiZ::flushed() {
  if (direction_ == HiZMode::kNone) return;
  for (uint32_t i = 0; i < macros_; ++i) {
    if (breaks_bounds_) [[unlikely]] {
      for (uint32_t left = queued_[i]; left != 0; left &= left - 1) {
        farthest_[i * kLanes + static_cast<uint32_t>(__builtin_ctz(left))] = std::numeric_limits<float>::infinity();
      }
    }
    stale_[i] |= queued_[i];
    queued_[i] = 0;
  }
}

void HiZ::refresh(uint32_t block) {
  const uint32_t count = kLanes * samples_;
  const uint8_t* texels = depth_ + size_t{block} * count * depth_bytes(format_);
  const bool negate = direction_ == HiZMode::kGreater;
  switch (format_) {
    case VK_FORMAT_D32_SFLOAT:
      farthest_[block] = largest(reinterpret_cast<const float*>(texels), count, negate);
      break;
    case VK_FORMAT_D16_UNORM:
      farthest_[block] = largest_fixed<uint16_t>(texels, count, 16, negate);
      break;
    default:
      farthest_[block] = largest_fixed<uint32_t>(texels, count, 24, negate);
      break;
  }
}

bool HiZ::hides(uint32_t block, float least) {
  const uint32_t macro = block / kLanes, bit = 1u << block % kLanes;
  if (stale_[macro] & bit) {
    refresh(block);
    stale_[macro] &= static_cast<uint16_t>(~bit);
  }
  return least > farthest_[block];
}

uint32_t HiZ::survivors(uint32_t macro, uint32_t wanted, const TriangleDepth& depth) {
  for (uint32_t left = stale_[macro] & wanted; left != 0; left &= left - 1) {
    refresh(macro * kLanes + static_cast<uint32_t>(__builtin_ctz(left)));
  }
  stale_[macro] &= static_cast<uint16_t>(~wanted);
  const auto bx = static_cast<float>(morton_x(macro) * 4), by = static_cast<float>(morton_y(macro) * 4);
  const __m128 base = _mm_set1_ps(depth.at_origin + bx * depth.dx_block + by * depth.dy_block);
  const __m128 dx = _mm_set1_ps(depth.dx_block), dy = _mm_set1_ps(depth.dy_block);
  const __m128 least = _mm_set1_ps(depth.least), ceiling = _mm_set1_ps(depth.ceiling);
  uint32_t hidden = 0;
  for (int q = 0; q < 4; ++q) {
    const auto qx = static_cast<float>(2 * (q & 1)), qy = static_cast<float>(q & 2);
    const __m128 x = _mm_add_ps(_mm_set_ps(1, 0, 1, 0), _mm_set1_ps(qx)), y = _mm_add_ps(_mm_set_ps(1, 1, 0, 0), _mm_set1_ps(qy));
    const __m128 plane = _mm_add_ps(base, _mm_add_ps(_mm_mul_ps(dx, x), _mm_mul_ps(dy, y)));
    const __m128 nearest = _mm_min_ps(ceiling, _mm_max_ps(plane, least));  // a NaN goes through and hides nothing
    hidden |= static_cast<uint32_t>(_mm_movemask_ps(_mm_cmpgt_ps(nearest, _mm_load_ps(farthest_ + macro * kLanes + q * 4))))
              << 4 * q;
  }
  return wanted & ~hidden;
}

}  // namespace pineda::raster
