#include "compiler/kernels/sample_texel.h"

#include "base/abi.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

namespace {

Value image_word(Builder& b, Value image, size_t offset_bytes) {
  return b.load(Type::kI32, image, static_cast<uint32_t>(offset_bytes), kFixed);
}

}  // namespace

LevelView view_level(Builder& b, Value image, Value level) {
  LevelView view{.width = image_word(b, image, offsetof(ImageDescriptor, width)),
                 .height = image_word(b, image, offsetof(ImageDescriptor, height))};
  const size_t first = offsetof(ImageDescriptor, levels);
  if (!level) {
    view.offset_bytes = image_word(b, image, first + offsetof(MipLevel, offset_bytes));
    view.row_pitch_bytes = image_word(b, image, first + offsetof(MipLevel, row_pitch_bytes));
  } else {
    view.width = b.lshr(view.width, level);
    view.height = b.lshr(view.height, level);
    const Value record = b.shl(b.umin(level, b.i32(kMaxMipLevels)), b.i32(3));
    const auto field = [&](size_t offset_bytes) {
      return b.load(Type::kI32, {.base = image, .offset = b.iadd(record, b.i32(static_cast<uint32_t>(first + offset_bytes)))},
                    kFixed);
    };
    view.offset_bytes = field(offsetof(MipLevel, offset_bytes));
    view.row_pitch_bytes = field(offsetof(MipLevel, row_pitch_bytes));
  }
  view.width = b.umax(view.width, b.i32(1));
  view.height = b.umax(view.height, b.i32(1));
  return view;
}

TexelReader::TexelReader(Builder& b, const SampleSource& source, const FormatInfo& format, Value layer)
    : b_(b), source_(source), format_(format) {
  base_ = b.load(Type::kPtr, source.image, offsetof(ImageDescriptor, address), kFixed);
  size_bytes_ = image_word(b, source.image, offsetof(ImageDescriptor, size_bytes));
  if (layer) layer_offset_ = b.imul(layer, image_word(b, source.image, offsetof(ImageDescriptor, layer_pitch_bytes)));
}

Value TexelReader::row_offset(const LevelView& level, Value y) {
  Value offset = level.offset_bytes;
  if (y) offset = b_.iadd(offset, b_.imul(y, level.row_pitch_bytes));
  return layer_offset_ ? b_.iadd(offset, layer_offset_) : offset;
}

Value TexelReader::column_offset(Value x) { return b_.imul(x, b_.i32(format_.texel_bytes)); }

bool TexelReader::normalized(uint32_t component) const {
  return is_unorm(format_, component) || format_.numeric == Numeric::kSnorm;
}

Value TexelReader::component(uint32_t c, const Words& words) {
  if (!normalized(c)) return unpack_component(b_, format_, c, words);
  Value code = extract_code(b_, format_, c, words);
  if (format_.numeric == Numeric::kSnorm) {  // the most negative code is -1 too
    const int32_t least = -static_cast<int32_t>(code_scale(format_, c));
    code = b_.smax(code, b_.i32(static_cast<uint32_t>(least)));
  }
  return b_.convert(Op::kSToF, Type::kF32, code);
}

Value TexelReader::border(uint32_t c) {
  const uint32_t offset_bytes = static_cast<uint32_t>(offsetof(SamplerDescriptor, border) + 4 * c);
  const Value value = b_.load(channel_type(format_), source_.sampler, offset_bytes, kFixed);
  return normalized(c) ? b_.fmul(value, b_.f32(code_scale(format_, c))) : value;
}

Channels TexelReader::read(Value offset_bytes, Value inside) {
  // The size check makes every address safe, whatever a descriptor or an inactive lane holds.
  const Words words = load_words(b_, format_, {.base = base_, .offset = offset_bytes, .limit = size_bytes_}, kFixed);
  Channels out{};
  for (uint32_t c = 0; c < 4; ++c) {
    if (format_.component[c].bits == 0) continue;
    out[c] = component(c, words);
    if (inside) out[c] = b_.select(inside, out[c], border(c));
  }
  return out;
}

Channels TexelReader::finish(const Channels& filtered) {
  Channels out{};
  for (uint32_t c = 0; c < 4; ++c) {
    if (!filtered[c]) {
      out[c] = default_component(b_, channel_type(format_), c);
    } else {
      out[c] = normalized(c) ? divide_by_constant(b_, filtered[c], code_scale(format_, c)) : filtered[c];
    }
  }
  return out;
}

Value swizzle_component(Builder& b, const compiler::TextureState& state, const Channels& texel, uint32_t component) {
  const uint32_t source = state.swizzle[component];
  if (source < 4) return texel[source];
  return default_component(b, b.type(texel[0]), source == 5 ? 3 : 0);
}

Channels swizzle(Builder& b, const compiler::TextureState& state, const Channels& texel) {
  Channels out{};
  for (uint32_t c = 0; c < 4; ++c) out[c] = swizzle_component(b, state, texel, c);
  return out;
}

}  // namespace pineda::kernels
