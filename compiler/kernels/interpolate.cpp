#include "compiler/kernels/interpolate.h"

#include "base/abi.h"
#include "base/sample_locations.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

namespace {

Value wave_position(Builder& b, size_t offset_bytes) {
  const Value position = b.load(Type::kI16, b.wave_ptr(), static_cast<uint32_t>(offset_bytes), kFixed);
  return b.convert(Op::kSToF, Type::kF32, b.convert(Op::kZExt, Type::kI32, position));
}

// Column (axis 0) or row (axis 1) of a lane in the block: bit `axis` of the lane, and bit `axis + 2` counting double.
Value lane_position(Builder& b, uint32_t axis) {
  const Value lane = b.lane();
  const Value low = b.and_(b.lshr(lane, b.i32(axis)), b.i32(1));
  const Value high = b.and_(b.lshr(lane, b.i32(axis + 1)), b.i32(2));
  return b.convert(Op::kSToF, Type::kF32, b.or_(low, high));
}

// Component of a sample's location from the pixel's centre, out of a table of 16 numbers of 4 bits.
Value location_component(Builder& b, uint64_t table, Value sample) {
  const Value shift = b.convert(Op::kZExt, Type::kI64, b.shl(sample, b.i32(2)));
  const Value sixteenths = b.and_(b.convert(Op::kTrunc, Type::kI32, b.lshr(b.i64(table), shift)), b.i32(15));
  return b.fmul(b.convert(Op::kSToF, Type::kF32, b.isub(sixteenths, b.i32(8))), b.f32(1.0 / 16));
}

}  // namespace

PixelOffset sample_offset(Builder& b, uint32_t samples, Value sample) {
  uint64_t x = 0, y = 0;
  for (uint32_t s = 0; s < samples; ++s) {
    x |= static_cast<uint64_t>(sample_locations(samples)[s].x) << 4 * s;
    y |= static_cast<uint64_t>(sample_locations(samples)[s].y) << 4 * s;
  }
  return {location_component(b, x, sample), location_component(b, y, sample)};
}

Value Interpolator::prim_f32(Builder& b, size_t offset_bytes) const {
  return b.load(Type::kF32, prim_, static_cast<uint32_t>(offset_bytes), kFixed);
}

Value Interpolator::linear(Builder& b, size_t ddx, size_t ddy, Value dx, Value dy) const {
  return b.fma(prim_f32(b, ddx), dx, b.fmul(prim_f32(b, ddy), dy));
}

Interpolator::Interpolator(Builder& b) : prim_(b.prim_ptr()) {
  const Value wave_x = wave_position(b, offsetof(FragmentWave, x_px)), wave_y = wave_position(b, offsetof(FragmentWave, y_px));
  const Value lane_x = lane_position(b, 0), lane_y = lane_position(b, 1);
  x_px_ = b.fadd(wave_x, lane_x);
  y_px_ = b.fadd(wave_y, lane_y);
  // Pixel centre minus origin. All terms are multiples of 1/256 below 2^15, so every sum is exact, and what is constant over the
  // block or over the draw stays apart.
  const Value half = b.f32(0.5);
  dx_ = b.fadd(b.fsub(wave_x, prim_f32(b, offsetof(FragmentPrim, x0_px))), b.fadd(lane_x, half));
  dy_ = b.fadd(b.fsub(wave_y, prim_f32(b, offsetof(FragmentPrim, y0_px))), b.fadd(lane_y, half));
  l1_ = linear(b, offsetof(FragmentPrim, l1_dx), offsetof(FragmentPrim, l1_dy), dx_, dy_);
  l2_ = linear(b, offsetof(FragmentPrim, l2_dx), offsetof(FragmentPrim, l2_dy), dx_, dy_);
}

Value Interpolator::depth(Builder& b) const {
  const Value inner = b.fma(l1_, prim_f32(b, offsetof(FragmentPrim, dz1)), prim_f32(b, offsetof(FragmentPrim, z0)));
  return b.fma(l2_, prim_f32(b, offsetof(FragmentPrim, dz2)), inner);
}

Value Interpolator::depth(Builder& b, const PixelOffset& offset) const {
  if (!offset.x) return depth(b);
  const Value dz1 = prim_f32(b, offsetof(FragmentPrim, dz1)), dz2 = prim_f32(b, offsetof(FragmentPrim, dz2));
  const auto slope = [&](size_t l1, size_t l2) { return b.fma(prim_f32(b, l1), dz1, b.fmul(prim_f32(b, l2), dz2)); };
  const Value dz_dx = slope(offsetof(FragmentPrim, l1_dx), offsetof(FragmentPrim, l2_dx));
  const Value dz_dy = slope(offsetof(FragmentPrim, l1_dy), offsetof(FragmentPrim, l2_dy));
  return b.fadd(depth(b), b.fma(dz_dx, offset.x, b.fmul(dz_dy, offset.y)));
}

Barycentrics Interpolator::barycentrics(Builder& b, const PixelOffset& offset) const {
  Barycentrics at{.l1 = l1_, .l2 = l2_};
  if (offset.x) {
    const Value dx = b.fadd(dx_, offset.x), dy = b.fadd(dy_, offset.y);
    at.l1 = linear(b, offsetof(FragmentPrim, l1_dx), offsetof(FragmentPrim, l1_dy), dx, dy);
    at.l2 = linear(b, offsetof(FragmentPrim, l2_dx), offsetof(FragmentPrim, l2_dy), dx, dy);
  }
  const Value iw0 = prim_f32(b, offsetof(FragmentPrim, iw0)), iw1 = prim_f32(b, offsetof(FragmentPrim, iw1));
  const Value iw2 = prim_f32(b, offsetof(FragmentPrim, iw2));
  at.inverse_w = b.fma(at.l2, b.fsub(iw2, iw0), b.fma(at.l1, b.fsub(iw1, iw0), iw0));
  // With one w at all vertices (screen-aligned and orthographic pictures) both slopes above are zero and inverse_w is iw0 itself,
  // so one division for the primitive gives the same bits; and any vertex is as good a base as another, so l0 is spared.
  const Value flat = b.and_(b.feq(iw0, iw1), b.feq(iw0, iw2));
  const std::vector<Value> chosen = b.if_else(
      flat, {Type::kF32, Type::kF32},
      [&] {
        const Value w = b.fdiv(b.f32(1), iw0);
        return std::vector{w, b.fmul(b.fmul(at.l1, iw1), w)};
      },
      [&] {
        const Value w = b.fdiv(b.f32(1), at.inverse_w), l0 = b.fsub(b.fsub(b.f32(1), at.l1), at.l2);
        return std::vector{w, b.fmul(b.fmul(l0, iw0), w)};
      });
  at.b2 = b.fmul(b.fmul(at.l2, iw2), chosen[0]);
  at.b_other = chosen[1];
  at.flat = flat;
  return at;
}

Value Interpolator::window_coordinate(Builder& b, uint32_t axis, const PixelOffset& offset) const {
  const Value shift = axis == 0 ? offset.x : offset.y;
  return b.fadd(axis == 0 ? x_px_ : y_px_, shift ? b.fadd(shift, b.f32(0.5)) : b.f32(0.5));
}

Value Interpolator::vertex(Builder& b, uint32_t v) const {
  return b.load(Type::kPtr, prim_, static_cast<uint32_t>(offsetof(FragmentPrim, vertex) + v * sizeof(float*)), kFixed);
}

Value Interpolator::varying(Builder& b, uint32_t slot, const spirv::InterfaceScalar& in, const Barycentrics& at) const {
  const uint32_t offset_bytes = slot * kVertexSlotBytes;
  if (in.interpolation == spirv::Interpolation::kFlat || in.type != Type::kF32) {
    const Value shift = b.load(Type::kI32, prim_, offsetof(FragmentPrim, flat_offset_bytes), kFixed);
    return b.load(in.type, b.ptr_add(vertex(b, 0), b.convert(Op::kSExt, Type::kI64, shift)), offset_bytes, kFixed);
  }
  const bool linear = in.interpolation == spirv::Interpolation::kNoPerspective;
  const auto value_at = [&](uint32_t v) { return b.load(Type::kF32, vertex(b, v), offset_bytes, kFixed); };
  const Value v0 = value_at(0), v1 = value_at(1);
  const Value a0 = linear ? v0 : b.select(at.flat, v0, v1);
  const Value d1 = b.fsub(linear ? v1 : b.select(at.flat, v1, v0), a0);
  const Value d2 = b.fsub(value_at(2), a0);
  return b.fma(linear ? at.l2 : at.b2, d2, b.fma(linear ? at.l1 : at.b_other, d1, a0));
}

}  // namespace pineda::kernels
