#include "compiler/kernels/sample_cube.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

// Directions are floats; texels of a face are integer points of a cube of side 2 n about the origin. The table of faces holds for
// both.
struct Vector {
  Value x, y, z;
};
struct OnFace {
  Value s, t, r;  // sc, tc and |rc|
};

Value negate(Builder& b, Value v) { return b.type(v) == Type::kF32 ? b.fneg(v) : b.isub(b.i32(0), v); }
Value absolute(Builder& b, Value v) { return b.type(v) == Type::kF32 ? b.fabs(v) : b.smax(v, negate(b, v)); }
Value is_negative(Builder& b, Value v) { return b.type(v) == Type::kF32 ? b.flt(v, b.f32(0)) : b.slt(v, b.i32(0)); }
Value not_less(Builder& b, Value v, Value w) { return b.type(v) == Type::kF32 ? b.fle(w, v) : b.sle(w, v); }

// z wins over y, y over x where magnitudes are equal.
Value major_face(Builder& b, const Vector& v) {
  const Value x = absolute(b, v.x), y = absolute(b, v.y), z = absolute(b, v.z);
  const auto face = [&](uint32_t positive, Value major) {
    return b.select(is_negative(b, major), b.i32(positive + 1), b.i32(positive));
  };
  const Value z_wins = b.and_(not_less(b, z, x), not_less(b, z, y));
  return b.select(z_wins, face(4, v.z), b.select(not_less(b, y, x), face(2, v.y), face(0, v.x)));
}

struct FaceBits {
  Value is_x, is_y, odd;  // the major axis; the negative face of a pair
};
FaceBits face_bits(Builder& b, Value face) {
  const Value axis = b.lshr(face, b.i32(1));
  return {b.ieq(axis, b.i32(0)), b.ieq(axis, b.i32(1)), b.ine(b.and_(face, b.i32(1)), b.i32(0))};
}

// Table "Cube map face and coordinate selection":
//     face  +X -X +Y -Y +Z -Z
//     sc    -z +z +x +x +x -x
//     tc    -y -y +z -z -y -y
//     rc     x  x  y  y  z  z
OnFace to_face(Builder& b, const FaceBits& f, const Vector& v) {
  const Value sc = b.select(f.is_x, negate(b, v.z), v.x), tc = b.select(f.is_y, v.z, negate(b, v.y));
  const Value rc = b.select(f.is_x, v.x, b.select(f.is_y, v.y, v.z));
  return {.s = b.select(b.and_(f.odd, b.not_(f.is_y)), negate(b, sc), sc),
          .t = b.select(b.and_(f.odd, f.is_y), negate(b, tc), tc),
          .r = b.select(f.odd, negate(b, rc), rc)};
}

Vector from_face(Builder& b, const FaceBits& f, const OnFace& p) {
  const Value s = b.select(b.and_(f.odd, b.not_(f.is_y)), negate(b, p.s), p.s);
  const Value t = b.select(b.and_(f.odd, f.is_y), negate(b, p.t), p.t);
  const Value r = b.select(f.odd, negate(b, p.r), p.r);
  return {.x = b.select(f.is_x, r, s),
          .y = b.select(f.is_y, r, negate(b, t)),
          .z = b.select(f.is_x, negate(b, s), b.select(f.is_y, t, r))};
}

}  // namespace

FaceRequest select_face(Builder& b, const spirv::SampleRequest& request) {
  FaceRequest out{request, {}};
  const Vector direction{request.coord[0], request.coord[1], request.coord[2]};
  out.face = major_face(b, direction);
  const FaceBits face = face_bits(b, out.face);
  const OnFace p = to_face(b, face, direction);
  const Value half = b.f32(0.5);
  const auto project = [&](Value c) { return b.fma(b.fdiv(c, p.r), half, half); };
  // The layer follows the coordinates of a face.
  out.request.coord = {project(p.s), project(p.t), request.coord[3], {}};
  if (request.lod_mode != spirv::LodMode::kGradient) return out;
  // d(s / r) = (r ds - s dr) / r^2, halved as the coordinate is ("Cube Map Derivative Transformation").
  const Value scale = b.fdiv(half, b.fmul(p.r, p.r));
  for (const auto member : {&spirv::SampleRequest::ddx, &spirv::SampleRequest::ddy}) {
    const auto& d = request.*member;
    const OnFace slope = to_face(b, face, {d[0], d[1], d[2]});
    const auto derivative = [&](Value c, Value dc) { return b.fmul(b.fsub(b.fmul(p.r, dc), b.fmul(c, slope.r)), scale); };
    out.request.*member = {derivative(p.s, slope.s), derivative(p.t, slope.t), {}};
  }
  return out;
}

// Texel centres are at the odd (n even) or even (n odd) points 2 i + 1 - n, a face's plane at n. One texel beyond the edge is n +
// 1 along the face; folded over, it is n along that axis and n - 1 along the old major one.
CubeTexel fold(Builder& b, Value face, Value i, Value j, Value n) {
  const Value one = b.i32(1), last = b.isub(n, one);
  const auto point = [&](Value index) { return b.isub(b.shl(index, one), last); };
  OnFace p{point(i), point(j), n};
  const auto beyond = [&](Value index) { return b.or_(b.slt(index, b.i32(0)), b.slt(last, index)); };
  const Value over_s = beyond(i), over_t = beyond(j);
  const auto bounded = [&](Value v) { return b.smax(b.smin(v, n), negate(b, n)); };
  p = {bounded(p.s), bounded(p.t), b.select(b.or_(over_s, over_t), last, n)};
  const Vector v = from_face(b, face_bits(b, face), p);
  const Value new_face = major_face(b, v);
  const OnFace q = to_face(b, face_bits(b, new_face), v);
  const auto index = [&](Value c) { return b.smax(b.smin(b.ashr(b.iadd(c, last), one), last), b.i32(0)); };
  return {.face = new_face, .i = index(q.s), .j = index(q.t), .corner = b.and_(over_s, over_t)};
}

}  // namespace pineda::kernels
