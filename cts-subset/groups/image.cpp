// image.*: storage images of every format, texel buffers, views with swizzles, levels, layers and other formats.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/compare.h"
#include "cts-subset/reference/formats.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kWidth = 9, kHeight = 5;

const char* prefix_of(const FormatInfo& info) { return !info.is_integer() ? "" : info.is_signed() ? "i" : "u"; }

enum class Shape { k1D, k2D, k3D, k2DArray, kCube, kBuffer };
constexpr std::pair<Shape, const char*> kShapes[] = {{Shape::k1D, "1D"},     {Shape::k2D, "2D"},
                                                     {Shape::k3D, "3D"},     {Shape::k2DArray, "2DArray"},
                                                     {Shape::kCube, "Cube"}, {Shape::kBuffer, "Buffer"}};

ImageDesc desc_of(Shape shape, VkFormat format) {
  ImageDesc desc;
  desc.format = format;
  desc.extent = {kWidth, kHeight, 1};
  desc.usage |= VK_IMAGE_USAGE_STORAGE_BIT;
  if (shape == Shape::k1D) desc.extent.height = 1, desc.type = VK_IMAGE_TYPE_1D, desc.view_type = VK_IMAGE_VIEW_TYPE_1D;
  if (shape == Shape::k3D) desc.extent.depth = 3, desc.type = VK_IMAGE_TYPE_3D, desc.view_type = VK_IMAGE_VIEW_TYPE_3D;
  if (shape == Shape::k2DArray) desc.layers = 3, desc.view_type = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
  if (shape == Shape::kCube) {
    desc.extent = {5, 5, 1}, desc.layers = 6, desc.view_type = VK_IMAGE_VIEW_TYPE_CUBE;
    desc.flags = VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
  }
  return desc;
}

// A texel buffer or an image, and all its texels as one array of z, y, x.
struct Storage {
  Image image;
  Buffer buffer;
  BufferView view;
  VkExtent3D size{};  // layers are depth
  Descriptor descriptor;
};

Storage create_storage(Device& device, Shape shape, const FormatInfo& info, std::span<const std::byte> texels, uint32_t binding) {
  Storage s;
  if (shape == Shape::kBuffer) {
    require(device.format(info.format).bufferFeatures & VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_BIT, "storage texel buffers");
    s.size = {kWidth, 1, 1};
    s.buffer = create_buffer(device, texels.first(size_t{kWidth} * info.bytes), VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT);
    VkBufferViewCreateInfo view{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    view.buffer = s.buffer.handle;
    view.format = info.format;
    view.range = VkDeviceSize{kWidth} * info.bytes;
    s.view = make<VkBufferView, vkDestroyBufferView>(device, vkCreateBufferView, view, "vkCreateBufferView");
    s.descriptor = {binding, VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, {}, {}, {s.view}};
    return s;
  }
  require(device.format(info.format).optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT, "storage images");
  const ImageDesc desc = desc_of(shape, info.format);
  s.image = create_image(device, desc);
  s.size = {desc.extent.width, desc.extent.height, std::max(desc.extent.depth, desc.layers)};
  const size_t layer_bytes = size_t{desc.extent.width} * desc.extent.height * desc.extent.depth * info.bytes;
  for (uint32_t layer = 0; layer < desc.layers; ++layer)
    upload(device, s.image, texels.subspan(layer * layer_bytes, layer_bytes), 0, layer, VK_IMAGE_LAYOUT_GENERAL);
  s.descriptor = storage_image(binding, s.image);
  return s;
}

std::vector<std::byte> read_storage(Device& device, const Storage& s, const FormatInfo& info) {
  if (!s.image.handle) return {s.buffer.mapped, s.buffer.mapped + size_t{s.size.width} * info.bytes};
  std::vector<std::byte> all;
  for (uint32_t layer = 0; layer < s.image.desc.layers; ++layer) {
    const VkImageLayout layout = layer ? VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL : VK_IMAGE_LAYOUT_GENERAL;
    const std::vector<std::byte> part = download(device, s.image, layout, 0, layer);
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

std::vector<std::byte> random_texels(const FormatInfo& info, size_t count, Random& random) {
  std::vector<std::byte> texels(count * info.bytes);
  for (size_t i = 0; i < count; ++i) {
    Colour colour;
    for (double& v : colour) v = info.is_integer() ? random.below(2) : random.between(-1, 1);
    if (!info.is_integer() && !info.is_signed()) {
      for (double& v : colour) v = std::abs(v);
    }
    encode(info, colour, texels.data() + i * info.bytes);
  }
  return texels;
}

const char* position_of(Shape shape) {
  switch (shape) {
    case Shape::k1D:
    case Shape::kBuffer:
      return "int(p.x)";
    case Shape::k2D:
      return "ivec2(p.xy)";
    default:
      return "ivec3(p)";
  }
}

// Loads every texel as numbers into a buffer, and stores into a second image the components reversed.
void run_load_store(Device& device, Shape shape, const StorageFormat& f) {
  const FormatInfo& info = info_of(f.format);
  // Those that need no feature ("Features", shaderStorageImageExtendedFormats).
  static constexpr VkFormat kBasic[] = {VK_FORMAT_R32G32B32A32_SFLOAT,
                                        VK_FORMAT_R16G16B16A16_SFLOAT,
                                        VK_FORMAT_R32_SFLOAT,
                                        VK_FORMAT_R8G8B8A8_UNORM,
                                        VK_FORMAT_R8G8B8A8_SNORM,
                                        VK_FORMAT_R32G32B32A32_SINT,
                                        VK_FORMAT_R16G16B16A16_SINT,
                                        VK_FORMAT_R8G8B8A8_SINT,
                                        VK_FORMAT_R32_SINT,
                                        VK_FORMAT_R32G32B32A32_UINT,
                                        VK_FORMAT_R16G16B16A16_UINT,
                                        VK_FORMAT_R8G8B8A8_UINT,
                                        VK_FORMAT_R32_UINT};
  require(std::ranges::find(kBasic, f.format) != std::end(kBasic) || device.caps().features.shaderStorageImageExtendedFormats,
          "shaderStorageImageExtendedFormats");
  Random random(f.qualifier);
  const ImageDesc desc = desc_of(shape, f.format);
  const size_t count = shape == Shape::kBuffer
                           ? kWidth
                           : size_t{desc.extent.width} * desc.extent.height * std::max(desc.extent.depth, desc.layers);
  const std::vector<std::byte> texels = random_texels(info, count, random);
  const Storage from = create_storage(device, shape, info, texels, 0);
  const Storage to = create_storage(device, shape, info, std::vector<std::byte>(texels.size()), 1);
  const Buffer loaded = create_buffer(device, count * 16);
  Resources resources;
  resources.descriptors = {from.descriptor, to.descriptor, storage_buffer(2, loaded)};
  const char* name = "Buffer";
  for (const auto& [s, n] : kShapes) {
    if (s == shape) name = n;
  }
  const char* bits = info.is_integer() ? "uvec4(v)" : "floatBitsToUint(v)";
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        fmt::format("layout(local_size_x = 1) in;\nlayout(binding = 0, {0}) readonly uniform {1}image{2} a;\n"
                                    "layout(binding = 1, {0}) writeonly uniform {1}image{2} b;\n"
                                    "layout(binding = 2, std430) buffer B {{ uvec4 loaded[]; }};\n"
                                    "void main() {{ uvec3 p = gl_GlobalInvocationID; {1}vec4 v = imageLoad(a, {3});\n"
                                    "loaded[(p.z * gl_NumWorkGroups.y + p.y) * gl_NumWorkGroups.x + p.x] = {4};\n"
                                    "imageStore(b, {3}, v.wzyx); }}",
                                    f.qualifier, prefix_of(info), name, position_of(shape), bits)),
           resources, {from.size.width, from.size.height, from.size.depth});
  const std::vector<std::byte> stored = read_storage(device, to, info);
  for (size_t i = 0; i < count; ++i) {
    const Colour want = decode(info, texels.data() + i * info.bytes);
    const std::string where = fmt::format("texel {}", i);
    for (size_t c = 0; c < 4; ++c) {
      const uint32_t word = loaded.as<uint32_t>()[i * 4 + c];
      const double got = !info.is_integer() ? std::bit_cast<float>(word)
                         : info.is_signed() ? static_cast<double>(static_cast<int32_t>(word))
                                            : static_cast<double>(word);
      expect(std::abs(got - want[c]) <= 1e-6 * std::abs(want[c]) + 1e-9,
             fmt::format("{}: loaded {} as component {}, not {}", where, got, c, want[c]));
    }
    expect_colour(info, stored.data() + i * info.bytes, {want[3], want[2], want[1], want[0]}, info.is_integer() ? 0 : 1,
                  where + " stored");
  }
}

// A sampled view that picks components, a level and a layer of an image of another format of its class.
struct ViewCase {
  const char* name;
  VkFormat view_format;
  VkComponentMapping swizzle;
  uint32_t level, layer;
};
constexpr VkComponentSwizzle kR = VK_COMPONENT_SWIZZLE_R, kG = VK_COMPONENT_SWIZZLE_G, kB = VK_COMPONENT_SWIZZLE_B,
                             kA = VK_COMPONENT_SWIZZLE_A, k0 = VK_COMPONENT_SWIZZLE_ZERO, k1 = VK_COMPONENT_SWIZZLE_ONE,
                             kI = VK_COMPONENT_SWIZZLE_IDENTITY;
constexpr ViewCase kViews[] = {
    {"identity", VK_FORMAT_R8G8B8A8_UNORM, {kI, kI, kI, kI}, 0, 0},
    {"reversed", VK_FORMAT_R8G8B8A8_UNORM, {kA, kB, kG, kR}, 0, 1},
    {"constants", VK_FORMAT_R8G8B8A8_UNORM, {k1, k0, kR, k1}, 1, 0},
    {"one_everywhere", VK_FORMAT_R8G8B8A8_UNORM, {kG, kG, kG, kG}, 2, 2},
    {"as_srgb", VK_FORMAT_R8G8B8A8_SRGB, {kI, kI, kI, kI}, 1, 1},
    {"as_snorm", VK_FORMAT_R8G8B8A8_SNORM, {kI, kI, kI, kI}, 0, 2},
    {"as_half", VK_FORMAT_R16G16_UNORM, {kI, kI, kI, kI}, 2, 0},
    {"as_packed", VK_FORMAT_A2B10G10R10_UNORM_PACK32, {kI, kI, kI, kI}, 1, 2},
    {"as_bgra_swizzled", VK_FORMAT_B8G8R8A8_UNORM, {kB, kI, kR, k1}, 0, 1},
};

void run_view(Device& device, const ViewCase& c) {
  const FormatInfo& info = info_of(c.view_format);
  require(device.format(c.view_format).optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, "sampling the view's format");
  ImageDesc desc;
  desc.extent = {16, 12, 1};
  desc.levels = 3, desc.layers = 3;
  desc.flags = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
  desc.usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
  desc.view_type = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
  const Image image = create_image(device, desc);
  Random random(c.name);
  std::vector<std::byte> wanted;
  for (uint32_t level = 0; level < 3; ++level) {
    for (uint32_t layer = 0; layer < 3; ++layer) {
      const VkExtent3D size = image.level_extent(level);
      std::vector<std::byte> texels(size_t{size.width} * size.height * 4);
      for (std::byte& b : texels) b = static_cast<std::byte>(random.below(256));
      upload(device, image, texels, level, layer);
      if (level == c.level && layer == c.layer) wanted = texels;
    }
  }
  VkImageViewCreateInfo view_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  view_info.image = image.handle;
  view_info.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view_info.format = c.view_format;
  view_info.components = c.swizzle;
  view_info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, c.level, 1, c.layer, 1};
  const auto view = make<VkImageView, vkDestroyImageView>(device, vkCreateImageView, view_info, "vkCreateImageView");
  const Sampler sampler = create_sampler(device);
  const VkExtent3D size = image.level_extent(c.level);
  const size_t count = size_t{size.width} * size.height;
  const Buffer out = create_buffer(device, count * 16 + 16);
  Resources resources;
  resources.descriptors = {
      {0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, {}, {{sampler, view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}}, {}},
      storage_buffer(1, out)};
  dispatch(
      device,
      compile_glsl(
          VK_SHADER_STAGE_COMPUTE_BIT,
          "layout(local_size_x = 1) in; layout(binding = 0) uniform sampler2D t;\n"
          "layout(binding = 1, std430) buffer B { ivec4 size; vec4 o[]; };\n"
          "void main() { ivec2 p = ivec2(gl_GlobalInvocationID.xy); size = ivec4(textureSize(t, 0), textureQueryLevels(t), 0);\n"
          "o[p.y * textureSize(t, 0).x + p.x] = texelFetch(t, p, 0); }"),
      resources, {size.width, size.height, 1});
  const auto words = out.as<uint32_t>();
  expect(words[0] == size.width && words[1] == size.height && words[2] == 1, "the view's size or count of levels");
  const VkComponentSwizzle swizzles[4] = {c.swizzle.r, c.swizzle.g, c.swizzle.b, c.swizzle.a};
  for (size_t i = 0; i < count; ++i) {
    const Colour texel = decode(info, wanted.data() + i * 4);
    for (size_t k = 0; k < 4; ++k) {
      const VkComponentSwizzle s = swizzles[k];
      const double want = s == k0 ? 0 : s == k1 ? 1 : s == kI ? texel[k] : texel[static_cast<size_t>(s - kR)];
      const float got = out.as<float>()[4 + i * 4 + k];
      const double slack = info.channels[0].numeric == Numeric::kSrgb ? 0.00445 : 1e-6;
      expect(std::abs(got - want) <= slack, fmt::format("texel {}, component {}: {}, not {}", i, k, got, want));
    }
  }
}

// Uniform texel buffers: every format, from an offset.
void run_texel_buffer(Device& device, const FormatInfo& info) {
  require(device.format(info.format).bufferFeatures & VK_FORMAT_FEATURE_UNIFORM_TEXEL_BUFFER_BIT, "uniform texel buffers");
  constexpr uint32_t kCount = 37;
  Random random(info.name);
  const std::vector<std::byte> texels = random_texels(info, kCount, random);
  std::vector<std::byte> content(256);
  content.insert(content.end(), texels.begin(), texels.end());
  const Buffer buffer = create_buffer(device, std::span(content), VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT);
  VkBufferViewCreateInfo view_info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
  view_info.buffer = buffer.handle;
  view_info.format = info.format;
  view_info.offset = 256;
  view_info.range = texels.size();
  const BufferView view = make<VkBufferView, vkDestroyBufferView>(device, vkCreateBufferView, view_info, "vkCreateBufferView");
  const Buffer out = create_buffer(device, (kCount + 1) * 16);
  Resources resources;
  resources.descriptors = {{0, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, {}, {}, {view}}, storage_buffer(1, out)};
  dispatch(device,
           compile_glsl(
               VK_SHADER_STAGE_COMPUTE_BIT,
               fmt::format("layout(local_size_x = 1) in; layout(binding = 0) uniform {}samplerBuffer t;\n"
                           "layout(binding = 1, std430) buffer B {{ uvec4 size; uvec4 o[]; }};\n"
                           "void main() {{ int i = int(gl_GlobalInvocationID.x); size.x = uint(textureSize(t)); o[i] = {}; }}",
                           prefix_of(info), info.is_integer() ? "uvec4(texelFetch(t, i))" : "floatBitsToUint(texelFetch(t, i))")),
           resources, {kCount, 1, 1});
  expect(out.as<uint32_t>()[0] == kCount, fmt::format("textureSize is {}", out.as<uint32_t>()[0]));
  for (uint32_t i = 0; i < kCount; ++i) {
    const Colour want = decode(info, texels.data() + i * info.bytes);
    for (size_t c = 0; c < 4; ++c) {
      const uint32_t word = out.as<uint32_t>()[4 + i * 4 + c];
      const double got = !info.is_integer() ? std::bit_cast<float>(word)
                         : info.is_signed() ? static_cast<double>(static_cast<int32_t>(word))
                                            : static_cast<double>(word);
      const bool srgb =
          std::ranges::any_of(info.channels, [](const Channel& channel) { return channel.numeric == Numeric::kSrgb; });
      const double slack = srgb ? 0.00445 : 1e-6 * std::abs(want[c]) + 1e-9;
      expect(std::abs(got - want[c]) <= slack, fmt::format("texel {}, component {}: {}, not {}", i, c, got, want[c]));
    }
  }
}

}  // namespace

void register_image() {
  for (const auto& [shape, name] : kShapes) {
    for (const StorageFormat& f : storage_formats()) {
      add_case("image.load_store", fmt::format("{}.{}", name, f.qualifier), "16.7 Image Operations: storage",
               [shape = shape, &f](Device& device) { run_load_store(device, shape, f); });
    }
  }
  for (const ViewCase& c : kViews) {
    add_case("image.views", c.name, "12.5 Image Views", [&c](Device& device) { run_view(device, c); });
  }
  for (const FormatInfo& info : colour_formats()) {
    if (info.format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32) continue;  // has no encoder here
    add_case("image.texel_buffer", info.name, "12.2 Buffer Views", [&info](Device& device) { run_texel_buffer(device, info); });
  }
}

}  // namespace pineda::cts
