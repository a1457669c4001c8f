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

// What the descriptor says of a level. `level`: unset, wave or lane rate.
LevelView load_level(Builder& b, Value image, Value level) {
  Value width = image_word(b, image, offsetof(ImageDescriptor, width)),
        height = image_word(b, image, offsetof(ImageDescriptor, height)),
        depth = image_word(b, image, offsetof(ImageDescriptor, depth));
  Value record = b.i32(0);
  if (level) {
    width = b.lshr(width, level);
    height = b.lshr(height, level);
    depth = b.lshr(depth, level);
    record = b.shl(b.umin(level, b.i32(kMaxMipLevels)), b.i32(3));
  }
  const auto field = [&](size_t offset_bytes) {
    const Value offset = b.iadd(record, b.i32(static_cast<uint32_t>(offsetof(ImageDescriptor, levels) + offset_bytes)));
    return b.load(Type::kI32, {.base = image, .offset = offset}, kFixed);
  };
  const auto size = [&](Value texels) {
    texels = b.umax(texels, b.i32(1));
    return AxisSize{texels, b.convert(Op::kSToF, Type::kF32, texels)};
  };
  return {.size = {size(width), size(height), size(depth)},
          .offset_bytes = field(offsetof(MipLevel, offset_bytes)),
          .row_pitch_bytes = field(offsetof(MipLevel, row_pitch_bytes))};
}

}  // namespace

LevelView view_level(Builder& b, Value image, const LevelIndex& level) {
  if (!level) return load_level(b, image, {});
  const auto list = [&](Value l) {
    const LevelView v = load_level(b, image, l);
    std::vector<Value> values{v.offset_bytes, v.row_pitch_bytes};
    for (const AxisSize& size : v.size) values.insert(values.end(), {size.texels, size.texels_f32});
    return values;
  };
  const std::vector<Type> types{Type::kI32, Type::kI32, Type::kI32, Type::kF32, Type::kI32, Type::kF32, Type::kI32, Type::kF32};
  const std::vector<Value> v = b.if_else(
      level.uniform, types, [&] { return list(level.wave); }, [&] { return list(level.lane); });
  return {.size = {{{v[2], v[3]}, {v[4], v[5]}, {v[6], v[7]}}}, .offset_bytes = v[0], .row_pitch_bytes = v[1]};
}

TexelReader::TexelReader(Builder& b, const SampleSource& source, const FormatInfo& format)
    : b_(b), source_(source), format_(format) {
  // Bounded indices stay inside the memory that the descriptor describes. A null image is an all-zero descriptor of one texel at
  // offset zero: it reads the descriptor's own zeros.
  const Value size_bytes = image_word(b, source.image, offsetof(ImageDescriptor, size_bytes));
  const Value address = b.load(Type::kPtr, source.image, offsetof(ImageDescriptor, address), kFixed);
  base_ = b.select(b.ine(size_bytes, b.i32(0)), address, source.image);
}

void TexelReader::check(Value inside) {
  limit_ = b_.select(inside, image_word(b_, source_.image, offsetof(ImageDescriptor, size_bytes)), b_.i32(0));
}

Value TexelReader::layer_offset(Value layer) {
  return b_.imul(layer, image_word(b_, source_.image, offsetof(ImageDescriptor, layer_pitch_bytes)));
}

Value TexelReader::row_offset(const LevelView& level, Value y, Value z) {
  if (!y) return level.offset_bytes;
  const Value row = b_.iadd(level.offset_bytes, b_.imul(y, level.row_pitch_bytes));
  if (!z) return row;
  // Slices follow each other. Their pitch is the same for all lanes where the level is, and both slices of a sample share `row`.
  return b_.iadd(row, b_.imul(z, b_.imul(level.size[1].texels, level.row_pitch_bytes)));
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

Words TexelReader::read_words(Value offset_bytes) {
  // Not kSpeculate: an index is bounded where the lane is active; elsewhere the size that bounds it may be rubbish.
  return load_words(b_, format_, {.base = base_, .offset = offset_bytes, .limit = limit_}, ir::kInvariant);
}

std::array<Words, 2> TexelReader::read_pair(Value offset_bytes, Value second_row) {
  const Value base = second_row ? b_.ptr_add(base_, second_row) : base_;
  const Value pair = b_.load(Type::kI64, {.base = base, .offset = offset_bytes}, ir::kInvariant);
  std::array<Words, 2> out{};
  out[0][0] = b_.convert(Op::kTrunc, Type::kI32, pair);
  out[1][0] = b_.convert(Op::kTrunc, Type::kI32, b_.lshr(pair, b_.i64(32)));
  return out;
}

Channels TexelReader::decode(const Words& words, Value inside) {
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
