// An image of any dimension with random texels, and the specification's "Image Operations" (Vulkan 1.3, chapter 16) over it in
// double precision, written from the text alone: nothing here is shared with the code under test.
#pragma once

#include "compiler/kernels/sample.h"
#include "compiler/kernels/test_rig.h"

namespace pineda::kernels::test {

struct ImageShape {
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
  VkImageViewType type = VK_IMAGE_VIEW_TYPE_2D;
  uint32_t width = 1, height = 1, depth = 1, levels = 1, layers = 1;  // layers of a cube count its faces
};

class TestImage {
 public:
  TestImage(const ImageShape& image_shape, std::mt19937& random);

  const ImageShape shape;
  const FormatInfo& format;
  ImageDescriptor descriptor{};  // sampler words: no LOD limits, a border colour of its own

  int size(uint32_t axis, uint32_t level) const;
  double texel(int x, int y, int z, uint32_t layer, uint32_t level, uint32_t component) const;

 private:
  std::vector<uint8_t> bytes_;
};

struct SpecSample {
  std::array<double, 3> coord{};  // the direction, for a cube
  double layer = 0;
  double lod = 0;  // after bias and clamps
  std::array<int, 3> offset{};
  double depth_reference = 0;          // when the state compares
  std::array<double, 3> ddx{}, ddy{};  // for anisotropy
  bool anisotropic = false;
};

class SpecSampler {
 public:
  SpecSampler(const TestImage& image, const compiler::TextureState& state) : image_(image), state_(state) {}

  double sample(const SpecSample& request, uint32_t component);
  std::array<double, 4> gather(const SpecSample& request, uint32_t component);

  // Set when the answer hangs on a rounding that binary32 may decide otherwise; such samples are left out.
  bool near_boundary = false;

 private:
  struct Place {  // where a sample falls, on a face for a cube
    std::array<double, 3> coord;
    uint32_t layer;  // with a cube's face
  };
  Place place(const SpecSample& request);
  void guard(double x, double phase, double margin = 0.02);
  double tap(const std::array<int, 3>& index, uint32_t layer, uint32_t level, uint32_t component) const;
  double cube_tap(int i, int j, uint32_t layer, uint32_t level, uint32_t component) const;
  double border(uint32_t component) const;
  double outcome(double texel) const;
  double one_level(const Place& at, uint32_t level, VkFilter filter, uint32_t component);
  double levels(const Place& at, double lod, uint32_t component);
  double combine(double first, double second, double weight2) const;
  uint32_t axes() const;
  bool cube() const;

  const TestImage& image_;
  const compiler::TextureState& state_;
  std::array<int, 3> offset_{};
  double depth_reference_ = 0;
};

}  // namespace pineda::kernels::test
