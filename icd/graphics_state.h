// VkGraphicsPipelineCreateInfo, translated once: what selects code goes to the compiler, what is data or dynamic to the draw
// packets.
#pragma once

#include "compiler/compile.h"
#include "icd/object.h"
#include "raster/raster.h"

namespace pineda::icd {

// State that VkDynamicState can make dynamic; a pipeline holds the static values, the executor the current ones.
struct DynamicState {
  std::array<VkViewport, kMaxViewports> viewports{};
  std::array<VkRect2D, kMaxViewports> scissors{};
  float line_width = 1;
  uint32_t stipple_factor = 1;
  uint16_t stipple_pattern = 0xFFFF;
  float depth_bias_constant = 0, depth_bias_clamp = 0, depth_bias_slope = 0;
  std::array<float, 4> blend_constants{};
  std::array<float, 2> depth_bounds{};
  std::array<uint32_t, 2> stencil_compare_mask{}, stencil_write_mask{}, stencil_reference{};  // front, back
};

// Bit of a VkDynamicState: all of core 1.0 are below 31; 0 for what cannot be dynamic.
constexpr uint32_t dynamic_bit(VkDynamicState state) {
  if (state == VK_DYNAMIC_STATE_LINE_STIPPLE_EXT) return 1u << 31;
  return state <= VK_DYNAMIC_STATE_STENCIL_REFERENCE ? 1u << state : 0;
}

class Device;

struct GraphicsState {
  compiler::VertexState vertex_input;
  compiler::FragmentState fragment;
  DynamicState values;
  uint32_t dynamic_mask = 0;  // dynamic_bit of what the pipeline leaves to vkCmdSet*
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  bool primitive_restart = false;
  bool provoking_last = false;
  uint32_t viewport_count = 1;
  VkPolygonMode polygon_mode = VK_POLYGON_MODE_FILL;
  raster::LineState line;  // the width and the stipple's numbers are in `values`
  VkCullModeFlags cull = VK_CULL_MODE_NONE;
  VkFrontFace front_face = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  bool depth_clip = true, depth_bias = false;
  VkFormat depth_stencil_format = VK_FORMAT_UNDEFINED;  // of the attachment
  bool rasterizes = true;                               // false: rasterizerDiscardEnable
  bool draws_lines() const {
    switch (topology) {
      case VK_PRIMITIVE_TOPOLOGY_POINT_LIST:
        return false;
      case VK_PRIMITIVE_TOPOLOGY_LINE_LIST:
      case VK_PRIMITIVE_TOPOLOGY_LINE_STRIP:
      case VK_PRIMITIVE_TOPOLOGY_LINE_LIST_WITH_ADJACENCY:
      case VK_PRIMITIVE_TOPOLOGY_LINE_STRIP_WITH_ADJACENCY:
        return true;
      default:
        return polygon_mode == VK_POLYGON_MODE_LINE;
    }
  }
  bool draws_points() const { return topology == VK_PRIMITIVE_TOPOLOGY_POINT_LIST || polygon_mode == VK_POLYGON_MODE_POINT; }
};

VkResult translate_graphics_state(const Device& device, const VkGraphicsPipelineCreateInfo& info, GraphicsState* out);

// The static values of `from` over `to`: what vkCmdBindPipeline does.
void apply_static_state(const GraphicsState& from, DynamicState& to);

}  // namespace pineda::icd
