#include "compiler/kernels/sample_ycbcr.h"

#include <cmath>

#include "base/abi.h"
#include "compiler/kernels/sample_texel.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using compiler::YcbcrState;
using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

class YcbcrSampler {
 public:
  YcbcrSampler(Builder& b, const SampleSource& source, const spirv::SampleRequest& request, const FormatInfo& format)
      : b_(b), source_(source), state_(*source.state.ycbcr), format_(format) {
    for (uint32_t a = 0; a < 2; ++a) {
      const Value texels = word(static_cast<uint32_t>(offsetof(ImageDescriptor, width) + 4 * a));
      size_[a] = b.umax(texels, b.i32(1));
      place_[a] = b.fmul(request.coord[a], b.convert(Op::kSToF, Type::kF32, size_[a]));
    }
  }

  Channels sample() {
    const Channels luma = plane(0), chroma = plane(1);
    const Value zero = b_.f32(0), one = b_.f32(1);
    // R, G, B as the planes hold them: G is Y', B is Cb, R is Cr.
    const Value red = format_.plane_count() == 3 ? plane(2)[0] : chroma[1];
    const Channels stored{red, luma[0], chroma[0], one};
    Channels c{};
    for (uint32_t i = 0; i < 4; ++i) {
      const uint32_t from = state_.swizzle[i];
      c[i] = from < 4 ? stored[from] : from == 5 ? one : zero;
    }
    if (state_.model == VK_SAMPLER_YCBCR_MODEL_CONVERSION_RGB_IDENTITY) return c;
    const Value y = expand_luma(c[1]), cb = expand_chroma(c[2]), cr = expand_chroma(c[0]);
    if (state_.model == VK_SAMPLER_YCBCR_MODEL_CONVERSION_YCBCR_IDENTITY) return {cr, y, cb, c[3]};
    return to_rgb(y, cb, cr, c[3]);
  }

 private:
  Value word(uint32_t offset_bytes) { return b_.load(Type::kI32, source_.image, offset_bytes, kFixed); }

  // "Implicit Reconstruction": where the sample falls among the plane's texels.
  Value place_in_plane(uint32_t plane, uint32_t a) {
    const uint32_t shift = a == 0 ? format_.plane_shift_x : format_.plane_shift_y;
    if (plane == 0 || shift == 0) return place_[a];
    const bool cosited = state_.chroma_offset[a] == VK_CHROMA_LOCATION_COSITED_EVEN;
    const Value at = cosited ? b_.fadd(place_[a], b_.f32(0.5)) : place_[a];
    return b_.fmul(at, b_.f32(0.5));
  }

  Channels plane(uint32_t p) {
    compiler::TextureState state;
    state.format = format_.plane_format(p);
    const SampleSource source{state, source_.image, source_.sampler};
    TexelReader reader(b_, source, *find_format(state.format));
    LevelView level{.size = {},
                    .offset_bytes = word(static_cast<uint32_t>(offsetof(ImageDescriptor, levels) + 8 * p)),
                    .row_pitch_bytes = word(static_cast<uint32_t>(offsetof(ImageDescriptor, levels) + 8 * p + 4))};
    AxisRequest axis[2];
    for (uint32_t a = 0; a < 2; ++a) {
      const uint32_t shift = p == 0 ? 0 : a == 0 ? format_.plane_shift_x : format_.plane_shift_y;
      const Value texels = b_.lshr(b_.iadd(size_[a], b_.i32((1u << shift) - 1)), b_.i32(shift));
      level.size[a] = {texels, b_.convert(Op::kSToF, Type::kF32, texels)};
      axis[a] = {.coord = place_in_plane(p, a),
                 .size = level.size[a],
                 .mode = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                 .unnormalized = true};
    }
    const VkFilter filter = p == 0 ? source_.state.mag_filter : state_.chroma_filter;
    return filter == VK_FILTER_LINEAR ? linear(reader, level, axis) : nearest(reader, level, axis);
  }

  Channels nearest(TexelReader& reader, const LevelView& level, const AxisRequest (&axis)[2]) {
    const Value x = nearest_texel(b_, axis[0]).i, y = nearest_texel(b_, axis[1]).i;
    return reader.finish(reader.read(b_.iadd(reader.row_offset(level, y, {}), reader.column_offset(x)), {}));
  }

  Channels linear(TexelReader& reader, const LevelView& level, const AxisRequest (&axis)[2]) {
    const LinearTexels x = linear_texels(b_, axis[0]), y = linear_texels(b_, axis[1]);
    const Value one = b_.f32(1);
    const Value column[2] = {x.i0, x.i1}, row[2] = {y.i0, y.i1};
    const Value wx[2] = {b_.fsub(one, x.weight1), x.weight1}, wy[2] = {b_.fsub(one, y.weight1), y.weight1};
    Channels sum{};
    for (uint32_t tap = 0; tap < 4; ++tap) {
      const Value offset = b_.iadd(reader.row_offset(level, row[tap >> 1], {}), reader.column_offset(column[tap & 1]));
      const Channels texel = reader.read(offset, {});
      const Value weight = b_.fmul(wx[tap & 1], wy[tap >> 1]);
      for (uint32_t c = 0; c < 4; ++c) {
        if (texel[c]) sum[c] = sum[c] ? b_.fma(texel[c], weight, sum[c]) : b_.fmul(texel[c], weight);
      }
    }
    return reader.finish(sum);
  }

  // "Sampler Y'CbCr Range Expansion", for n bits a component.
  int bits() const { return find_format(format_.plane_format(0))->component[0].bits; }
  Value expand_luma(Value c) {
    if (state_.range == VK_SAMPLER_YCBCR_RANGE_ITU_FULL) return c;
    const double unit = std::ldexp(1.0, bits() - 8), most = std::ldexp(1.0, bits()) - 1;
    return b_.fma(c, b_.f32(most / (219 * unit)), b_.f32(-16.0 / 219));
  }
  Value expand_chroma(Value c) {
    const double unit = std::ldexp(1.0, bits() - 8), most = std::ldexp(1.0, bits()) - 1;
    if (state_.range == VK_SAMPLER_YCBCR_RANGE_ITU_FULL) return b_.fsub(c, b_.f32(std::ldexp(1.0, bits() - 1) / most));
    return b_.fma(c, b_.f32(most / (224 * unit)), b_.f32(-128.0 / 224));
  }

  // "Sampler Y'CbCr Model Conversion", from the weights of red and blue in Y'.
  Channels to_rgb(Value y, Value cb, Value cr, Value alpha) {
    double kr = 0.2126, kb = 0.0722;  // BT.709
    if (state_.model == VK_SAMPLER_YCBCR_MODEL_CONVERSION_YCBCR_601) kr = 0.299, kb = 0.114;
    if (state_.model == VK_SAMPLER_YCBCR_MODEL_CONVERSION_YCBCR_2020) kr = 0.2627, kb = 0.0593;
    const double kg = 1 - kr - kb;
    const Value red = b_.fma(cr, b_.f32(2 * (1 - kr)), y), blue = b_.fma(cb, b_.f32(2 * (1 - kb)), y);
    const Value part = b_.fma(cb, b_.f32(-2 * kb * (1 - kb) / kg), y);
    return {red, b_.fma(cr, b_.f32(-2 * kr * (1 - kr) / kg), part), blue, alpha};
  }

  Builder& b_;
  const SampleSource& source_;
  const YcbcrState& state_;
  const FormatInfo& format_;
  Value size_[2], place_[2];  // texels of the luma plane
};

}  // namespace

Result<Channels> sample_ycbcr(Builder& b, const SampleSource& source, const spirv::SampleRequest& request) {
  const FormatInfo* format = find_format(source.state.ycbcr->format);
  if (!format || format->plane_count() < 2 || format->is_depth_or_stencil()) {
    return compile_error("A YCbCr conversion needs a format of several colour planes.");
  }
  const bool plain = request.lod_mode != spirv::LodMode::kFetch && request.gather_component < 0 && !request.depth_reference;
  if (!plain || request.view_type != VK_IMAGE_VIEW_TYPE_2D) {
    return compile_error("Images with a YCbCr conversion are 2D and sampled without offsets, comparison or gather.");
  }
  return swizzle(b, source.state, YcbcrSampler(b, source, request, *format).sample());
}

}  // namespace pineda::kernels
