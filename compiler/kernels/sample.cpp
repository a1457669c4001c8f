#include "compiler/kernels/sample.h"

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/depth.h"
#include "compiler/kernels/sample_address.h"
#include "compiler/kernels/sample_lod.h"
#include "compiler/kernels/sample_texel.h"
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

bool is_array(VkImageViewType type) {
  return type == VK_IMAGE_VIEW_TYPE_1D_ARRAY || type == VK_IMAGE_VIEW_TYPE_2D_ARRAY || type == VK_IMAGE_VIEW_TYPE_CUBE_ARRAY;
}

Result<const FormatInfo*> check(const TextureState& state, const SampleRequest& request) {
  if (state.view_type > VK_IMAGE_VIEW_TYPE_CUBE_ARRAY || axis_count(state.view_type) > 2) {
    return compile_error("Sampling of 3D and cube images is not supported.");
  }
  // A shader that declares another dimension than the view has is invalid use; it gets an error, not a read of unset coordinates.
  const uint32_t coordinates = axis_count(state.view_type) + is_array(state.view_type);
  for (uint32_t c = 0; c < coordinates; ++c) {
    if (!request.coord[c]) return compile_error("The image view has more dimensions than the shader declares.");
  }
  const FormatInfo* format = find_format(state.format);
  if (!format || !(format->uses & kUseSampled)) {
    return compile_error(concat("Format ", static_cast<int>(state.format), " cannot be sampled."));
  }
  return format;
}

class Sampler {
 public:
  Sampler(Builder& b, const SampleSource& source, const SampleRequest& request, const FormatInfo& format)
      : b_(b),
        source_(source),
        state_(source.state),
        request_(request),
        format_(format),
        axes_(axis_count(source.state.view_type)),
        reader_(b, source, format, layer(b, source, request)) {
    if (request.depth_reference) {  // compared in the format's range
      const bool unorm = format.numeric == Numeric::kUnorm;
      reference_ = unorm ? clamp(b, request.depth_reference, 0, 1) : request.depth_reference;
    }
  }

  Channels sample() {
    const LevelChoice choice = choose_levels(b_, source_, request_);
    Channels texel = filter(choice, choice.level0);
    if (choice.fraction) texel = mix_levels(choice, texel);
    if (reference_) return {texel[0], b_.f32(0), b_.f32(0), b_.f32(1)};
    return swizzle(b_, state_, reader_.finish(texel));
  }

  // The four texels of the linear footprint, counter-clockwise from the lower left (section 16.9.5 "Texel Gathering").
  Channels gather() {
    LevelIndex level;
    if (request_.lod_mode != LodMode::kImplicit && !state_.single_level) level = choose_levels(b_, source_, request_).level0;
    const Footprint f = footprint(view_level(b_, source_.image, level));
    Channels out{};
    constexpr uint32_t kColumn[4] = {0, 1, 1, 0}, kRow[4] = {1, 1, 0, 0};
    for (uint32_t i = 0; i < 4; ++i) {
      const Channels texel = tap(f, kColumn[i], axes_ == 2 ? kRow[i] : 0);
      const uint32_t component = static_cast<uint32_t>(request_.gather_component);
      out[i] = reference_ ? texel[0] : swizzle_component(b_, state_, reader_.finish(texel), component);
    }
    return out;
  }

 private:
  struct Footprint {
    Value column[2], row[2];         // byte offsets
    Value inside_x[2], inside_y[2];  // unset = always
    Value weight_x, weight_y;        // of column[1], row[1]
  };

  static Value layer(Builder& b, const SampleSource& source, const SampleRequest& request) {
    if (!is_array(source.state.view_type)) return {};
    // RNE(layer), clamped to [0, layer_count - 1]
    const Value index = b.convert(Op::kFToS, Type::kI32, b.fround_even(request.coord[axis_count(source.state.view_type)]));
    const Value count = b.load(Type::kI32, source.image, offsetof(ImageDescriptor, layer_count), kFixed);
    return b.smax(b.smin(index, b.isub(count, b.i32(1))), b.i32(0));
  }

  AxisRequest axis(const LevelView& level, uint32_t a) const {
    return {.coord = request_.coord[a],
            .size = a == 0 ? level.width : level.height,
            .mode = state_.address[a],
            .unnormalized = state_.unnormalized,
            .offset = request_.offset[a]};
  }

  Value both(Value x, Value y) { return x && y ? b_.and_(x, y) : x ? x : y; }

  Footprint footprint(const LevelView& level) {
    const LinearTexels x = linear_texels(b_, axis(level, 0));
    Footprint f{.column = {reader_.column_offset(x.i0), reader_.column_offset(x.i1)},
                .inside_x = {x.inside0, x.inside1},
                .weight_x = x.weight1};
    if (axes_ == 1) {
      f.row[0] = reader_.row_offset(level, {});
      return f;
    }
    const LinearTexels y = linear_texels(b_, axis(level, 1));
    f.row[0] = reader_.row_offset(level, y.i0);
    f.row[1] = reader_.row_offset(level, y.i1);
    f.inside_y[0] = y.inside0;
    f.inside_y[1] = y.inside1;
    f.weight_y = y.weight1;
    return f;
  }

  // One texel of the footprint in filter units; the comparison's outcome when there is one.
  Channels tap(const Footprint& f, uint32_t column, uint32_t row) {
    return read(b_.iadd(f.row[row], f.column[column]), both(f.inside_x[column], f.inside_y[row]));
  }

  Channels read(Value offset_bytes, Value inside) {
    Channels texel = reader_.read(offset_bytes, inside);
    if (!reference_) return texel;
    const Value depth = reader_.finish(texel)[0];
    return {b_.select(compare(b_, state_.compare, reference_, depth), b_.f32(1), b_.f32(0))};
  }

  Channels nearest(const LevelView& level) {
    const NearestTexel x = nearest_texel(b_, axis(level, 0));
    NearestTexel y;
    if (axes_ == 2) y = nearest_texel(b_, axis(level, 1));
    return read(b_.iadd(reader_.row_offset(level, y.i), reader_.column_offset(x.i)), both(x.inside, y.inside));
  }

  // Weighted sum over the footprint. Weights are multiples of 2^-16 that add up to one; in code units of 8-bit formats no step
  // rounds.
  Channels linear(const LevelView& level) {
    const Footprint f = footprint(level);
    const Value one = b_.f32(1);
    const Value wx[2] = {b_.fsub(one, f.weight_x), f.weight_x};
    const Value wy[2] = {axes_ == 2 ? b_.fsub(one, f.weight_y) : one, f.weight_y};
    Channels sum{};
    for (uint32_t row = 0; row < axes_; ++row) {
      for (uint32_t column = 0; column < 2; ++column) {
        const Value weight = axes_ == 2 ? b_.fmul(wx[column], wy[row]) : wx[column];
        const Channels texel = tap(f, column, row);
        for (uint32_t c = 0; c < 4; ++c) {
          if (texel[c]) sum[c] = sum[c] ? b_.fma(texel[c], weight, sum[c]) : b_.fmul(texel[c], weight);
        }
      }
    }
    return sum;
  }

  Channels filter_with(VkFilter filter, const LevelView& level) {
    return filter == VK_FILTER_LINEAR && !format_.is_integer() ? linear(level) : nearest(level);
  }

  // Applies the minification or magnification filter, whichever each lane needs; a wave that needs one runs one.
  Channels filter(const LevelChoice& choice, const LevelIndex& level) {
    const LevelView view = view_level(b_, source_.image, level);
    if (!choice.magnify) return filter_with(state_.mag_filter, view);
    return channels_if(
        choice.magnify, [&] { return filter_with(state_.mag_filter, view); },
        [&] { return filter_with(state_.min_filter, view); });
  }

  // Lanes with fraction zero keep their first level, so a wave in which all do skips the second.
  Channels mix_levels(const LevelChoice& choice, const Channels& first) {
    return channels_if(
        b_.fne(choice.fraction, b_.f32(0)),
        [&] {
          const Channels second = filter(choice, choice.level1);
          Channels mixed{};
          for (uint32_t c = 0; c < 4; ++c) {
            if (first[c]) mixed[c] = b_.fma(choice.fraction, b_.fsub(second[c], first[c]), first[c]);
          }
          return mixed;
        },
        [&] { return first; });
  }

  // An If whose sides give the channels that the reader gives.
  template <typename Then, typename Else>
  Channels channels_if(Value cond, const Then& then_body, const Else& else_body) {
    std::vector<uint32_t> present;
    for (uint32_t c = 0; c < 4; ++c) {
      if (reference_ ? c == 0 : format_.component[c].bits != 0) present.push_back(c);
    }
    const auto list = [&](const Channels& texel) {
      std::vector<Value> values;
      for (const uint32_t c : present) values.push_back(texel[c]);
      return values;
    };
    const Type type = reference_ ? Type::kF32 : channel_type(format_);
    const std::vector<Value> values = b_.if_else(
        cond, std::vector<Type>(present.size(), type), [&] { return list(then_body()); }, [&] { return list(else_body()); });
    Channels out{};
    for (size_t i = 0; i < present.size(); ++i) out[present[i]] = values[i];
    return out;
  }

  Builder& b_;
  const SampleSource& source_;
  const TextureState& state_;
  const SampleRequest& request_;
  const FormatInfo& format_;
  const uint32_t axes_;
  TexelReader reader_;
  Value reference_;
};

// Integer coordinates, no sampler. Outside the image or its levels the texel's words are zero (robustImageAccess).
Channels fetch(Builder& b, const SampleSource& source, const SampleRequest& request, const FormatInfo& format) {
  const VkImageViewType type = source.state.view_type;
  const uint32_t axes = axis_count(type);
  Value inside = b.b1(true), layer, level;
  if (is_array(type)) {
    layer = request.coord[axes];
    inside = b.ult(layer, b.load(Type::kI32, source.image, offsetof(ImageDescriptor, layer_count), kFixed));
  }
  if (request.lod && !source.state.single_level) {
    level = request.lod;
    inside = b.and_(inside, b.ult(level, b.load(Type::kI32, source.image, offsetof(ImageDescriptor, level_count), kFixed)));
  } else if (request.lod) {
    inside = b.and_(inside, b.ieq(request.lod, b.i32(0)));
  }
  const LevelView view = view_level(b, source.image, level ? level_index(b, level) : LevelIndex{});
  Value index[2];
  for (uint32_t a = 0; a < axes; ++a) {
    index[a] = b.iadd(request.coord[a], b.i32(static_cast<uint32_t>(request.offset[a])));
    inside = b.and_(inside, b.ult(index[a], (a == 0 ? view.width : view.height).texels));
  }
  TexelReader reader(b, source, format, layer);
  reader.check(inside);
  const Value offset = b.iadd(reader.row_offset(view, index[1]), reader.column_offset(index[0]));
  return swizzle(b, source.state, reader.finish(reader.read(offset, {})));
}

// Valid programs ask for the type that the format has.
Channels to_type(Builder& b, Type type, Channels values) {
  for (Value& v : values) v = b.bitcast(type, v);
  return values;
}

}  // namespace

Result<Channels> sample_image(Builder& b, const SampleSource& source, const SampleRequest& request) {
  const Result<const FormatInfo*> format = check(source.state, request);
  if (!format) return std::unexpected(format.error());
  if (ir::size_bytes(request.result) != 4) return compile_error("Only 32-bit sampling results are supported.");
  if (request.lod_mode == LodMode::kFetch) return to_type(b, request.result, fetch(b, source, request, **format));
  Sampler sampler(b, source, request, **format);
  return to_type(b, request.result, request.gather_component >= 0 ? sampler.gather() : sampler.sample());
}

Result<Channels> query_image(Builder& b, Value image, const SampleSource* source, const spirv::ImageQuery& query) {
  using Kind = spirv::ImageQuery::Kind;
  const auto word = [&](size_t offset_bytes) { return b.load(Type::kI32, image, static_cast<uint32_t>(offset_bytes), kFixed); };
  const Value zero = b.i32(0), one = b.i32(1);
  switch (query.kind) {
    case Kind::kLevels:
      return Channels{word(offsetof(ImageDescriptor, level_count)), zero, zero, zero};
    case Kind::kSamples:
      return Channels{one, zero, zero, zero};
    case Kind::kSize: {
      Channels size{word(offsetof(ImageDescriptor, width)), word(offsetof(ImageDescriptor, height)),
                    word(offsetof(ImageDescriptor, depth)), word(offsetof(ImageDescriptor, layer_count))};
      for (uint32_t a = 0; a < 3 && query.lod; ++a) {  // a null image has size zero
        size[a] = b.umax(b.lshr(size[a], query.lod), b.umin(size[a], one));
      }
      return size;
    }
    case Kind::kLod:
      break;
  }
  if (!source) return compile_error("A LOD query needs the state of image and sampler.");
  SampleRequest request;
  request.view_type = query.view_type;
  request.coord = query.coord;
  if (is_array(source->state.view_type)) return compile_error("LOD queries of array images are not supported.");
  if (const auto ok = check(source->state, request); !ok) return std::unexpected(ok.error());
  const Value lod = level_of_detail(b, *source, request);
  if (!lod) return Channels{b.f32(0), b.f32(0), b.f32(0), b.f32(0)};
  const Value last = b.isub(word(offsetof(ImageDescriptor, level_count)), one);
  Value accessed = b.fmin(b.fmax(b.f32(0), lod), b.convert(Op::kSToF, Type::kF32, last));
  if (source->state.mipmap_mode == VK_SAMPLER_MIPMAP_MODE_NEAREST)
    accessed = b.fsub(b.fceil(b.fadd(accessed, b.f32(0.5))), b.f32(1));
  return Channels{accessed, lod, b.f32(0), b.f32(0)};
}

}  // namespace pineda::kernels
