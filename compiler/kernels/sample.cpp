#include "compiler/kernels/sample.h"

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/sample_filter.h"
#include "compiler/kernels/sample_ycbcr.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using compiler::TextureState;
using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;
using spirv::LodMode;
using spirv::SampleRequest;

constexpr uint32_t kQuadLane0 = 0x00, kQuadLane1 = 0x55, kQuadLane2 = 0xAA;  // QuadSwizzle patterns: every lane gets that lane

// While it lives, no addition and multiplication of different origin become one FMA.
class Uncontracted {
 public:
  explicit Uncontracted(Builder& b) : b_(b), before_(b.contraction()) { b.set_contraction(false); }
  ~Uncontracted() { b_.set_contraction(before_); }
  Uncontracted(const Uncontracted&) = delete;
  Uncontracted& operator=(const Uncontracted&) = delete;

 private:
  Builder& b_;
  const bool before_;
};

Result<const FormatInfo*> check(const TextureState& state, const SampleRequest& request) {
  if (state.view_type > VK_IMAGE_VIEW_TYPE_CUBE_ARRAY) return compile_error("The image view's type is not known.");
  // A shader that declares another dimension than the view has is invalid use; it gets an error, not a read of unset coordinates.
  const uint32_t coordinates = axis_count(state.view_type) + is_array(state.view_type);
  for (uint32_t c = 0; c < coordinates; ++c) {
    if (!request.coord[c]) return compile_error("The image view has more dimensions than the shader declares.");
  }
  if (is_cube(state.view_type) != is_cube(request.view_type)) {
    return compile_error("The image view is a cube and the shader declares none, or the other way round.");
  }
  const FormatInfo* format = find_format(state.format);
  if (!format || !(format->uses & (kUseSampled | kUseUniformTexel))) {  // texel buffers are fetched through here, too
    return compile_error(concat("Format ", static_cast<int>(state.format), " cannot be sampled."));
  }
  return format;
}

Value image_word(Builder& b, Value image, size_t offset_bytes) {
  return b.load(Type::kI32, image, static_cast<uint32_t>(offset_bytes), kFixed);
}

// Integer coordinates, no sampler. Outside the image or its levels the texel's words are zero (robustImageAccess).
Channels fetch(Builder& b, const SampleSource& source, const SampleRequest& request, const FormatInfo& format) {
  const VkImageViewType type = source.state.view_type;
  const uint32_t axes = axis_count(type);
  TexelReader reader(b, source, format);
  Value inside = b.b1(true), layer_offset, level;
  if (is_array(type)) {
    const Value layer = request.coord[axes];
    inside = b.ult(layer, image_word(b, source.image, offsetof(ImageDescriptor, layer_count)));
    layer_offset = reader.layer_offset(layer);
  }
  if (request.lod && !source.state.single_level) {
    level = request.lod;
    inside = b.and_(inside, b.ult(level, image_word(b, source.image, offsetof(ImageDescriptor, level_count))));
  } else if (request.lod) {
    inside = b.and_(inside, b.ieq(request.lod, b.i32(0)));
  }
  const LevelView view = view_level(b, source.image, level ? level_index(b, level) : LevelIndex{});
  Value index[3];
  for (uint32_t a = 0; a < axes; ++a) {
    index[a] = b.iadd(request.coord[a], b.i32(static_cast<uint32_t>(request.offset[a])));
    inside = b.and_(inside, b.ult(index[a], view.size[a].texels));
  }
  if (request.sample) {  // samples follow each other as slices do
    inside = b.and_(inside, b.ult(request.sample, image_word(b, source.image, offsetof(ImageDescriptor, depth))));
    index[2] = request.sample;
  }
  reader.check(inside);
  Value offset = b.iadd(reader.row_offset(view, index[1], index[2]), reader.column_offset(index[0]));
  if (layer_offset) offset = b.iadd(offset, layer_offset);
  return swizzle(b, source.state, reader.finish(reader.read(offset, {})));
}

// Valid programs ask for the type that the format has.
Channels to_type(Builder& b, Type type, Channels values) {
  for (Value& v : values) v = b.bitcast(type, v);
  return values;
}

}  // namespace

SampleRequest with_gradients(Builder& b, SampleRequest request, uint32_t axes) {
  if (request.lod_mode != LodMode::kImplicit) return request;
  const Uncontracted uncontracted(b);
  request.lod_mode = LodMode::kGradient;
  for (uint32_t a = 0; a < axes && request.coord[a]; ++a) {
    const Value first = b.quad_swizzle(request.coord[a], kQuadLane0);
    request.ddx[a] = b.fsub(b.quad_swizzle(request.coord[a], kQuadLane1), first);
    request.ddy[a] = b.fsub(b.quad_swizzle(request.coord[a], kQuadLane2), first);
  }
  return request;
}

Result<Channels> sample_image(Builder& b, const SampleSource& source, const SampleRequest& request) {
  const Result<const FormatInfo*> format = check(source.state, request);
  if (!format) return std::unexpected(format.error());
  if (ir::size_bytes(request.result) != 4) return compile_error("Only 32-bit sampling results are supported.");
  const Uncontracted uncontracted(b);
  if (source.state.ycbcr) return sample_ycbcr(b, source, request);
  if (request.lod_mode == LodMode::kFetch) return to_type(b, request.result, fetch(b, source, request, **format));
  Filter filter(b, source, with_gradients(b, request, axis_count(request.view_type)), **format);
  return to_type(b, request.result, request.gather_component >= 0 ? filter.gather() : filter.sample());
}

Result<Channels> query_image(Builder& b, Value image, const spirv::ImageQuery& query) {
  using Kind = spirv::ImageQuery::Kind;
  const Value zero = b.i32(0), one = b.i32(1);
  switch (query.kind) {
    case Kind::kLevels:
      return Channels{image_word(b, image, offsetof(ImageDescriptor, level_count)), zero, zero, zero};
    case Kind::kSamples:
      return Channels{image_word(b, image, offsetof(ImageDescriptor, depth)), zero, zero, zero};
    case Kind::kSize: {
      Channels size{
          image_word(b, image, offsetof(ImageDescriptor, width)), image_word(b, image, offsetof(ImageDescriptor, height)),
          image_word(b, image, offsetof(ImageDescriptor, depth)), image_word(b, image, offsetof(ImageDescriptor, layer_count))};
      for (uint32_t a = 0; a < 3 && query.lod; ++a) {  // a null image has size zero
        size[a] = b.umax(b.lshr(size[a], query.lod), b.umin(size[a], one));
      }
      return size;
    }
    case Kind::kLod:
      break;
  }
  return compile_error("A LOD query needs image and sampler.");
}

SampleRequest lod_request(Builder& b, const spirv::ImageQuery& query) {
  SampleRequest r;
  r.view_type = query.view_type;
  r.coord = query.coord;
  const uint32_t axes = axis_count(r.view_type);
  if (is_array(r.view_type)) r.coord[axes] = b.f32(0);  // a query names no layer
  return with_gradients(b, r, axes);
}

Result<Channels> query_lod(Builder& b, const SampleSource& source, const SampleRequest& request) {
  if (const auto ok = check(source.state, request); !ok) return std::unexpected(ok.error());
  const Uncontracted uncontracted(b);
  const Value zero = b.f32(0);
  const SampleRequest r = is_cube(request.view_type) ? select_face(b, request).request : request;
  const Value lod = level_of_detail(b, source, r);
  if (!lod) return Channels{zero, zero, zero, zero};
  const Value last = b.isub(image_word(b, source.image, offsetof(ImageDescriptor, level_count)), b.i32(1));
  Value accessed = b.fmin(b.fmax(zero, lod), b.convert(Op::kSToF, Type::kF32, last));
  if (source.state.mipmap_mode == VK_SAMPLER_MIPMAP_MODE_NEAREST)
    accessed = b.fsub(b.fceil(b.fadd(accessed, b.f32(0.5))), b.f32(1));
  return Channels{accessed, lod, zero, zero};
}

}  // namespace pineda::kernels
