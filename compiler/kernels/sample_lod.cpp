#include "compiler/kernels/sample_lod.h"

#include "base/abi.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;
using spirv::LodMode;

constexpr uint32_t kQuadLane0 = 0x00, kQuadLane1 = 0x55, kQuadLane2 = 0xAA;  // QuadSwizzle patterns: every lane gets that lane

Value sampler_word(Builder& b, const SampleSource& source, size_t offset_bytes) {
  return b.load(Type::kF32, source.sampler, static_cast<uint32_t>(offset_bytes), kFixed);
}

Value image_size(Builder& b, const SampleSource& source, uint32_t axis) {
  return b.load(Type::kI32, source.image, static_cast<uint32_t>(offsetof(ImageDescriptor, width) + 4 * axis), kFixed);
}

// log2 of the longer of the two footprint axes, from the squares of their lengths.
Value base_lod(Builder& b, const SampleSource& source, const spirv::SampleRequest& request) {
  if (request.lod_mode == LodMode::kExplicit) return request.lod;
  Value rho_squared[2];
  for (uint32_t axis = 0; axis < axis_count(source.state.view_type); ++axis) {
    const Value size = b.convert(Op::kSToF, Type::kF32, image_size(b, source, axis));
    Value slope[2];
    if (request.lod_mode == LodMode::kGradient) {
      slope[0] = request.ddx[axis];
      slope[1] = request.ddy[axis];
    } else {  // one LOD for a quad: differences from its first pixel
      const Value first = b.quad_swizzle(request.coord[axis], kQuadLane0);
      slope[0] = b.fsub(b.quad_swizzle(request.coord[axis], kQuadLane1), first);
      slope[1] = b.fsub(b.quad_swizzle(request.coord[axis], kQuadLane2), first);
    }
    for (uint32_t d = 0; d < 2; ++d) {
      const Value texels = b.fmul(slope[d], size);
      rho_squared[d] = axis == 0 ? b.fmul(texels, texels) : b.fma(texels, texels, rho_squared[d]);
    }
  }
  return b.fmul(b.f32(0.5), b.flog2(b.fmax(rho_squared[0], rho_squared[1])));
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

Value level_of_detail(Builder& b, const SampleSource& source, const spirv::SampleRequest& request) {
  if (source.state.unnormalized) return {};
  Value bias = sampler_word(b, source, offsetof(SamplerDescriptor, lod_bias));
  if (request.lod_mode == LodMode::kBias && request.lod) bias = b.fadd(bias, request.lod);
  bias = clamp(b, bias, -kMaxSamplerLodBias, kMaxSamplerLodBias);
  const Value lod = b.fadd(base_lod(b, source, request), bias);
  // NaN, of coordinates that are no numbers, gives the minimum.
  const Value least = sampler_word(b, source, offsetof(SamplerDescriptor, min_lod));
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
  if (state.single_level && !filters_differ) return {};
  const Value lod = level_of_detail(b, source, request);
  if (!lod) return {};
  LevelChoice out;
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
  const Value fx8 = b.convert(Op::kFToS, Type::kI32, b.fround_even(b.fmul(d, b.f32(256))));
  out.level0 = level_index(b, b.lshr(fx8, b.i32(8)));
  const auto next = [&](Value level) { return b.umin(b.iadd(level, b.i32(1)), last); };
  out.level1 = {next(out.level0.lane), out.level0.uniform, next(out.level0.wave)};
  out.fraction = b.fmul(b.convert(Op::kSToF, Type::kF32, b.and_(fx8, b.i32(255))), b.f32(1.0 / 256));
  return out;
}

}  // namespace pineda::kernels
