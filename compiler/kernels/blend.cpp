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
  Blender(Builder& b, const FormatInfo& format, const ColorSources& sources, const Words& old)
      : b_(b), format_(format), old_(old) {
    for (uint32_t c = 0; c < 4; ++c) {
      source_[c] = in_range(sources.first[c] ? sources.first[c] : default_component(b, Type::kF32, c));
      second_[c] = in_range(sources.second[c] ? sources.second[c] : default_component(b, Type::kF32, c));
    }
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
  // clamped to [0,1] or [-1,1] respectively for an unsigned normalized or signed normalized color attachment".
  Value in_range(Value x) { return is_fixed_point() ? clamp(b_, x, is_signed() ? -1 : 0, 1) : x; }
  bool is_signed() const { return format_.numeric == Numeric::kSnorm; }

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

  // In range again: with signed values the difference may be as large as 2.
  Value one_minus(Value x) {
    const Value difference = b_.fsub(b_.f32(1), x);
    return is_signed() ? b_.fmin(difference, b_.f32(1)) : difference;
  }

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
      case VK_BLEND_FACTOR_SRC1_COLOR:
        return second_[component];
      case VK_BLEND_FACTOR_ONE_MINUS_SRC1_COLOR:
        return one_minus(second_[component]);
      case VK_BLEND_FACTOR_SRC1_ALPHA:
        return second_[kAlpha];
      case VK_BLEND_FACTOR_ONE_MINUS_SRC1_ALPHA:
        return one_minus(second_[kAlpha]);
      default:
        return b_.fmin(source_[kAlpha], one_minus(destination(kAlpha)));  // SRC_ALPHA_SATURATE
    }
  }

  Builder& b_;
  const FormatInfo& format_;
  const Words& old_;
  Channels source_{}, second_{};
};

// Logical operations work on codes; "Logical operations are not applied to floating-point or sRGB format color attachments",
// whose source values pass.
bool takes_logic_op(const FormatInfo& format) { return format.numeric != Numeric::kSfloat && format.numeric != Numeric::kSrgb; }

bool logic_op_reads_destination(VkLogicOp op) {
  return op != VK_LOGIC_OP_CLEAR && op != VK_LOGIC_OP_COPY && op != VK_LOGIC_OP_COPY_INVERTED && op != VK_LOGIC_OP_SET;
}

Value logic(Builder& b, VkLogicOp op, Value s, Value d) {
  switch (op) {
    case VK_LOGIC_OP_CLEAR:
      return b.i32(0);
    case VK_LOGIC_OP_AND:
      return b.and_(s, d);
    case VK_LOGIC_OP_AND_REVERSE:
      return b.and_(s, b.not_(d));
    case VK_LOGIC_OP_AND_INVERTED:
      return b.and_(b.not_(s), d);
    case VK_LOGIC_OP_NO_OP:
      return d;
    case VK_LOGIC_OP_XOR:
      return b.xor_(s, d);
    case VK_LOGIC_OP_OR:
      return b.or_(s, d);
    case VK_LOGIC_OP_NOR:
      return b.not_(b.or_(s, d));
    case VK_LOGIC_OP_EQUIVALENT:
      return b.not_(b.xor_(s, d));
    case VK_LOGIC_OP_INVERT:
      return b.not_(d);
    case VK_LOGIC_OP_OR_REVERSE:
      return b.or_(s, b.not_(d));
    case VK_LOGIC_OP_COPY_INVERTED:
      return b.not_(s);
    case VK_LOGIC_OP_OR_INVERTED:
      return b.or_(b.not_(s), d);
    case VK_LOGIC_OP_NAND:
      return b.not_(b.and_(s, d));
    case VK_LOGIC_OP_SET:
      return b.i32(~0u);
    default:
      return s;  // COPY
  }
}

}  // namespace

Result<void> check(const ColorOperation& operation) {
  const BlendState& state = operation.state;
  if (!state.blend_enable || operation.logic_op) return {};
  if (!(operation.format.uses & kUseBlend))
    return compile_error(concat("The format ", operation.format.name, " is not blendable."));
  for (const VkBlendOp op : {state.color_op, state.alpha_op}) {
    if (op > VK_BLEND_OP_MAX) return compile_error("Advanced blend operations are not supported.");
  }
  return {};
}

uint32_t written_components(const BlendState& state, const FormatInfo& format) {
  uint32_t mask = 0;
  for (uint32_t c = 0; c < 4; ++c) {
    if (format.component[c].bits != 0) mask |= state.write_mask & 1u << c;
  }
  return mask;
}

bool reads_destination(const ColorOperation& operation) {
  const BlendState& state = operation.state;
  const uint32_t written = written_components(state, operation.format);
  if (written == 0) return false;
  if (written != written_components({.write_mask = 0xf}, operation.format)) return true;
  if (operation.logic_op) return takes_logic_op(operation.format) && logic_op_reads_destination(*operation.logic_op);
  if (!state.blend_enable) return false;
  for (uint32_t c = 0; c < 4; ++c) {
    if (!(written >> c & 1)) continue;
    const Equation e = equation_of(state, c);
    if (!uses_factors(e.op) || e.dst != VK_BLEND_FACTOR_ZERO || factor_reads_destination(e.src)) return true;
  }
  return false;
}

namespace {

// What the operation makes of component c.
Field combined(Builder& b, const ColorOperation& operation, uint32_t c, const Channels& source, const Words& old) {
  const FormatInfo& format = operation.format;
  const Value value = source[c] ? source[c] : default_component(b, channel_type(format), c);
  const Field field = pack_component(b, format, c, value);
  if (!operation.logic_op || !takes_logic_op(format)) return field;
  return {logic(b, *operation.logic_op, field.bits, extract_code(b, format, c, old)), format.component[c].bits};
}

}  // namespace

void blend_and_store(Builder& b, const ColorOperation& operation, TileBlock& block, const ColorSources& sources, Value covered) {
  const FormatInfo& format = operation.format;
  const uint32_t written = written_components(operation.state, format);
  if (written == 0) return;
  std::array<Field, 4> fields{};
  const Words& old = block.old(b);
  const bool blends = operation.state.blend_enable && !operation.logic_op;
  if (blends) {
    Blender blender(b, format, sources, old);
    for (uint32_t c = 0; c < 4; ++c) {
      if (written >> c & 1) fields[c] = blender.blend(equation_of(operation.state, c), c);
    }
  } else {
    for (uint32_t c = 0; c < 4; ++c) {
      if (written >> c & 1) fields[c] = combined(b, operation, c, sources.first, old);
    }
  }
  Words words = pack_fields(b, format, fields);
  for (uint32_t w = 0; w < word_count(format); ++w) {
    const uint32_t kept = component_mask(format, w, ~written);
    if (kept != 0) words[w] = b.or_(words[w], b.and_(old[w], b.i32(kept)));
  }
  block.store(b, words, covered);
}

}  // namespace pineda::kernels
