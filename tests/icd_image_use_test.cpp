// Uses of images that depend on more than a format, through the API: views of blocks as texels, extended usage, views of volumes,
// linear tiling, anisotropy, mirror clamp, level-of-detail clamps, and input that is no sensible coordinate. Their descriptors
// are in icd_image_descriptors_test.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/block_codec.h"
#include "base/format.h"
#include "format_oracle.h"
#include "image_client.h"

namespace pineda::test {
namespace {

constexpr uint32_t kSeed = 20250304, kCount = 64;
constexpr const char* kHead = R"(
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_ARB_sparse_texture_clamp : enable
layout(local_size_x = 64) in;
)";

std::vector<uint8_t> random_bytes(size_t count, std::mt19937& random) {
  std::vector<uint8_t> out(count);
  for (uint8_t& byte : out) byte = static_cast<uint8_t>(random());
  return out;
}

// ---- usage ----

// VK_EXT_separate_stencil_usage: an image can be made when its format has both aspects' uses.
TEST(IcdImageUse, StencilUsageOfItsOwn) {
  Client client;
  constexpr VkFormat kFormat = VK_FORMAT_D32_SFLOAT_S8_UINT;
  const auto query = [&](VkImageUsageFlags usage, VkImageUsageFlags stencil_usage) {
    const VkImageStencilUsageCreateInfo stencil{VK_STRUCTURE_TYPE_IMAGE_STENCIL_USAGE_CREATE_INFO, nullptr, stencil_usage};
    const VkPhysicalDeviceImageFormatInfo2 info{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_FORMAT_INFO_2,
                                                &stencil,
                                                kFormat,
                                                VK_IMAGE_TYPE_2D,
                                                VK_IMAGE_TILING_OPTIMAL,
                                                usage};
    VkImageFormatProperties2 out{VK_STRUCTURE_TYPE_IMAGE_FORMAT_PROPERTIES_2};
    return VK(client, GetPhysicalDeviceImageFormatProperties2)(client.physical, &info, &out);
  };
  EXPECT_EQ(query(VK_IMAGE_USAGE_SAMPLED_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT), VK_SUCCESS);
  EXPECT_EQ(query(VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_USAGE_STORAGE_BIT), VK_ERROR_FORMAT_NOT_SUPPORTED);
  EXPECT_EQ(query(VK_IMAGE_USAGE_STORAGE_BIT, VK_IMAGE_USAGE_SAMPLED_BIT), VK_ERROR_FORMAT_NOT_SUPPORTED);
}

// ---- views ----

// "A view of a block-compressed image may have an uncompressed format of the block's size": its texels are the blocks.
TEST(IcdImageUse, BlocksAreSeenAsTexels) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto out = client.buffer(16 * 16);
  struct Case {
    VkFormat blocks, texels;
    uint32_t block_w, block_h, bytes;
  };
  for (const Case c : {Case{VK_FORMAT_BC7_SRGB_BLOCK, VK_FORMAT_R32G32B32A32_UINT, 4, 4, 16},
                       {VK_FORMAT_BC1_RGB_UNORM_BLOCK, VK_FORMAT_R32G32_UINT, 4, 4, 8},
                       {VK_FORMAT_ETC2_R8G8B8A8_UNORM_BLOCK, VK_FORMAT_R32G32B32A32_UINT, 4, 4, 16},
                       {VK_FORMAT_ASTC_6x5_UNORM_BLOCK, VK_FORMAT_R32G32B32A32_UINT, 6, 5, 16}}) {
    // Level 1 of 2: 4x4 blocks, the last column and row of them cut off.
    const VkExtent3D level{4 * c.block_w - 1, 4 * c.block_h - 1, 1};
    const VkImage image =
        client.make({.format = c.blocks,
                     .extent = {2 * level.width, 2 * level.height, 1},
                     .levels = 2,
                     .flags = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_BLOCK_TEXEL_VIEW_COMPATIBLE_BIT});
    const std::vector<uint8_t> data = random_bytes(size_t{16} * c.bytes, random);
    client.upload(image, data, color_layers(1), level);
    const VkImageView view = client.view(image, c.texels, VK_IMAGE_VIEW_TYPE_2D, {VK_IMAGE_ASPECT_COLOR_BIT, 1, 1, 0, 1});
    client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform usampler2D t;
layout(std430, binding = 1) writeonly buffer O { uvec4 o[]; };
void main() { uint i = gl_GlobalInvocationID.x; if (i < 16) o[i] = texelFetch(t, ivec2(i % 4, i / 4), 0) + 0 * textureSize(t, 0).x; })",
                    {{sampled_image(view, client.nearest_sampler())}, {storage_buffer(out)}}, 1);
    for (uint32_t i = 0; i < 16; ++i) {
      ASSERT_EQ(std::memcmp(out.data + 16 * i, &data[size_t{i} * c.bytes], c.bytes), 0) << c.blocks << " block " << i;
    }
  }
}

// An sRGB image that is stored to through a view of UNORM, which sRGB itself does not allow.
TEST(IcdImageUse, ExtendedUsage) {
  ImageClient client;
  VkImageFormatProperties limits;
  constexpr VkImageCreateFlags kMutable = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
  constexpr VkImageCreateFlags kExtended = kMutable | VK_IMAGE_CREATE_EXTENDED_USAGE_BIT;
  const auto query = [&](VkFormat format, VkImageUsageFlags usage, VkImageCreateFlags flags) {
    return VK(client, GetPhysicalDeviceImageFormatProperties)(client.physical, format, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL,
                                                              usage, flags, &limits);
  };
  EXPECT_EQ(query(VK_FORMAT_R8G8B8A8_SRGB, VK_IMAGE_USAGE_STORAGE_BIT, kMutable), VK_ERROR_FORMAT_NOT_SUPPORTED);
  EXPECT_EQ(query(VK_FORMAT_R8G8B8A8_SRGB, VK_IMAGE_USAGE_STORAGE_BIT, kExtended), VK_SUCCESS);
  EXPECT_EQ(query(VK_FORMAT_BC7_UNORM_BLOCK, VK_IMAGE_USAGE_STORAGE_BIT, kExtended), VK_ERROR_FORMAT_NOT_SUPPORTED);
  const VkImage image = client.make({.format = VK_FORMAT_R8G8B8A8_SRGB,
                                     .extent = {8, 8, 1},
                                     .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                                     .flags = kExtended});
  client.dispatch(std::string(kHead) + R"(layout(binding = 0) writeonly uniform image2D t;
void main() { int i = int(gl_GlobalInvocationID.x); imageStore(t, ivec2(i % 8, i / 8), vec4(vec3(i * 4) / 255.0, i / 255.0)); })",
                  {{storage_image(client.view(image, VK_FORMAT_R8G8B8A8_UNORM))}}, 1);
  const VkImageViewUsageCreateInfo sampled{VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO, nullptr, VK_IMAGE_USAGE_SAMPLED_BIT};
  const VkImageView encoded = client.view(image, VK_FORMAT_R8G8B8A8_SRGB, VK_IMAGE_VIEW_TYPE_2D, ImageClient::all(), &sampled);
  const auto out = client.buffer(kCount * 16);
  client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform sampler2D t;
layout(std430, binding = 1) writeonly buffer O { vec4 o[]; };
void main() { int i = int(gl_GlobalInvocationID.x); o[i] = texelFetch(t, ivec2(i % 8, i / 8), 0); })",
                  {{sampled_image(encoded, client.nearest_sampler())}, {storage_buffer(out)}}, 1);
  for (uint32_t i = 0; i < kCount; ++i) {
    ASSERT_NEAR(out.as<float>()[4 * i], cts::srgb_to_linear(4 * i / 255.0), 1e-6);
    ASSERT_NEAR(out.as<float>()[4 * i + 3], i / 255.0, 1e-7);
  }
}

// A slice of a level of a volume as a 2D image, stored to and sampled (VK_EXT_image_2d_view_of_3d).
TEST(IcdImageUse, SlicesAreImages) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const VkImage volume = client.make({.format = VK_FORMAT_R32_UINT,
                                      .extent = {16, 8, 16},
                                      .type = VK_IMAGE_TYPE_3D,
                                      .levels = 2,
                                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT,
                                      .flags = VK_IMAGE_CREATE_2D_VIEW_COMPATIBLE_BIT_EXT});
  std::vector<uint8_t> data = random_bytes(8 * 4 * 8 * 4, random);  // level 1: 8x4x8
  client.upload(volume, data, color_layers(1), {8, 4, 8});
  const auto slice = [&](uint32_t z) {
    return client.view(volume, VK_FORMAT_R32_UINT, VK_IMAGE_VIEW_TYPE_2D, {VK_IMAGE_ASPECT_COLOR_BIT, 1, 1, z, 1});
  };
  const auto out = client.buffer(kCount * 16);
  client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform usampler2D from;
layout(binding = 1, r32ui) uniform uimage2D to;
layout(std430, binding = 2) writeonly buffer O { uvec4 o[]; };
void main() { int i = int(gl_GlobalInvocationID.x); ivec2 p = ivec2(i % 8, i / 8);
  o[i] = uvec4(texelFetch(from, p, 0).x, textureSize(from, 0), imageSize(to).y);
  imageStore(to, p, uvec4(7000 + i)); })",
                  {{sampled_image(slice(3), client.nearest_sampler())}, {storage_image(slice(6))}, {storage_buffer(out)}}, 1);
  const std::vector<uint8_t> got = client.download(volume, data.size(), color_layers(1), {8, 4, 8});
  for (uint32_t i = 0; i < 32; ++i) {
    uint32_t word;
    std::memcpy(&word, &data[(3 * 32 + i) * 4], 4);
    ASSERT_EQ(out.as<uint32_t>()[4 * i], word);
    ASSERT_EQ(out.as<uint32_t>()[4 * i + 1], 8u);
    ASSERT_EQ(out.as<uint32_t>()[4 * i + 2], 4u);
    ASSERT_EQ(out.as<uint32_t>()[4 * i + 3], 4u);
    word = 7000 + i;
    std::memcpy(&data[(6 * 32 + i) * 4], &word, 4);
  }
  ASSERT_EQ(got, data);  // rows 4 to 7 of the shader's grid were outside and stored nothing
}

// A volume of blocks, a part of whose slices is written after the others.
TEST(IcdImageUse, VolumesOfBlocks) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const FormatInfo& format = *find_format(VK_FORMAT_BC3_UNORM_BLOCK);
  const cts::FormatInfo& decoded = cts::info_of(format.decoded);
  const VkImage volume = client.make({.format = format.format, .extent = {8, 4, 4}, .type = VK_IMAGE_TYPE_3D});
  std::vector<uint8_t> data = random_bytes(2 * 16 * 4, random);  // two blocks a slice
  client.upload(volume, data, color_layers(), {8, 4, 4});
  const std::vector<uint8_t> part = random_bytes(2 * 16, random);  // block 1 of slices 1 and 2
  const auto staging = client.buffer(part.size());
  std::memcpy(staging.data, part.data(), part.size());
  client.run([&](VkCommandBuffer cb) {
    const VkBufferImageCopy region{0, 0, 0, color_layers(), {4, 0, 1}, {4, 4, 2}};
    VK(client, CmdCopyBufferToImage)(cb, staging.handle, volume, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
  });
  for (uint32_t i = 0; i < 2; ++i) std::memcpy(&data[((1 + i) * 2 + 1) * 16], &part[size_t{i} * 16], 16);
  ASSERT_EQ(client.download(volume, data.size(), color_layers(), {8, 4, 4}), data);
  const auto out = client.buffer(128 * 16);
  const VkImageView view = client.view(volume, format.format, VK_IMAGE_VIEW_TYPE_3D, ImageClient::all());
  client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform sampler3D t;
layout(std430, binding = 1) writeonly buffer O { vec4 o[]; };
void main() { int i = int(gl_GlobalInvocationID.x); o[i] = texelFetch(t, ivec3(i % 8, i / 8 % 4, i / 32), 0); })",
                  {{sampled_image(view, client.nearest_sampler())}, {storage_buffer(out)}}, 2);
  for (uint32_t i = 0; i < 128; ++i) {
    const uint32_t x = i % 8, y = i / 8 % 4, z = i / 32;
    uint8_t block[kMaxBlockBytes];
    block_decoder(format)(format, &data[(z * 2 + x / 4) * size_t{16}], block);
    const cts::Colour want = cts::decode(decoded, reinterpret_cast<const std::byte*>(block + (y * 4 + x % 4) * decoded.bytes));
    for (uint32_t c = 0; c < 4; ++c) ASSERT_NEAR(out.as<float>()[4 * i + c], want[c], 1e-7) << i;
  }
}

// Two slices of level 1 of a volume, each drawn to through a view of its own; the others stay.
TEST(IcdImageUse, SlicesAreDrawnTo) {
  ImageClient client;
  const VkImage volume = client.make({.format = VK_FORMAT_R32_UINT,
                                      .extent = {16, 8, 8},
                                      .type = VK_IMAGE_TYPE_3D,
                                      .levels = 2,
                                      .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                      .flags = VK_IMAGE_CREATE_2D_ARRAY_COMPATIBLE_BIT});
  for (const uint32_t slice : {1u, 3u}) {
    client.draw(
        {.fragment = R"(layout(location = 0) out uint o; layout(push_constant) uniform P { uint slice; };
void main() { o = slice * 100 + uint(gl_FragCoord.y) * 8 + uint(gl_FragCoord.x); })",
         .push = {slice},
         .color = client.view(volume, VK_FORMAT_R32_UINT, VK_IMAGE_VIEW_TYPE_2D, {VK_IMAGE_ASPECT_COLOR_BIT, 1, 1, slice, 1}),
         .color_format = VK_FORMAT_R32_UINT,
         .extent = {8, 4}});
  }
  const std::vector<uint8_t> got = client.download(volume, 8 * 4 * 4 * 4, color_layers(1), {8, 4, 4});
  for (uint32_t i = 0; i < 128; ++i) {
    uint32_t word;
    std::memcpy(&word, &got[size_t{i} * 4], 4);
    const uint32_t slice = i / 32;
    ASSERT_EQ(word, slice % 2 ? slice * 100 + i % 32 : 0) << i;
  }
}

// Every level and layer of an image of linear tiling, written by the host where vkGetImageSubresourceLayout says, for the texel
// sizes there are; and slices of a volume.
TEST(IcdImageUse, LinearTilingIsWhereItSays) {
  ImageClient client;
  std::mt19937 random(kSeed);
  for (const VkFormat format : {VK_FORMAT_R8_UNORM, VK_FORMAT_R5G6B5_UNORM_PACK16, VK_FORMAT_R8G8B8A8_SRGB,
                                VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_UINT}) {
    const uint32_t bytes = texel_bytes(format);
    for (const VkImageType type : {VK_IMAGE_TYPE_1D, VK_IMAGE_TYPE_2D, VK_IMAGE_TYPE_3D}) {
      const VkExtent3D extent{13, type == VK_IMAGE_TYPE_1D ? 1u : 7u, type == VK_IMAGE_TYPE_3D ? 5u : 1u};
      const uint32_t layers = type == VK_IMAGE_TYPE_3D ? 1 : 2, levels = 3;
      uint8_t* mapped = nullptr;
      const VkImage image = client.make({.format = format,
                                         .extent = extent,
                                         .type = type,
                                         .levels = levels,
                                         .layers = layers,
                                         .tiling = VK_IMAGE_TILING_LINEAR},
                                        &mapped);
      for (uint32_t level = 0; level < levels; ++level) {
        const VkExtent3D size{std::max(extent.width >> level, 1u), std::max(extent.height >> level, 1u),
                              std::max(extent.depth >> level, 1u)};
        const size_t row = size_t{size.width} * bytes;
        const std::vector<uint8_t> data = random_bytes(row * size.height * size.depth * layers, random);
        for (uint32_t layer = 0; layer < layers; ++layer) {
          const VkImageSubresource subresource{VK_IMAGE_ASPECT_COLOR_BIT, level, layer};
          VkSubresourceLayout at;
          VK(client, GetImageSubresourceLayout)(client.device, image, &subresource, &at);
          for (uint32_t z = 0; z < size.depth; ++z) {
            for (uint32_t y = 0; y < size.height; ++y) {
              std::memcpy(mapped + at.offset + z * at.depthPitch + y * at.rowPitch,
                          &data[((size_t{layer} * size.depth + z) * size.height + y) * row], row);
            }
          }
        }
        ASSERT_EQ(client.download(image, data.size(), color_layers(level, 0, layers), size), data)
            << format << " level " << level;
      }
    }
  }
}

// ---- sampling ----

// A texture whose level n is filled with the number n, R32_SFLOAT.
VkImageView levels_texture(ImageClient& client, uint32_t side, uint32_t levels) {
  const VkImage image = client.make({.format = VK_FORMAT_R32_SFLOAT, .extent = {side, side, 1}, .levels = levels});
  client.run([&](VkCommandBuffer cb) {
    for (uint32_t i = 0; i < levels; ++i) {
      const VkClearColorValue value{{static_cast<float>(i)}};
      const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, i, 1, 0, 1};
      VK(client, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &value, 1, &range);
    }
  });
  return client.view(image, VK_FORMAT_R32_SFLOAT, VK_IMAGE_VIEW_TYPE_2D, ImageClient::all());
}

VkSamplerCreateInfo trilinear() {
  VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  info.magFilter = info.minFilter = VK_FILTER_LINEAR;
  info.mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
  info.maxLod = VK_LOD_CLAMP_NONE;
  return info;
}

// Sixteen gradients along x, each twice as long along x as the one before, one texel along y: the level is that of the longer
// axis, less log2 of the anisotropy ("Scale Factor Operation": N = min(ceil(eta), max), lambda_base = log2(rho_max / N)).
TEST(IcdImageUse, AnisotropyChoosesTheLevelOfTheShorterAxis) {
  ImageClient client;
  const VkImageView view = levels_texture(client, 1024, 11);
  const auto out = client.buffer(kCount * 4);
  for (const float most : {1.0f, 2.0f, 4.0f, 16.0f}) {
    VkSamplerCreateInfo info = trilinear();
    info.anisotropyEnable = VK_TRUE;
    info.maxAnisotropy = most;
    client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform sampler2D t;
layout(std430, binding = 1) writeonly buffer O { float o[]; };
void main() { uint i = gl_GlobalInvocationID.x; float along = exp2(float(i) / 8.0);
  o[i] = textureGrad(t, vec2(0.25, 0.75), vec2(along / 1024, 0), vec2(0, 1.0 / 1024)).x; })",
                    {{sampled_image(view, client.sampler(info))}, {storage_buffer(out)}}, 1);
    for (uint32_t i = 0; i < kCount; ++i) {
      const double ratio = std::exp2(i / 8.0), probes = std::min<double>(std::ceil(ratio - 1e-6), most);
      // The fraction between two levels has 8 bits, and the logarithm an error of 2^-13.
      ASSERT_NEAR(out.as<float>()[i], std::clamp(std::log2(ratio / probes), 0.0, 10.0), 1.0 / 256 + 0x1p-12)
          << "ratio " << ratio << ", at most " << most;
    }
  }
}

// "1 - |1 - u|"-like mirroring once around zero, then the edge.
TEST(IcdImageUse, MirrorClampsToTheEdge) {
  ImageClient client;
  const VkImage image = client.make({.format = VK_FORMAT_R32_SFLOAT, .extent = {8, 1, 1}});
  std::vector<uint8_t> data(8 * 4);
  for (uint32_t i = 0; i < 8; ++i) {
    const auto value = static_cast<float>(i);
    std::memcpy(&data[size_t{i} * 4], &value, 4);
  }
  client.upload(image, data, color_layers(), {8, 1, 1});
  const auto out = client.buffer(kCount * 4);
  for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
    VkSamplerCreateInfo info{.magFilter = filter, .minFilter = filter};
    info.addressModeU = info.addressModeV = VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE;
    client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform sampler2D t;
layout(std430, binding = 1) writeonly buffer O { float o[]; };
void main() { uint i = gl_GlobalInvocationID.x; o[i] = textureLod(t, vec2((float(i) - 32) / 16 + 1.0 / 64, 0.5), 0).x; })",
                    {{sampled_image(client.view(image, VK_FORMAT_R32_SFLOAT), client.sampler(info))}, {storage_buffer(out)}}, 1);
    const auto texel = [](int n) { return std::min(n < 0 ? -1 - n : n, 7); };
    for (int i = 0; i < 64; ++i) {
      const double u = ((i - 32) / 16.0 + 1.0 / 64) * 8;
      const int lower = static_cast<int>(std::floor(u - 0.5));
      const double weight = u - 0.5 - lower;
      const double want = filter == VK_FILTER_NEAREST ? texel(static_cast<int>(std::floor(u)))
                                                      : texel(lower) * (1 - weight) + texel(lower + 1) * weight;
      ASSERT_NEAR(out.as<float>()[i], want, 1e-6) << i;
    }
  }
}

// Levels of detail that are far out, infinite or no numbers; the sampler's clamps; the shader's own minimum.
TEST(IcdImageUse, LevelsOfDetailAreClamped) {
  ImageClient client;
  constexpr uint32_t kLevels = 5;
  const VkImageView view = levels_texture(client, 16, kLevels);
  constexpr float kInf = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();
  const float lods[] = {-1e30f, -1, 0, 0.5f, 1.25f, 3, 4, 5, 100, 1e30f, kInf, -kInf, kNan};
  const auto in = client.buffer(kCount * 4), out = client.buffer(kCount * 4);
  std::copy(std::begin(lods), std::end(lods), in.as<float>());
  struct Clamp {
    float min, max, bias;
  };
  for (const Clamp clamp : {Clamp{0, VK_LOD_CLAMP_NONE, 0}, {1.5f, 2.75f, 0}, {2, 2, 0}, {0, 3, 0.5f}, {0, 3, -1}}) {
    VkSamplerCreateInfo info = trilinear();
    info.minLod = clamp.min, info.maxLod = clamp.max, info.mipLodBias = clamp.bias;
    client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform sampler2D t;
layout(std430, binding = 1) readonly buffer L { float lod[]; };
layout(std430, binding = 2) writeonly buffer O { float o[]; };
void main() { uint i = gl_GlobalInvocationID.x; o[i] = textureLod(t, vec2(0.5), lod[i]).x; })",
                    {{sampled_image(view, client.sampler(info))}, {storage_buffer(in)}, {storage_buffer(out)}}, 1);
    for (uint32_t i = 0; i < std::size(lods); ++i) {
      // "LOD Operation": lambda' + bias, clamped by the sampler, then to the levels there are. NaN: the minimum.
      const float lambda = std::isnan(lods[i]) ? clamp.min : std::clamp(lods[i] + clamp.bias, clamp.min, clamp.max);
      ASSERT_NEAR(out.as<float>()[i], std::clamp(lambda, 0.0f, kLevels - 1.0f), 1.0 / 256) << lods[i];
    }
  }
  // sparse_texture_clamp's lodClamp is SPIR-V's MinLod.
  client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform sampler2D t;
layout(std430, binding = 1) readonly buffer L { float lod[]; };
layout(std430, binding = 2) writeonly buffer O { float o[]; };
void main() { uint i = gl_GlobalInvocationID.x;
  o[i] = textureGradClampARB(t, vec2(0.5), vec2(2.0 / 16, 0), vec2(0, 2.0 / 16), lod[i]).x; })",
                  {{sampled_image(view, client.sampler(trilinear()))}, {storage_buffer(in)}, {storage_buffer(out)}}, 1);
  for (uint32_t i = 0; i + 1 < std::size(lods); ++i) {
    ASSERT_NEAR(out.as<float>()[i], std::clamp(std::max(lods[i], 1.0f), 0.0f, kLevels - 1.0f), 1.0 / 256 + 0x1p-12) << lods[i];
  }
}

// Coordinates that are infinite, no numbers or huge: a texel of the texture or the border, never anything else.
TEST(IcdImageUse, OddCoordinatesGiveTexels) {
  ImageClient client;
  constexpr float kInf = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();
  const float odd[] = {kNan, kInf, -kInf, 3e38f, -3e38f, 1e-45f, -0.0f, 1e9f};
  const auto in = client.buffer(kCount * 16), out = client.buffer(kCount * 16);
  for (uint32_t i = 0; i < kCount; ++i) {
    in.as<float>()[4 * i] = odd[i % 8];
    in.as<float>()[4 * i + 1] = odd[i / 8];
    in.as<float>()[4 * i + 2] = odd[(i + i / 8) % 8];
    in.as<float>()[4 * i + 3] = odd[(3 * i) % 8];
  }
  const VkImage flat = client.make({.format = VK_FORMAT_R32_SFLOAT, .extent = {7, 5, 1}, .layers = 3});
  const VkImage cube = client.make(
      {.format = VK_FORMAT_R32_SFLOAT, .extent = {4, 4, 1}, .layers = 6, .flags = VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT});
  const VkImage volume = client.make({.format = VK_FORMAT_R32_SFLOAT, .extent = {5, 3, 4}, .type = VK_IMAGE_TYPE_3D});
  client.run([&](VkCommandBuffer cb) {  // every texel is 5, the border 0: whatever is between is a mixture
    const VkClearColorValue five{{5}};
    const VkImageSubresourceRange all = ImageClient::all();
    for (const VkImage image : {flat, cube, volume})
      VK(client, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &five, 1, &all);
  });
  for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
    for (const VkSamplerAddressMode mode :
         {VK_SAMPLER_ADDRESS_MODE_REPEAT, VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
          VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER, VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE}) {
      VkSamplerCreateInfo info{
          .magFilter = filter, .minFilter = filter, .addressModeU = mode, .addressModeV = mode, .addressModeW = mode};
      const VkSampler sampler = client.sampler(info);
      client.dispatch(
          std::string(kHead) + R"(layout(binding = 0) uniform sampler2DArray a;
layout(binding = 1) uniform samplerCube c;
layout(binding = 2) uniform sampler3D v;
layout(std430, binding = 3) readonly buffer P { vec4 p[]; };
layout(std430, binding = 4) writeonly buffer O { vec4 o[]; };
void main() { uint i = gl_GlobalInvocationID.x;
  o[i] = vec4(textureLod(a, p[i].xyz, p[i].w).x, textureLod(c, p[i].xyz, 0).x, textureGrad(v, p[i].xyz, p[i].yzw, p[i].zwx).x,
              textureGather(a, p[i].wzy).x); })",
          {{sampled_image(client.view(flat, VK_FORMAT_R32_SFLOAT, VK_IMAGE_VIEW_TYPE_2D_ARRAY, ImageClient::all()), sampler)},
           {sampled_image(client.view(cube, VK_FORMAT_R32_SFLOAT, VK_IMAGE_VIEW_TYPE_CUBE, ImageClient::all()), sampler)},
           {sampled_image(client.view(volume, VK_FORMAT_R32_SFLOAT, VK_IMAGE_VIEW_TYPE_3D, ImageClient::all()), sampler)},
           {storage_buffer(in)},
           {storage_buffer(out)}},
          1);
      const bool border = mode == VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER;
      for (uint32_t i = 0; i < 4 * kCount; ++i) {
        const float v = out.as<float>()[i];
        // Weights sum to one within their roundings.
        const bool texel = std::abs(v - 5) < 1e-5f, mixed = border && v >= -1e-5f && v <= 5 + 1e-5f;
        ASSERT_TRUE(texel || mixed) << v << " for mode " << mode << " lane " << i / 4 << " call " << i % 4;
      }
    }
  }
}

// Views whose range would leave the resource; texel buffers that are read and written past their end.
TEST(IcdImageUse, BadInputViewsEndWithWhatTheyShow) {
  breaks_on_purpose({"VUID-VkBufferViewCreateInfo-offset-00931", "VUID-VkImageSubresourceRange-levelCount-01720",
                     "VUID-VkImageViewCreateInfo-image-06724", "VUID-VkImageViewCreateInfo-subresourceRange-01478",
                     "VUID-VkImageViewCreateInfo-subresourceRange-01718", "VUID-VkImageViewCreateInfo-subresourceRange-06725"});
  ImageClient client;
  const VkImage image = client.make({.format = VK_FORMAT_R8G8B8A8_UNORM, .extent = {8, 8, 1}, .levels = 3, .layers = 4});
  for (const VkImageSubresourceRange range : {VkImageSubresourceRange{VK_IMAGE_ASPECT_COLOR_BIT, 3, 1, 0, 1},
                                              {VK_IMAGE_ASPECT_COLOR_BIT, 1, 3, 0, 1},
                                              {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 4, 1},
                                              {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 2, 3},
                                              {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 0, 1},
                                              {VK_IMAGE_ASPECT_COLOR_BIT, ~0u, ~0u, ~0u, ~0u}}) {
    const VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                     nullptr,
                                     0,
                                     image,
                                     VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                     VK_FORMAT_R8G8B8A8_UNORM,
                                     {},
                                     range};
    VkImageView view = VK_NULL_HANDLE;
    EXPECT_NE(VK(client, CreateImageView)(client.device, &info, nullptr, &view), VK_SUCCESS) << range.baseMipLevel;
  }
  const auto words = client.buffer(256), out = client.buffer(kCount * 4);
  for (uint32_t i = 0; i < 64; ++i) words.as<uint32_t>()[i] = 100 + i;
  // A range beyond the buffer's end is cut there; indices beyond the view read zero and store nothing.
  const Resource read = client.texel_buffer(VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, words, VK_FORMAT_R32_UINT, 128, 1024);
  const Resource write = client.texel_buffer(VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, words, VK_FORMAT_R32_UINT, 0, 32);
  client.dispatch(std::string(kHead) + R"(layout(binding = 0) uniform usamplerBuffer r;
layout(binding = 1, r32ui) uniform uimageBuffer w;
layout(std430, binding = 2) writeonly buffer O { uint o[]; };
void main() { int i = int(gl_GlobalInvocationID.x); o[i] = texelFetch(r, i).x + texelFetch(r, -1 - i).x; imageStore(w, i, uvec4(7)); })",
                  {{read}, {write}, {storage_buffer(out)}}, 1);
  for (uint32_t i = 0; i < 64; ++i) {
    ASSERT_EQ(out.as<uint32_t>()[i], i < 32 ? 132 + i : 0u) << i;
    ASSERT_EQ(words.as<uint32_t>()[i], i < 8 ? 7 : 100 + i) << i;
  }
}

}  // namespace
}  // namespace pineda::test
