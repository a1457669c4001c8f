#include "compiler/kernels/sample_address.h"

#include "compiler/kernels/texel.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

bool is_border(const AxisRequest& axis) { return axis.mode == VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER; }
bool is_repeat(const AxisRequest& axis) { return axis.mode == VK_SAMPLER_ADDRESS_MODE_REPEAT; }
bool is_mirrored(const AxisRequest& axis) { return axis.mode == VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT; }

bool is_mirror_clamped(const AxisRequest& axis) { return axis.mode == VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE; }

// Repeating and mirroring modes with a texel offset wrap the integer index, for the offset comes first; otherwise the coordinate
// is wrapped before it is scaled, which loses nothing of it. Where a coordinate is mirrored its two texels change places with
// their weights; gathers have none, so they mirror the indices.
bool has_offset(const AxisRequest& axis) { return axis.offset != 0 || axis.dynamic_offset; }
bool wraps_integers(const AxisRequest& axis) {
  const bool mirrors = is_mirrored(axis) || is_mirror_clamped(axis);
  return (has_offset(axis) && (is_repeat(axis) || mirrors)) || (axis.unweighted && mirrors);
}

Value offset_i32(Builder& b, const AxisRequest& axis) {
  return axis.dynamic_offset ? axis.dynamic_offset : b.i32(static_cast<uint32_t>(axis.offset));
}

// Position along the axis in texels: value * scale (value alone when scale is unset). NaN gives one of the ends.
struct Position {
  Value value, scale;
  bool in_image = false;  // in [0, size]; otherwise in [-1, 2 * size]
};

// Whatever lies further out than the position's range wraps to, or is clamped to, the same texels. fmax and fmin with the bound
// as first operand give the bound for NaN.
Position position(Builder& b, const AxisRequest& axis) {
  const Value u = axis.coord, size = axis.size.texels_f32, zero = b.f32(0), one = b.f32(1);
  if (is_repeat(axis)) return {b.fmax(zero, b.fsub(u, b.ffloor(u))), size, !wraps_integers(axis)};
  if (is_mirrored(axis)) {
    const Value even = b.fmul(b.f32(2), b.ffloor(b.fmul(u, b.f32(0.5))));
    const Value period = b.fmax(zero, b.fsub(u, even));
    if (wraps_integers(axis)) return {period, size};
    return {b.fmin(period, b.fsub(b.f32(2), period)), size, true};
  }
  if (!axis.unnormalized && !has_offset(axis)) {
    if (axis.mode == VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE) return {b.fmin(b.fmax(zero, u), one), size, true};
    if (is_mirror_clamped(axis) && !axis.unweighted) return {b.fmin(one, b.fabs(u)), size, true};
  }
  Value s = axis.unnormalized ? u : b.fmul(u, size);
  if (is_mirror_clamped(axis)) {  // the offset, of less than 128 texels, is added later
    const Value end = b.fadd(size, b.f32(128));
    return {b.fmin(b.fmax(b.fneg(end), s), end), {}};
  }
  if (has_offset(axis)) s = b.fadd(s, b.convert(Op::kSToF, Type::kF32, offset_i32(b, axis)));
  return {b.fmin(b.fmax(b.f32(-1), s), b.fadd(size, one)), {}};
}

Value last_texel(Builder& b, const AxisRequest& axis) { return b.isub(axis.size.texels, b.i32(1)); }

// i modulo n, for n > 0.
Value modulo(Builder& b, Value i, Value n) {
  const Value r = b.srem(i, n);
  return b.select(b.slt(r, b.i32(0)), b.iadd(r, n), r);
}

// (i + offset) modulo n for i in [-1, n]: the offset alone is divided, once for both texels and, where it is a constant, once for
// the whole draw. Of j, j + n and j - n, taken as unsigned numbers, the one in [0, n) is the least.
Value wrap_moved(Builder& b, const AxisRequest& axis, Value i, Value n) {
  const Value j = b.iadd(i, modulo(b, offset_i32(b, axis), n));
  return b.umin(b.umin(j, b.iadd(j, n)), b.isub(j, n));
}

Value wrap_integer(Builder& b, const AxisRequest& axis, Value i) {
  if (is_repeat(axis)) return wrap_moved(b, axis, i, axis.size.texels);  // wraps integers only when there is an offset
  if (is_mirror_clamped(axis)) {
    if (has_offset(axis)) i = b.iadd(i, offset_i32(b, axis));
    return b.umin(b.xor_(i, b.ashr(i, b.i32(31))), last_texel(b, axis));  // i or -(1 + i)
  }
  const Value period = b.shl(axis.size.texels, b.i32(1));
  Value j;
  if (has_offset(axis)) {
    j = wrap_moved(b, axis, i, period);
  } else {  // -1 .. period
    j = b.select(b.slt(i, b.i32(0)), b.iadd(i, period), i);
    j = b.select(b.slt(j, period), j, b.isub(j, period));
  }
  return b.umin(j, b.isub(b.isub(period, b.i32(1)), j));
}

// An index from a position that is not known to be in the image.
struct Bounded {
  Value i, inside;
};
Bounded bound(Builder& b, const AxisRequest& axis, Value i) {
  const Value last = last_texel(b, axis);
  if (is_border(axis)) return {b.umin(i, last), b.ult(i, axis.size.texels)};
  if (wraps_integers(axis)) return {wrap_integer(b, axis, i), {}};
  return {b.smin(b.smax(i, b.i32(0)), last), {}};
}

}  // namespace

// Adding 1.5 * 2^23 leaves the integer in the low bits.
Value round_small(Builder& b, Value x) {
  return b.isub(b.op(Op::kBitcast, Type::kI32, {b.fadd(x, b.f32(0x1.8p23))}), b.i32(0x4B400000));
}

NearestTexel nearest_texel(Builder& b, const AxisRequest& axis) {
  const Position p = position(b, axis);
  const Value s = p.scale ? b.fmul(p.value, p.scale) : p.value;
  if (p.in_image) {  // a coordinate that was rounded up to the image's end belongs to its last texel
    return {b.umin(b.convert(Op::kFToS, Type::kI32, s), last_texel(b, axis)), {}};
  }
  const Bounded bounded = bound(b, axis, b.convert(Op::kFToS, Type::kI32, b.ffloor(s)));
  return {bounded.i, bounded.inside};
}

namespace {

// Position of the lower texel's centre in 1/256 texel: (s - 0.5) * 256, rounded to nearest even by the constant 1.5 * 2^23, which
// leaves the integer in the low bits (|s| is below 2^15).
LinearPosition lower_texel(Builder& b, const AxisRequest& axis, const Position& p) {
  if (axis.unweighted) {
    const Value s = b.fma(p.value, p.scale ? p.scale : b.f32(1), b.f32(-0.5));
    return {.i0 = round_small(b, b.ffloor(s)), .weight1 = {}, .weight1_fx8 = {}, .in_image = p.in_image};
  }
  constexpr double kRound = 0x1.8p23;
  const Value scale = p.scale ? b.fmul(p.scale, b.f32(256)) : b.f32(256);
  const Value bits = b.op(Op::kBitcast, Type::kI32, {b.fma(p.value, scale, b.f32(kRound - 128))});
  const Value fx8 = b.and_(bits, b.i32(255));
  return {.i0 = b.ashr(b.isub(bits, b.i32(0x4B400000)), b.i32(8)),
          .weight1 = b.fmul(b.convert(Op::kSToF, Type::kF32, fx8), b.f32(1.0 / 256)),
          .weight1_fx8 = fx8,
          .in_image = p.in_image};
}

}  // namespace

LinearPosition linear_position(Builder& b, const AxisRequest& axis) { return lower_texel(b, axis, position(b, axis)); }

Value texel_before_wrapping(Builder& b, const AxisRequest& axis, const LinearPosition& position) {
  return wraps_integers(axis) && has_offset(axis) ? b.iadd(position.i0, offset_i32(b, axis)) : position.i0;
}

LinearTexels wrap_linear(Builder& b, const AxisRequest& axis, const LinearPosition& lower) {
  const Value i0 = lower.i0, i1 = b.iadd(i0, b.i32(1));
  LinearTexels out;
  out.weight1 = lower.weight1;
  out.weight1_fx8 = lower.weight1_fx8;
  if (lower.in_image) {  // i0 in [-1, size), i1 in [0, size]
    const Value last = last_texel(b, axis);
    out.i0 = is_repeat(axis) ? b.umin(i0, last) : b.smax(i0, b.i32(0));
    out.i1 = is_repeat(axis) ? b.select(b.slt(i1, axis.size.texels), i1, b.i32(0)) : b.umin(i1, last);
    return out;
  }
  const Bounded low = bound(b, axis, i0), high = bound(b, axis, i1);
  out.i0 = low.i;
  out.inside0 = low.inside;
  out.i1 = high.i;
  out.inside1 = high.inside;
  return out;
}

LinearTexels linear_texels(Builder& b, const AxisRequest& axis) { return wrap_linear(b, axis, linear_position(b, axis)); }

}  // namespace pineda::kernels
