#include "compiler/kernels/blend.h"

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using compiler::BlendState;
using ir::Builder;
using ir::Type;
using ir::Value;

constexpr uint32_t kAlpha = 3;

struct Equation {
  VkBlendFactor src, dst;
  VkBlendOp op;
};

Equation equation_of(const BlendState& state, uint32_t component) {
  if (component == kAlpha) return {state.src_alpha, state.dst_alpha, state.alpha_op};
  return {state.src_color, state.dst_color, state.color_op};
}

bool uses_factors(VkBlendOp op) { return op != VK_BLEND_OP_MIN && op != VK_BLEND_OP_MAX; }

bool factor_reads_destination(VkBlendFactor factor) {
  switch (factor) {
    case VK_BLEND_FACTOR_DST_COLOR:
    case VK_BLEND_FACTOR_ONE_MINUS_DST_COLOR:
    case VK_BLEND_FACTOR_DST_ALPHA:
    case VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA:
    case VK_BLEND_FACTOR_SRC_ALPHA_SATURATE:
      return true;
    default:
      return false;
  }
}

// The factors add up to one, so that a blend of values in range stays in range.
bool is_convex(const Equation& e) {
  const auto pair = [&](VkBlendFactor a, VkBlendFactor c) { return (e.src == a && e.dst == c) || (e.src == c && e.dst == a); };
  return e.op == VK_BLEND_OP_ADD && (pair(VK_BLEND_FACTOR_ONE, VK_BLEND_FACTOR_ZERO) ||
                                     pair(VK_BLEND_FACTOR_SRC_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA) ||
                                     pair(VK_BLEND_FACTOR_SRC_COLOR, VK_BLEND_FACTOR_ONE_MINUS_SRC_COLOR) ||
                                     pair(VK_BLEND_FACTOR_DST_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA) ||
                                     pair(VK_BLEND_FACTOR_DST_COLOR, VK_BLEND_FACTOR_ONE_MINUS_DST_COLOR) ||
                                     pair(VK_BLEND_FACTOR_CONSTANT_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_ALPHA) ||
                                     pair(VK_BLEND_FACTOR_CONSTANT_COLOR, VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_COLOR));
}

// Blending of one attachment in F32. UNORM components are blended in code units (0..255 for 8 bits): the destination needs no
// division, the result no multiplication, and the only rounding to the format is the last step.
class Blender {
 public:
  Blender(Builder& b, const FormatInfo& format, const Channels& source, const Words& old) : b_(b), format_(format), old_(old) {
    for (uint32_t c = 0; c < 4; ++c) source_[c] = in_range(source[c] ? source[c] : default_component(b, Type::kF32, c));
  }

  Field blend(const Equation& e, uint32_t component) {
    const bool unorm = is_unorm(format_, component);
    const Value source = unorm ? b_.fmul(source_[component], b_.f32(code_scale(format_, component))) : source_[component];
    const Value destination = unorm ? destination_code(component) : this->destination(component);
    Value result = combine(e, component, source, destination);
    if (!unorm) return pack_component(b_, format_, component, result);
    if (!is_convex(e) && uses_factors(e.op)) result = clamp(b_, result, 0, code_scale(format_, component));
    return round_code(b_, format_, component, result);
  }

 private:
  bool is_fixed_point() const { return !format_.is_float(); }

  // "If the color attachment is fixed-point, the components of the source and destination values and blend factors are each
  // clamped": no signed format is blendable.
  Value in_range(Value x) { return is_fixed_point() ? clamp(b_, x, 0, 1) : x; }

  Value destination(uint32_t component) { return unpack_component(b_, format_, component, old_); }

  Value destination_code(uint32_t component) {
    return b_.convert(ir::Op::kSToF, Type::kF32, extract_code(b_, format_, component, old_));
  }

  Value constant(uint32_t component) {
    return in_range(load_draw(b_, Type::kF32, offsetof(DrawContext, blend_constants) + component * sizeof(float)));
  }

  Value combine(const Equation& e, uint32_t component, Value source, Value destination) {
    if (e.op == VK_BLEND_OP_MIN) return b_.fmin(source, destination);
    if (e.op == VK_BLEND_OP_MAX) return b_.fmax(source, destination);
    const Value s = scaled(source, e.src, component), d = scaled(destination, e.dst, component);
    if (!s && !d) return b_.f32(0);
    if (e.op == VK_BLEND_OP_ADD) return !d ? s : !s ? d : b_.fadd(s, d);
    const Value first = e.op == VK_BLEND_OP_SUBTRACT ? s : d, second = e.op == VK_BLEND_OP_SUBTRACT ? d : s;
    return !second ? first : !first ? b_.fneg(second) : b_.fsub(first, second);
  }

  // x times the factor; unset for ZERO.
  Value scaled(Value x, VkBlendFactor factor, uint32_t component) {
    if (factor == VK_BLEND_FACTOR_ZERO) return {};
    if (factor == VK_BLEND_FACTOR_ONE || (factor == VK_BLEND_FACTOR_SRC_ALPHA_SATURATE && component == kAlpha)) return x;
    return b_.fmul(x, factor_value(factor, component));
  }

  Value one_minus(Value x) { return b_.fsub(b_.f32(1), x); }

  Value factor_value(VkBlendFactor factor, uint32_t component) {
    switch (factor) {
      case VK_BLEND_FACTOR_SRC_COLOR:
        return source_[component];
      case VK_BLEND_FACTOR_ONE_MINUS_SRC_COLOR:
        return one_minus(source_[component]);
      case VK_BLEND_FACTOR_DST_COLOR:
        return destination(component);
      case VK_BLEND_FACTOR_ONE_MINUS_DST_COLOR:
        return one_minus(destination(component));
      case VK_BLEND_FACTOR_SRC_ALPHA:
        return source_[kAlpha];
      case VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA:
        return one_minus(source_[kAlpha]);
      case VK_BLEND_FACTOR_DST_ALPHA:
        return destination(kAlpha);
      case VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA:
        return one_minus(destination(kAlpha));
      case VK_BLEND_FACTOR_CONSTANT_COLOR:
        return constant(component);
      case VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_COLOR:
        return one_minus(constant(component));
      case VK_BLEND_FACTOR_CONSTANT_ALPHA:
        return constant(kAlpha);
      case VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_ALPHA:
        return one_minus(constant(kAlpha));
      default:
        return b_.fmin(source_[kAlpha], one_minus(destination(kAlpha)));  // SRC_ALPHA_SATURATE
    }
  }

  Builder& b_;
  const FormatInfo& format_;
  const Words& old_;
  Channels source_{};
};

Result<void> check(const BlendState& state, const FormatInfo& format) {
  if (!state.blend_enable) return {};
  if (!(format.uses & kUseBlend)) return compile_error(concat("The format ", format.name, " is not blendable."));
  for (const VkBlendFactor factor : {state.src_color, state.dst_color, state.src_alpha, state.dst_alpha}) {
    if (factor > VK_BLEND_FACTOR_SRC_ALPHA_SATURATE) return compile_error("Dual-source blending is not supported.");
  }
  for (const VkBlendOp op : {state.color_op, state.alpha_op}) {
    if (op > VK_BLEND_OP_MAX) return compile_error("Advanced blend operations are not supported.");
  }
  return {};
}

}  // namespace

uint32_t written_components(const BlendState& state, const FormatInfo& format) {
  uint32_t mask = 0;
  for (uint32_t c = 0; c < 4; ++c) {
    if (format.component[c].bits != 0) mask |= state.write_mask & 1u << c;
  }
  return mask;
}

bool reads_destination(const BlendState& state, const FormatInfo& format) {
  const uint32_t written = written_components(state, format);
  if (written == 0) return false;
  if (written != written_components({.write_mask = 0xf}, format)) return true;
  if (!state.blend_enable) return false;
  for (uint32_t c = 0; c < 4; ++c) {
    if (!(written >> c & 1)) continue;
    const Equation e = equation_of(state, c);
    if (!uses_factors(e.op) || e.dst != VK_BLEND_FACTOR_ZERO || factor_reads_destination(e.src)) return true;
  }
  return false;
}

Result<void> blend_and_store(Builder& b, const BlendState& state, const FormatInfo& format, TileBlock& block,
                             const Channels& source, Value covered) {
  if (const Result<void> ok = check(state, format); !ok) return ok;
  const uint32_t written = written_components(state, format);
  if (written == 0) return {};
  std::array<Field, 4> fields{};
  const Words& old = block.old(b);
  if (state.blend_enable) {
    Blender blender(b, format, source, old);
    for (uint32_t c = 0; c < 4; ++c) {
      if (written >> c & 1) fields[c] = blender.blend(equation_of(state, c), c);
    }
  } else {
    for (uint32_t c = 0; c < 4; ++c) {
      if (!(written >> c & 1)) continue;
      fields[c] = pack_component(b, format, c, source[c] ? source[c] : default_component(b, channel_type(format), c));
    }
  }
  Words words = pack_fields(b, format, fields);
  for (uint32_t w = 0; w < word_count(format); ++w) {
    const uint32_t kept = component_mask(format, w, ~written);
    if (kept != 0) words[w] = b.or_(words[w], b.and_(old[w], b.i32(kept)));
  }
  block.store(b, words, covered);
  return {};
}

}  // namespace pineda::kernels
