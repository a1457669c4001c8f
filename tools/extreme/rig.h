// What the extreme cases run on: draws of clip-space triangles into any attachment, and compute shaders between two buffers.
#pragma once

#include <array>
#include <cstring>
#include <optional>

#include "tools/extreme/extreme.h"
#include "tools/vk/pipelines.h"
#include "tools/vk/resources.h"
#include "tools/vk/textures.h"

namespace pineda::tools {

struct RigVertex {
  std::array<float, 4> place;                // gl_Position
  std::array<float, 4> data = {1, 1, 1, 1};  // the colour, unless the fragment shader makes something else of it
};

struct RigBlend {
  VkBlendFactor source = VK_BLEND_FACTOR_ONE, destination = VK_BLEND_FACTOR_ZERO;
  VkBlendOp operation = VK_BLEND_OP_ADD;
};
inline constexpr RigBlend kAdditive{VK_BLEND_FACTOR_ONE, VK_BLEND_FACTOR_ONE};
inline constexpr RigBlend kOver{VK_BLEND_FACTOR_SRC_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA};

struct RigDraw {
  std::vector<RigVertex> vertices;  // a list of triangles
  std::optional<RigBlend> blend;    // of all four components
  bool depth_test = false;          // and writes
  VkCompareOp compare = VK_COMPARE_OP_LESS;
  float bias_constant = 0, bias_slope = 0;
  Spirv fragment;  // default: the colour is the first vertex's data
};

struct RigTarget {
  VkExtent2D extent{64, 64};
  VkFormat colour = VK_FORMAT_R32_SFLOAT;
  uint32_t bytes_per_pixel = 4;
  VkFormat depth = VK_FORMAT_UNDEFINED;
  std::array<float, 4> clear_colour = {0, 0, 0, 0};
  float clear_depth = 1;
  std::optional<VkViewport> viewport;  // default: the whole extent
};

struct RigTexture {
  const Texture& texture;
  VkSampler sampler;
};

class ExtremeRig {
 public:
  explicit ExtremeRig(VkContext& context) : context_(context) {}

  VkContext& context() { return context_; }
  bool has_format(VkFormat format, VkFormatFeatureFlags features) const;  // of images with optimal tiling
  VkPhysicalDeviceFeatures features() const;
  VkPhysicalDeviceLimits limits() const;

  std::vector<std::byte> draw(const RigTarget& target, std::span<const RigDraw> draws);
  template <typename T>
  std::vector<T> draw_as(const RigTarget& target, std::span<const RigDraw> draws) {
    return as<T>(draw(target, draws));
  }

  // Runs `groups` workgroups of a shader with a storage buffer to read at binding 0, one to write at binding 1 and, if given, a
  // texture at binding 2.
  std::vector<std::byte> compute(Spirv shader, std::span<const std::byte> input, size_t output_bytes, uint32_t groups,
                                 const RigTexture* texture = nullptr);
  template <typename Out, typename In>
  std::vector<Out> compute_as(Spirv shader, const std::vector<In>& input, size_t count, uint32_t groups,
                              const RigTexture* texture = nullptr) {
    return as<Out>(compute(shader, std::as_bytes(std::span(input)), count * sizeof(Out), groups, texture));
  }

 private:
  template <typename T>
  static std::vector<T> as(const std::vector<std::byte>& bytes) {
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
  }
  RenderPassHandle create_render_pass(const RigTarget& target);
  PipelineHandle create_pipeline(const RigTarget& target, VkRenderPass pass, VkPipelineLayout layout, const RigDraw& draw);

  VkContext& context_;
};

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Two triangles that fill a rectangle of normalised device coordinates, at depth z and w = 1.
std::vector<RigVertex> rectangle(float x0, float y0, float x1, float y1, float z, std::array<float, 4> data);

}  // namespace pineda::tools
