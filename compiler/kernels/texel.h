// Texels in IR: the words of a texel <-> the values of its components, for every row of base/formats.inc. Used by vertex fetch,
// sampling, storage images, blending and depth. base/format_pack.cpp is the host's copy of the packing side.
#pragma once

#include <array>

#include "base/format.h"
#include "compiler/ir/builder.h"

namespace pineda::kernels {

// Bits 32 * w and on of the texel, as I32; texels of one or two bytes are zero-extended. Words that the format lacks are unset.
using Words = std::array<ir::Value, 4>;
using Channels = std::array<ir::Value, 4>;  // R, G, B, A: F32, or I32 for integer formats

inline uint32_t word_count(const FormatInfo& format) { return (format.texel_bytes + 3u) / 4; }
inline ir::Type channel_type(const FormatInfo& format) { return format.is_integer() ? ir::Type::kI32 : ir::Type::kF32; }

// Loads a texel's words: `at.offset` is the texel's first byte, at.lane_stride the distance between lanes' texels.
Words load_words(ir::Builder& b, const FormatInfo& format, const ir::Address& at, uint8_t flags);

// The component's bits as an I32 integer, sign-extended for signed formats.
ir::Value extract_code(ir::Builder& b, const FormatInfo& format, uint32_t component, const Words& words);

// The code that stands for 1.0 in normalized formats: 255 for 8-bit UNORM.
double code_scale(const FormatInfo& format, uint32_t component);
// Whether the component is stored as UNORM (alpha of sRGB formats is).
bool is_unorm(const FormatInfo& format, uint32_t component);

// One component's value, or the default (0, 0, 0, 1) when the format lacks it.
ir::Value unpack_component(ir::Builder& b, const FormatInfo& format, uint32_t component, const Words& words);
Channels unpack(ir::Builder& b, const FormatInfo& format, const Words& words);
ir::Value default_component(ir::Builder& b, ir::Type type, uint32_t component);

// value / scale, rounded once: for integers |value| below 2^24 (held as F32).
ir::Value divide_by_constant(ir::Builder& b, ir::Value value, double scale);

// Clamps to [0, 1] or [-1, 1]; NaN gives the lower bound.
ir::Value clamp(ir::Builder& b, ir::Value value, double low, double high);

// The bits of one component, ready to be placed in a word.
struct Field {
  ir::Value bits;            // I32
  uint32_t clean_bits = 32;  // bits [width, clean_bits) are zero; above is rubbish
};
Field pack_component(ir::Builder& b, const FormatInfo& format, uint32_t component, ir::Value value);
// Rounds a value in code units (0 .. code_scale, already in range up to rounding) to a UNORM field.
Field round_code(ir::Builder& b, const FormatInfo& format, uint32_t component, ir::Value code);

// Assembles fields; components whose bits are unset are left zero.
Words pack_fields(ir::Builder& b, const FormatInfo& format, const std::array<Field, 4>& fields);
Words pack(ir::Builder& b, const FormatInfo& format, const Channels& values);

// Bits of word `w` that belong to the components of `mask` (bit c: component c).
uint32_t component_mask(const FormatInfo& format, uint32_t w, uint32_t mask);

}  // namespace pineda::kernels
