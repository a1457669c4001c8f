// Sampling as the chapter "Image Operations" writes it, in double precision, without shortcuts.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstddef>
#include <vector>

#include "cts-subset/reference/formats.h"

namespace pineda::cts {

enum class Shape { k1D, k2D, k3D, kCube, k1DArray, k2DArray, kCubeArray };

struct TextureLevel {
  int width = 1, height = 1, depth = 1;
  std::vector<Colour> texels;  // x fastest, then y, z, layer
};

// A texture with its texels decoded. Layers of cubes are faces: 6 * cube + face.
struct Texture {
  Shape shape = Shape::k2D;
  int layers = 1;
  std::vector<TextureLevel> levels;
};

struct SamplerState {
  VkFilter mag = VK_FILTER_NEAREST, min = VK_FILTER_NEAREST;
  VkSamplerMipmapMode mip = VK_SAMPLER_MIPMAP_MODE_NEAREST;
  std::array<VkSamplerAddressMode, 3> address{};
  Colour border{};
  double bias = 0, min_lod = 0, max_lod = 1000;
  bool compare = false;
  VkCompareOp compare_op = VK_COMPARE_OP_NEVER;
  bool unnormalized = false;
};

// A result and how far an implementation may be from it: `slack` is what half a step of the sub-texel and of the mip fraction can
// change.
struct Sample {
  Colour value{};
  Colour slack{};
};

// `coordinate`: s, t, r (cubes: a direction), and the layer last where there is one (s, layer for 1D arrays; s, t, layer;
// direction, layer). `lod` is the explicit level of detail before bias and clamps.
Sample sample(const Texture& texture, const SamplerState& state, std::array<double, 4> coordinate, double lod,
              double reference = 0, std::array<int, 3> offset = {}, int sub_texel_bits = 8, int mip_bits = 8);

// The four texels that linear filtering of the base level would read, in gather's order; `component` 0 to 3.
Colour gather(const Texture& texture, const SamplerState& state, std::array<double, 4> coordinate, size_t component,
              double reference = 0, std::array<int, 3> offset = {});

struct FacePoint {
  int face;
  double s, t;  // 0 to 1
};
FacePoint cube_point(double x, double y, double z);

}  // namespace pineda::cts
