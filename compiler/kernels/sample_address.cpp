#include "compiler/kernels/sample_address.h"

#include "compiler/kernels/texel.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

bool is_border(VkSamplerAddressMode mode) { return mode == VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER; }

// Repeating modes with a texel offset wrap the integer index; otherwise the coordinate is wrapped before it is scaled, which
// loses nothing of it.
bool wraps_integers(const AxisRequest& axis) {
  return axis.offset != 0 &&
         (axis.mode == VK_SAMPLER_ADDRESS_MODE_REPEAT || axis.mode == VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT);
}

// The position along the axis in texels, in a range of at most [-1, 2 * size]; NaN gives the lower end. Whatever lies further out
// wraps to or is clamped to the same texels.
Value position(Builder& b, const AxisRequest& axis) {
  const Value size = b.convert(Op::kSToF, Type::kF32, axis.size);
  const Value u = axis.coord;
  switch (axis.mode) {
    case VK_SAMPLER_ADDRESS_MODE_REPEAT:
      return b.fmul(clamp(b, b.fsub(u, b.ffloor(u)), 0, 1), size);
    case VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT: {
      const Value even = b.fmul(b.f32(2), b.ffloor(b.fmul(u, b.f32(0.5))));
      const Value period = clamp(b, b.fsub(u, even), 0, 2);
      if (wraps_integers(axis)) return b.fmul(period, size);
      return b.fmul(b.fmin(period, b.fsub(b.f32(2), period)), size);
    }
    default:
      break;
  }
  Value s = axis.unnormalized ? u : b.fmul(u, size);
  if (axis.mode == VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE) s = b.fabs(s);
  if (axis.offset != 0) s = b.fadd(s, b.f32(axis.offset));
  return b.fmin(b.fmax(b.f32(-1), s), b.fadd(size, b.f32(1)));
}

// i modulo n, for n > 0.
Value modulo(Builder& b, Value i, Value n) {
  const Value r = b.srem(i, n);
  return b.select(b.slt(r, b.i32(0)), b.iadd(r, n), r);
}

Value wrap_integer(Builder& b, const AxisRequest& axis, Value i) {
  i = b.iadd(i, b.i32(static_cast<uint32_t>(axis.offset)));
  if (axis.mode == VK_SAMPLER_ADDRESS_MODE_REPEAT) return modulo(b, i, axis.size);
  const Value period = b.shl(axis.size, b.i32(1));
  const Value j = modulo(b, i, period);
  return b.umin(j, b.isub(b.isub(period, b.i32(1)), j));
}

// `inside` for the border mode, else the index brought into range.
struct Bounded {
  Value i, inside;
};
Bounded bound(Builder& b, const AxisRequest& axis, Value i) {
  if (is_border(axis.mode)) return {i, b.ult(i, axis.size)};
  if (wraps_integers(axis)) return {wrap_integer(b, axis, i), {}};
  return {b.smin(b.smax(i, b.i32(0)), b.isub(axis.size, b.i32(1))), {}};
}

}  // namespace

NearestTexel nearest_texel(Builder& b, const AxisRequest& axis) {
  // Positions are bounded, so the conversion never saturates. A wrapped coordinate that rounds up to 1 is a tiny negative one:
  // last texel.
  const Value i = b.convert(Op::kFToS, Type::kI32, b.ffloor(position(b, axis)));
  const Bounded bounded = bound(b, axis, i);
  return {bounded.i, bounded.inside};
}

LinearTexels linear_texels(Builder& b, const AxisRequest& axis) {
  // Position of the lower texel's centre in 1/256 texel: (s - 0.5) * 256, rounded to nearest even by the constant 1.5 * 2^23,
  // which leaves the integer in the low bits (|s| is below 2^15).
  constexpr double kRound = 0x1.8p23;
  const Value shifted = b.fma(position(b, axis), b.f32(256), b.f32(kRound - 128));
  const Value fx8 = b.isub(b.op(Op::kBitcast, Type::kI32, {shifted}), b.i32(0x4B400000));
  const Value i0 = b.ashr(fx8, b.i32(8)), i1 = b.iadd(i0, b.i32(1));
  LinearTexels out;
  out.weight1 = b.fmul(b.convert(Op::kSToF, Type::kF32, b.and_(fx8, b.i32(255))), b.f32(1.0 / 256));
  if (axis.mode == VK_SAMPLER_ADDRESS_MODE_REPEAT && !wraps_integers(axis)) {  // i0 in [-1, size), i1 in [0, size]
    out.i0 = b.select(b.slt(i0, b.i32(0)), b.isub(axis.size, b.i32(1)), i0);
    out.i1 = b.select(b.slt(i1, axis.size), i1, b.i32(0));
    return out;
  }
  const Bounded low = bound(b, axis, i0), high = bound(b, axis, i1);
  out.i0 = low.i;
  out.inside0 = low.inside;
  out.i1 = high.i;
  out.inside1 = high.inside;
  return out;
}

}  // namespace pineda::kernels
