#include "compiler/kernels/interpolate.h"

#include "base/abi.h"
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

}  // namespace

Value Interpolator::prim_f32(Builder& b, size_t offset_bytes) const {
  return b.load(Type::kF32, prim_, static_cast<uint32_t>(offset_bytes), kFixed);
}

Interpolator::Interpolator(Builder& b) : prim_(b.prim_ptr()) {
  const Value wave_x = wave_position(b, offsetof(FragmentWave, x_px)), wave_y = wave_position(b, offsetof(FragmentWave, y_px));
  const Value lane_x = lane_position(b, 0), lane_y = lane_position(b, 1);
  x_px_ = b.fadd(wave_x, lane_x);
  y_px_ = b.fadd(wave_y, lane_y);
  // Pixel centre minus origin. All terms are multiples of 1/256 below 2^15, so every sum is exact, and what is constant over the
  // block or over the draw stays apart.
  const Value half = b.f32(0.5);
  const Value dx = b.fadd(b.fsub(wave_x, prim_f32(b, offsetof(FragmentPrim, x0_px))), b.fadd(lane_x, half));
  const Value dy = b.fadd(b.fsub(wave_y, prim_f32(b, offsetof(FragmentPrim, y0_px))), b.fadd(lane_y, half));
  const auto barycentric = [&](size_t ddx, size_t ddy) { return b.fma(prim_f32(b, ddx), dx, b.fmul(prim_f32(b, ddy), dy)); };
  l1_ = barycentric(offsetof(FragmentPrim, l1_dx), offsetof(FragmentPrim, l1_dy));
  l2_ = barycentric(offsetof(FragmentPrim, l2_dx), offsetof(FragmentPrim, l2_dy));
}

Value Interpolator::depth(Builder& b) const {
  const Value inner = b.fma(l1_, prim_f32(b, offsetof(FragmentPrim, dz1)), prim_f32(b, offsetof(FragmentPrim, z0)));
  return b.fma(l2_, prim_f32(b, offsetof(FragmentPrim, dz2)), inner);
}

void Interpolator::begin_shading(Builder& b) {
  const Value iw0 = prim_f32(b, offsetof(FragmentPrim, iw0)), iw1 = prim_f32(b, offsetof(FragmentPrim, iw1));
  const Value iw2 = prim_f32(b, offsetof(FragmentPrim, iw2));
  inverse_w_ = b.fma(l2_, b.fsub(iw2, iw0), b.fma(l1_, b.fsub(iw1, iw0), iw0));
  const Value w = b.fdiv(b.f32(1), inverse_w_);
  b1_ = b.fmul(b.fmul(l1_, iw1), w);
  b2_ = b.fmul(b.fmul(l2_, iw2), w);
}

Value Interpolator::frag_coord(Builder& b, uint32_t component) const {
  switch (component) {
    case 0:
      return b.fadd(x_px_, b.f32(0.5));
    case 1:
      return b.fadd(y_px_, b.f32(0.5));
    case 2:
      return depth(b);
    default:
      return inverse_w_;
  }
}

Value Interpolator::vertex(Builder& b, uint32_t v) const {
  return b.load(Type::kPtr, prim_, static_cast<uint32_t>(offsetof(FragmentPrim, vertex) + v * sizeof(float*)), kFixed);
}

Value Interpolator::varying(Builder& b, uint32_t slot, const spirv::InterfaceScalar& in) const {
  const uint32_t offset_bytes = slot * kVertexSlotBytes;
  if (in.interpolation == spirv::Interpolation::kFlat || in.type != Type::kF32) {
    const Value shift = b.load(Type::kI32, prim_, offsetof(FragmentPrim, flat_offset_bytes), kFixed);
    return b.load(in.type, b.ptr_add(vertex(b, 0), b.convert(Op::kSExt, Type::kI64, shift)), offset_bytes, kFixed);
  }
  const Value a0 = b.load(Type::kF32, vertex(b, 0), offset_bytes, kFixed);
  const Value d1 = b.fsub(b.load(Type::kF32, vertex(b, 1), offset_bytes, kFixed), a0);
  const Value d2 = b.fsub(b.load(Type::kF32, vertex(b, 2), offset_bytes, kFixed), a0);
  const bool linear = in.interpolation == spirv::Interpolation::kNoPerspective;
  return b.fma(linear ? l2_ : b2_, d2, b.fma(linear ? l1_ : b1_, d1, a0));
}

}  // namespace pineda::kernels
