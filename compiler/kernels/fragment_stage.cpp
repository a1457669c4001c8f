#include "compiler/kernels/fragment_stage.h"

#include "base/abi.h"
#include "base/sample_locations.h"
#include "compiler/kernels/kernels.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;
using spirv::BuiltIn;

Value prim_i32(Builder& b, size_t offset_bytes) {
  return b.load(Type::kI32, b.prim_ptr(), static_cast<uint32_t>(offset_bytes), kFixed);
}

Value as(Builder& b, Type type, Value b1) { return type == Type::kB1 ? b1 : b.convert(Op::kZExt, type, b1); }

PixelOffset offset_of(Builder& b, const FragmentPlace& place) {
  return place.sample ? sample_offset(b, place.samples, place.sample) : PixelOffset{};
}

}  // namespace

FragmentStage::FragmentStage(const compiler::GraphicsSource& source, Builder& b, const FragmentPlace& place)
    : Stage(*source.layout, source.textures),
      place_(place),
      offset_(offset_of(b, place)),
      at_(place.position.barycentrics(b, offset_)),
      centroid_(place.samples > 1 && !place.sample ? place.position.barycentrics(b, centroid(b)) : at_) {}

// The pixel's centre when all its samples are covered, else the first covered sample ("a location within both the pixel and the
// primitive"); helper lanes take the centre.
PixelOffset FragmentStage::centroid(Builder& b) const {
  const Value all = b.ieq(place_.mask, b.i32((1u << place_.samples) - 1));
  const Value first = b.ctz(place_.mask);
  const PixelOffset sample = sample_offset(b, place_.samples, b.and_(first, b.i32(place_.samples - 1)));
  const Value at_centre = b.or_(all, b.not_(place_.covered));
  return {b.select(at_centre, b.f32(0), sample.x), b.select(at_centre, b.f32(0), sample.y)};
}

Value FragmentStage::input(Builder& b, const spirv::InterfaceScalar& in) {
  if (const Value common = common_input(b, in)) return common;
  if (in.built_in) return built_in(b, in);
  if (ir::size_bytes(in.type) != 4 || in.component > 3) return {};
  const Barycentrics& at = in.at == spirv::InterpolationAt::kCentroid ? centroid_ : at_;
  return place_.position.varying(b, provisional_slot(in.location, in.component), in, at);
}

Value FragmentStage::input_at(Builder& b, const spirv::InterfaceScalar& in, const spirv::InterpolationPlace& place) {
  if (in.built_in || in.type != Type::kF32 || in.component > 3) return {};
  PixelOffset offset{place.offset[0], place.offset[1]};
  if (place.sample && place_.samples > 1)
    offset = sample_offset(b, place_.samples, b.and_(place.sample, b.i32(place_.samples - 1)));
  const Barycentrics at = place.centroid ? centroid_ : place_.position.barycentrics(b, offset);
  return place_.position.varying(b, provisional_slot(in.location, in.component), in, at);
}

void FragmentStage::output(Builder& b, const spirv::InterfaceScalar& out, Value value) {
  if (out.built_in) {
    if (*out.built_in == BuiltIn::kFragDepth) depth = value;
    if (*out.built_in == BuiltIn::kFragStencilRef) stencil_reference = value;
    if (*out.built_in == BuiltIn::kSampleMask && out.component == 0) sample_mask = value;
    return;
  }
  if (out.location >= kMaxColorAttachments || out.component >= 4 || ir::size_bytes(b.type(value)) != 4) return;
  ColorSources& sources = color[out.location];
  if (out.index <= 1) (out.index == 0 ? sources.first : sources.second)[out.component] = value;
}

Value FragmentStage::frag_coord(Builder& b, uint32_t component) {
  switch (component) {
    case 2:
      return place_.position.depth(b, offset_);
    case 3:
      return at_.inverse_w;
    default:
      return place_.position.window_coordinate(b, component, offset_);
  }
}

Value FragmentStage::built_in(Builder& b, const spirv::InterfaceScalar& in) {
  switch (*in.built_in) {
    case BuiltIn::kFragCoord:
      return frag_coord(b, in.component);
    case BuiltIn::kFrontFacing:
      return as(b, in.type, b.ine(prim_i32(b, offsetof(FragmentPrim, front_facing)), b.i32(0)));
    case BuiltIn::kPrimitiveId:
      return prim_i32(b, offsetof(FragmentPrim, primitive_id));
    case BuiltIn::kLayer:
      return prim_i32(b, offsetof(FragmentPrim, layer));
    case BuiltIn::kViewportIndex:
      return prim_i32(b, offsetof(FragmentPrim, viewport_index));
    case BuiltIn::kViewIndex:
      return load_draw(b, Type::kI32, offsetof(DrawContext, view_index));
    case BuiltIn::kPointCoord:  // what a point's planes are made for
      return in.component == 0 ? at_.l1 : at_.l2;
    case BuiltIn::kClipDistance:
    case BuiltIn::kCullDistance: {
      const auto slot = built_in_slot(*in.built_in, in.component);
      return place_.position.varying(b, provisional_slot(slot->location, slot->component), in, at_);
    }
    case BuiltIn::kHelperInvocation:
      return as(b, in.type, b.not_(place_.covered));
    case BuiltIn::kSampleId:
      return place_.sample ? place_.sample : b.i32(0);
    case BuiltIn::kSamplePosition:
      return offset_.x ? b.fadd(in.component == 0 ? offset_.x : offset_.y, b.f32(0.5)) : b.f32(0.5);
    case BuiltIn::kSampleMask:
      return place_.mask ? place_.mask : b.convert(Op::kZExt, Type::kI32, place_.covered);
    default:
      return {};
  }
}

}  // namespace pineda::kernels
