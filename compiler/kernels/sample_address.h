// From a texture coordinate to texel indices along one axis (Vulkan 1.3, sections 16.6 "Unnormalized Texel Coordinate Operations"
// and 16.8.1 "Wrapping Operation").
#pragma once

#include <vulkan/vulkan_core.h>

#include "compiler/ir/builder.h"

namespace pineda::kernels {

// x rounded to the nearest even integer, for |x| < 2^22 and no NaN: in three instructions fewer than the saturating conversion.
ir::Value round_small(ir::Builder& b, ir::Value x);

struct AxisSize {
  ir::Value texels;  // I32, at least 1
  ir::Value texels_f32;
};

struct AxisRequest {
  ir::Value coord;  // F32
  AxisSize size;
  VkSamplerAddressMode mode = VK_SAMPLER_ADDRESS_MODE_REPEAT;
  bool unnormalized = false;
  int32_t offset = 0;        // texels
  ir::Value dynamic_offset;  // I32, instead of `offset` when it is set
  bool unweighted = false;   // linear texels without weights, for gathers: the position is not rounded to 1/256 texel
};

// Indices are in [0, size) whatever the coordinate, NaN included, so reads need no further check. Where `inside` is false (border
// mode) the border colour replaces the texel.
struct NearestTexel {
  ir::Value i;       // I32
  ir::Value inside;  // B1; unset = always
};
struct LinearTexels {
  ir::Value i0, i1;
  ir::Value inside0, inside1;
  ir::Value weight1;      // F32, of i1: a multiple of 1/256 in [0, 1)
  ir::Value weight1_fx8;  // I32, 0..255
};

NearestTexel nearest_texel(ir::Builder& b, const AxisRequest& axis);
LinearTexels linear_texels(ir::Builder& b, const AxisRequest& axis);

// Without wrapping: for clamped modes without offset i0 is in [-1, size - 1].
struct LinearPosition {
  ir::Value i0;           // I32
  ir::Value weight1;      // F32
  ir::Value weight1_fx8;  // I32
  bool in_image = false;  // i0 is in [-1, size - 1]
};
LinearPosition linear_position(ir::Builder& b, const AxisRequest& axis);

// linear_texels is wrap_linear of linear_position. Wrapping changes nothing where texel_before_wrapping gives a lower texel i
// with i and i + 1 in the image.
LinearTexels wrap_linear(ir::Builder& b, const AxisRequest& axis, const LinearPosition& position);
ir::Value texel_before_wrapping(ir::Builder& b, const AxisRequest& axis, const LinearPosition& position);

}  // namespace pineda::kernels
