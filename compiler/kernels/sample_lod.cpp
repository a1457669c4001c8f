#include "compiler/kernels/sample_lod.h"

#include "base/abi.h"
#include "compiler/kernels/sample_address.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;
using spirv::LodMode;

Value sampler_word(Builder& b, const SampleSource& source, size_t offset_bytes) {
  return b.load(Type::kF32, source.sampler, static_cast<uint32_t>(offset_bytes), kFixed);
}

// Axes of a face, for a cube.
uint32_t flat_axis_count(VkImageViewType type) { return is_cube(type) ? 2 : axis_count(type); }

Value image_size(Builder& b, const SampleSource& source, uint32_t axis) {
  return b.load(Type::kI32, source.image, static_cast<uint32_t>(offsetof(ImageDescriptor, width) + 4 * axis), kFixed);
}

// The footprint of a pixel in the base level: what the gradients become when they are scaled to texels (section 16.7 "Scale
// Factor Operation").
struct Footprint {
  Value major_squared, minor_squared;  // squares of the lengths of the longer and the shorter axis
  Value x_is_major;                    // B1
};

Footprint footprint(Builder& b, const SampleSource& source, const spirv::SampleRequest& request) {
  Value rho_squared[2];
  for (uint32_t axis = 0; axis < flat_axis_count(source.state.view_type); ++axis) {
    const Value size = b.convert(Op::kSToF, Type::kF32, image_size(b, source, axis));
    const Value slope[2] = {request.ddx[axis], request.ddy[axis]};
    for (uint32_t d = 0; d < 2; ++d) {
      const Value texels = b.fmul(slope[d], size);
      rho_squared[d] = axis == 0 ? b.fmul(texels, texels) : b.fma(texels, texels, rho_squared[d]);
    }
  }
  return {.major_squared = b.fmax(rho_squared[0], rho_squared[1]),
          .minor_squared = b.fmin(rho_squared[0], rho_squared[1]),
          .x_is_major = b.fle(rho_squared[1], rho_squared[0])};
}

// eta of section 16.7: how much longer than wide the footprint is, within [1, maxAnisotropy]. A footprint of no size gives 1.
Value anisotropy(Builder& b, const SampleSource& source, const Footprint& f) {
  const Value ratio = b.fmax(b.f32(1), b.fsqrt(b.fdiv(f.major_squared, f.minor_squared)));
  const Value most =
      b.fmin(b.f32(kMaxAnisotropy), b.fmax(b.f32(1), sampler_word(b, source, offsetof(SamplerDescriptor, max_anisotropy))));
  return b.fmin(most, ratio);
}

bool is_anisotropic(const SampleSource& source, const spirv::SampleRequest& request) {
  return source.state.anisotropy && !source.state.unnormalized && request.lod_mode == LodMode::kGradient &&
         request.gather_component < 0;
}

// log2 of the length of the footprint's longer axis (of one probe's, when there are several), from its square.
Value base_lod(Builder& b, const SampleSource& source, const spirv::SampleRequest& request) {
  if (request.lod_mode == LodMode::kExplicit) return request.lod;
  const Footprint f = footprint(b, source, request);
  Value squared = f.major_squared;
  if (is_anisotropic(source, request)) {
    const Value eta = anisotropy(b, source, f);
    squared = b.fdiv(squared, b.fmul(eta, eta));
  }
  return b.fmul(b.f32(0.5), b.flog2_coarse(squared));
}

// Section 16.9.4 "Texel Anisotropic Filtering": ceil(eta) probes along the longer axis.
void choose_probes(Builder& b, const SampleSource& source, const spirv::SampleRequest& request, LevelChoice& out) {
  const Footprint f = footprint(b, source, request);
  out.probes = b.convert(Op::kFToS, Type::kI32, b.fceil(anisotropy(b, source, f)));
  for (uint32_t a = 0; a < flat_axis_count(source.state.view_type); ++a) {
    out.step[a] = b.select(f.x_is_major, request.ddx[a], request.ddy[a]);
  }
}

}  // namespace

uint32_t axis_count(VkImageViewType type) {
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

bool is_array(VkImageViewType type) {
  return type == VK_IMAGE_VIEW_TYPE_1D_ARRAY || type == VK_IMAGE_VIEW_TYPE_2D_ARRAY || type == VK_IMAGE_VIEW_TYPE_CUBE_ARRAY;
}

bool is_cube(VkImageViewType type) { return type == VK_IMAGE_VIEW_TYPE_CUBE || type == VK_IMAGE_VIEW_TYPE_CUBE_ARRAY; }

Value level_of_detail(Builder& b, const SampleSource& source, const spirv::SampleRequest& request) {
  if (source.state.unnormalized) return {};
  Value bias = sampler_word(b, source, offsetof(SamplerDescriptor, lod_bias));
  if (request.bias && request.lod_mode == LodMode::kGradient) bias = b.fadd(bias, request.bias);
  bias = clamp(b, bias, -kMaxSamplerLodBias, kMaxSamplerLodBias);
  const Value lod = b.fadd(base_lod(b, source, request), bias);
  // NaN, of coordinates that are no numbers, gives the minimum.
  Value least = sampler_word(b, source, offsetof(SamplerDescriptor, min_lod));
  if (request.min_lod) least = b.fmax(least, request.min_lod);
  return b.fmin(b.fmax(least, lod), sampler_word(b, source, offsetof(SamplerDescriptor, max_lod)));
}

// The IR has no way to read one lane, but a ballot of each bit of the level gives all of it.
LevelIndex level_index(Builder& b, Value lane_level) {
  constexpr uint32_t kLevelBits = 4;
  static_assert(kMaxMipLevels < 1u << kLevelBits);
  LevelIndex out{.lane = lane_level, .uniform = b.b1(true), .wave = b.i32(0)};
  const Value active = b.ballot(b.b1(true));
  for (uint32_t bit = 0; bit < kLevelBits; ++bit) {
    const Value lanes = b.ballot(b.ine(b.and_(lane_level, b.i32(1u << bit)), b.i32(0)));
    const Value any = b.ine(lanes, b.i32(0));
    out.uniform = b.and_(out.uniform, b.or_(b.not_(any), b.ieq(lanes, active)));
    out.wave = b.or_(out.wave, b.shl(b.convert(Op::kZExt, Type::kI32, any), b.i32(bit)));
  }
  return out;
}

LevelChoice choose_levels(Builder& b, const SampleSource& source, const spirv::SampleRequest& request) {
  const compiler::TextureState& state = source.state;
  const bool filters_differ = state.min_filter != state.mag_filter;
  LevelChoice out;
  if (is_anisotropic(source, request)) choose_probes(b, source, request, out);
  if (state.single_level && !filters_differ) return out;
  const Value lod = level_of_detail(b, source, request);
  if (!lod) return out;
  if (filters_differ) out.magnify = b.fle(lod, b.f32(0));
  if (state.single_level) return out;
  const Value level_count = b.load(Type::kI32, source.image, offsetof(ImageDescriptor, level_count), kFixed);
  // The array of levels bounds what a descriptor may claim.
  const Value last = b.umin(b.isub(level_count, b.i32(1)), b.i32(kMaxMipLevels));
  const Value d = b.fmin(b.fmax(b.f32(0), lod), b.convert(Op::kSToF, Type::kF32, last));
  if (state.mipmap_mode == VK_SAMPLER_MIPMAP_MODE_NEAREST) {  // nearest(d) = ceil(d + 0.5) - 1
    out.level0 = level_index(b, b.isub(b.convert(Op::kFToS, Type::kI32, b.fceil(b.fadd(d, b.f32(0.5)))), b.i32(1)));
    return out;
  }
  const Value fx8 = round_small(b, b.fmul(d, b.f32(256)));
  out.level0 = level_index(b, b.lshr(fx8, b.i32(8)));
  const auto next = [&](Value level) { return b.umin(b.iadd(level, b.i32(1)), last); };
  out.level1 = {next(out.level0.lane), out.level0.uniform, next(out.level0.wave)};
  out.fraction = b.fmul(b.convert(Op::kSToF, Type::kF32, b.and_(fx8, b.i32(255))), b.f32(1.0 / 256));
  return out;
}

}  // namespace pineda::kernels
