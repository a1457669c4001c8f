// Every format that shaders can read or write other than by texelFetch of a 2D image, through the API: vertex attributes, texel
// buffers, storage images of every dimension and with every declared format, linear filtering. Expected values:
// cts-subset/reference.
#include <gtest/gtest.h>

#include "base/block_codec.h"
#include "base/format.h"
#include "cts-subset/reference/texture.h"
#include "format_oracle.h"
#include "image_client.h"

namespace pineda::test {
namespace {

constexpr uint32_t kSeed = 20250302, kCount = 64;
constexpr double kStoreSlack = 0x1p-23;  // scaling a value to codes rounds once

std::vector<const cts::FormatInfo*> buffer_formats(ImageClient& client, VkFormatFeatureFlags feature) {
  std::vector<const cts::FormatInfo*> out;
  for (const cts::FormatInfo& format : cts::colour_formats()) {
    if (client.format_properties(format.format).bufferFeatures & feature) out.push_back(&format);
  }
  return out;
}

// Four words an element, against the texels in memory.
void expect_read(const cts::FormatInfo& format, const uint8_t* texels, const uint32_t* words, uint32_t count,
                 const std::string& what) {
  for (uint32_t i = 0; i < count; ++i) {
    const cts::Colour want = cts::decode(format, reinterpret_cast<const std::byte*>(texels + size_t{i} * format.bytes));
    for (uint32_t c = 0; c < 4; ++c) {
      ASSERT_TRUE(reads(format, words[4 * i + c], want[c])) << what << " " << format.name << " element " << i << " channel " << c
                                                            << ": " << from_word(format, words[4 * i + c]) << " for " << want[c];
    }
  }
}

std::vector<uint8_t> random_bytes(size_t count, std::mt19937& random) {
  std::vector<uint8_t> out(count);
  for (uint8_t& byte : out) byte = static_cast<uint8_t>(random());
  return out;
}

TEST(IcdFormatShader, EveryVertexFormat) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto formats = buffer_formats(client, VK_FORMAT_FEATURE_VERTEX_BUFFER_BIT);
  EXPECT_GE(formats.size(), 95u);
  const auto out = client.buffer(kCount * 16);
  for (const cts::FormatInfo* format : formats) {
    const auto vertices = client.buffer(size_t{kCount} * format->bytes);
    const std::vector<uint8_t> data = random_bytes(size_t{kCount} * format->bytes, random);
    std::memcpy(vertices.data, data.data(), data.size());
    const std::string prefix = glsl_prefix(*format);
    client.draw({.vertex = "layout(location = 0) in " + prefix + "vec4 a;\nlayout(std430, binding = 0) writeonly buffer O { " +
                           prefix +
                           "vec4 o[]; };\nvoid main() { o[gl_VertexIndex] = a; gl_Position = vec4(0); gl_PointSize = 1; }",
                 .bindings = {{storage_buffer(out)}},
                 .extent = {1, 1},
                 .attribute = format->format,
                 .vertices = vertices.handle,
                 .stride_bytes = format->bytes,
                 .vertex_count = kCount,
                 .points = true});
    expect_read(*format, data.data(), out.as<uint32_t>(), kCount, "vertex");
    if (HasFatalFailure()) return;
  }
}

TEST(IcdFormatShader, EveryTexelBufferFormat) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto out = client.buffer(kCount * 16), values = client.buffer(kCount * 16);
  const auto uniform = buffer_formats(client, VK_FORMAT_FEATURE_UNIFORM_TEXEL_BUFFER_BIT);
  EXPECT_GE(uniform.size(), 60u);
  const auto shader = [](const std::string& declarations, const std::string& body) {
    return "#extension GL_EXT_shader_image_load_formatted : require\nlayout(local_size_x = 64) in;\n" + declarations +
           "void main() { int i = int(gl_GlobalInvocationID.x); " + body + " }";
  };
  for (const cts::FormatInfo* format : uniform) {
    const auto texels = client.uniform_texels(size_t{kCount} * format->bytes);
    const std::vector<uint8_t> data = random_bytes(size_t{kCount} * format->bytes, random);
    std::memcpy(texels.data, data.data(), data.size());
    const std::string prefix = glsl_prefix(*format);
    client.dispatch(
        shader("layout(binding = 0) uniform " + prefix + "samplerBuffer t;\nlayout(std430, binding = 1) buffer O { " + prefix +
                   "vec4 o[]; };\n",
               "o[i] = texelFetch(t, i);"),
        {{client.texel_buffer(VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, texels, format->format)}, {storage_buffer(out)}}, 1);
    expect_read(*format, data.data(), out.as<uint32_t>(), kCount, "uniform texel buffer");
    if (HasFatalFailure()) return;
  }
  const auto storage = buffer_formats(client, VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_BIT);
  EXPECT_GE(storage.size(), 40u);
  for (const cts::FormatInfo* format : storage) {
    const auto texels = client.buffer(size_t{kCount} * format->bytes);
    std::vector<cts::Colour> colours(kCount);
    for (uint32_t i = 0; i < kCount; ++i) {
      for (uint32_t c = 0; c < 4; ++c) {
        colours[i][c] = random_channel(*format, "rgba"[c], random);
        values.as<uint32_t>()[4 * i + c] = shader_word(*format, colours[i][c]);
      }
    }
    const std::string prefix = glsl_prefix(*format);
    const Resource view = client.texel_buffer(VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, texels, format->format);
    client.dispatch(shader("layout(binding = 0) writeonly uniform " + prefix +
                               "imageBuffer t;\nlayout(std430, binding = 1) buffer V { " + prefix + "vec4 v[]; };\n",
                           "imageStore(t, i, v[i]);"),
                    {{view}, {storage_buffer(values)}}, 1);
    for (uint32_t i = 0; i < kCount; ++i) {
      ASSERT_EQ(differs(*format, texels.data + size_t{i} * format->bytes, colours[i], kStoreSlack), "") << "element " << i;
    }
    client.dispatch(shader("layout(binding = 0) readonly uniform " + prefix +
                               "imageBuffer t;\nlayout(std430, binding = 1) buffer O { " + prefix + "vec4 o[]; };\n",
                           "o[i] = imageLoad(t, i);"),
                    {{view}, {storage_buffer(out)}}, 1);
    expect_read(*format, texels.data, out.as<uint32_t>(), kCount, "storage texel buffer");
    if (HasFatalFailure()) return;
  }
}

// ---- storage images ----

struct Dimension {
  const char* glsl;   // image1D ...
  const char* place;  // of element i
  VkImageType type;
  VkImageViewType view;
  VkExtent3D extent;
  uint32_t layers;
};

// Sixty-four texels each, counted through rows, slices and layers.
constexpr Dimension kDimensions[] = {
    {"image1D", "i", VK_IMAGE_TYPE_1D, VK_IMAGE_VIEW_TYPE_1D, {64, 1, 1}, 1},
    {"image1DArray", "ivec2(i % 16, i / 16)", VK_IMAGE_TYPE_1D, VK_IMAGE_VIEW_TYPE_1D_ARRAY, {16, 1, 1}, 4},
    {"image2D", "ivec2(i % 16, i / 16)", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_2D, {16, 4, 1}, 1},
    {"image2DArray", "ivec3(i % 8, i / 8 % 4, i / 32)", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_2D_ARRAY, {8, 4, 1}, 2},
    {"image3D", "ivec3(i % 4, i / 4 % 4, i / 16)", VK_IMAGE_TYPE_3D, VK_IMAGE_VIEW_TYPE_3D, {4, 4, 4}, 1},
    {"imageCube", "ivec3(i % 4, i / 4 % 4, i / 16)", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_CUBE, {4, 4, 1}, 6},
    {"imageCubeArray", "ivec3(i % 2, i / 2 % 2, i / 4)", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_CUBE_ARRAY, {2, 2, 1}, 18}};

bool is_cube(const Dimension& d) { return d.view == VK_IMAGE_VIEW_TYPE_CUBE || d.view == VK_IMAGE_VIEW_TYPE_CUBE_ARRAY; }

// `layout` is what stands in front of the declaration: a format, or nothing.
void store_and_load(ImageClient& client, const cts::FormatInfo& format, const Dimension& d, const std::string& layout,
                    std::mt19937& random, const Client::Buffer& values, const Client::Buffer& out) {
  const uint32_t texels = d.extent.width * d.extent.height * d.extent.depth * d.layers;
  const VkImage image = client.make({.format = format.format,
                                     .extent = d.extent,
                                     .type = d.type,
                                     .layers = d.layers,
                                     .usage = VK_IMAGE_USAGE_STORAGE_BIT,
                                     .flags = is_cube(d) ? VkImageCreateFlags{VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT} : 0});
  const VkImageView view = client.view(image, format.format, d.view, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, d.layers});
  std::vector<cts::Colour> colours(kCount);
  for (uint32_t i = 0; i < kCount; ++i) {
    for (uint32_t c = 0; c < 4; ++c) {
      colours[i][c] = random_channel(format, "rgba"[c], random);
      values.as<uint32_t>()[4 * i + c] = shader_word(format, colours[i][c]);
    }
  }
  const std::string prefix = glsl_prefix(format);
  const auto shader = [&](const char* access, const std::string& body) {
    return "#extension GL_EXT_shader_image_load_formatted : require\nlayout(local_size_x = 64) in;\nlayout(binding = 0" + layout +
           ") uniform " + access + " " + prefix + d.glsl + " t;\nlayout(std430, binding = 1) buffer O { " + prefix +
           "vec4 v[]; };\nvoid main() { int i = int(gl_GlobalInvocationID.x); " + body + " }";
  };
  const std::string place = d.place;
  const std::vector<uint8_t> before(size_t{texels} * format.bytes, 0x5A);
  client.upload(image, before, color_layers(0, 0, d.layers), d.extent);
  client.dispatch(shader("writeonly", "imageStore(t, " + place + ", v[i]);"), {{storage_image(view)}, {storage_buffer(values)}},
                  1);
  const std::vector<uint8_t> stored = client.download(image, before.size(), color_layers(0, 0, d.layers), d.extent);
  for (uint32_t i = 0; i < std::min(kCount, texels); ++i) {
    ASSERT_EQ(differs(format, &stored[size_t{i} * format.bytes], colours[i], kStoreSlack), "") << d.glsl << " texel " << i;
  }
  ASSERT_TRUE(std::equal(stored.begin() + kCount * format.bytes, stored.end(), before.begin())) << format.name << " " << d.glsl;
  client.dispatch(shader("readonly", "v[i] = imageLoad(t, " + place + ");"), {{storage_image(view)}, {storage_buffer(out)}}, 1);
  expect_read(format, stored.data(), out.as<uint32_t>(), kCount, d.glsl);
}

std::vector<const cts::FormatInfo*> storage_formats(ImageClient& client) {
  std::vector<const cts::FormatInfo*> out;
  for (const cts::FormatInfo& format : cts::colour_formats()) {
    if (client.format_properties(format.format).optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT)
      out.push_back(&format);
  }
  return out;
}

TEST(IcdFormatShader, EveryStorageFormatInEveryDimension) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto values = client.buffer(kCount * 16), out = client.buffer(kCount * 16);
  for (const Dimension& d : kDimensions) {
    for (const cts::FormatInfo* format : storage_formats(client)) {
      store_and_load(client, *format, d, "", random, values, out);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(IcdFormatShader, EveryDeclaredStorageFormat) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto values = client.buffer(kCount * 16), out = client.buffer(kCount * 16);
  uint32_t turn = 0;
  for (const cts::StorageFormat& declared : cts::storage_formats()) {
    const Dimension& d = kDimensions[turn++ % std::size(kDimensions)];
    store_and_load(client, cts::info_of(declared.format), d, std::string(", ") + declared.qualifier, random, values, out);
    if (HasFatalFailure()) return;
  }
}

// ---- linear filtering ----

constexpr uint32_t kWidth = 16, kHeight = 8;  // powers of two: coordinates are exact
constexpr VkExtent3D kTextureExtent{kWidth, kHeight, 1};

// One level of random texels and what they decode to.
struct Contents {
  std::vector<uint8_t> data;
  cts::Texture texture;
};

Contents plain_contents(const cts::FormatInfo& format, std::mt19937& random) {
  Contents out{random_texels(format, kWidth * kHeight, random), {}};
  cts::TextureLevel level{kWidth, kHeight, 1, {}};
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
    level.texels.push_back(cts::decode(format, reinterpret_cast<const std::byte*>(&out.data[size_t{i} * format.bytes])));
  }
  out.texture.levels.push_back(level);
  return out;
}

// Blocks are decoded by base/block_codec.h, which its own test compares with other decoders.
Contents block_contents(const FormatInfo& format, std::mt19937& random) {
  const uint32_t columns = (kWidth + format.block_width - 1) / format.block_width;
  const uint32_t rows = (kHeight + format.block_height - 1) / format.block_height;
  Contents out{random_bytes(size_t{columns} * rows * format.texel_bytes, random), {}};
  const cts::FormatInfo& decoded = cts::info_of(format.decoded);
  cts::TextureLevel level{kWidth, kHeight, 1, {}};
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      uint8_t block[kMaxBlockBytes];
      const size_t index = size_t{y / format.block_height} * columns + x / format.block_width;
      block_decoder(format)(format, &out.data[index * format.texel_bytes], block);
      const size_t texel = size_t{y % format.block_height} * format.block_width + x % format.block_width;
      level.texels.push_back(cts::decode(decoded, reinterpret_cast<const std::byte*>(block + texel * decoded.bytes)));
    }
  }
  out.texture.levels.push_back(level);
  return out;
}

Contents depth_contents(const FormatInfo& plane, std::mt19937& random) {
  Contents out{std::vector<uint8_t>(size_t{kWidth} * kHeight * plane.texel_bytes), {}};
  cts::TextureLevel level{kWidth, kHeight, 1, {}};
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const auto depth = static_cast<float>(random() / 0x1p32);
    const uint32_t code = plane.texel_bytes == 2 ? random() & 0xFFFF : random() & 0xFFFFFF;
    const double steps = plane.texel_bytes == 2 ? 65535 : 16777215;
    const bool is_float = plane.format == VK_FORMAT_D32_SFLOAT;
    std::memcpy(&out.data[size_t{i} * plane.texel_bytes], is_float ? static_cast<const void*>(&depth) : &code, plane.texel_bytes);
    level.texels.push_back({is_float ? double{depth} : code / steps, 0, 0, 1});
  }
  out.texture.levels.push_back(level);
  return out;
}

TEST(IcdFormatShader, EveryLinearFormat) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto places = client.buffer(kCount * 16), out = client.buffer(kCount * 16);
  VkSamplerCreateInfo info{.magFilter = VK_FILTER_LINEAR, .minFilter = VK_FILTER_LINEAR};
  info.addressModeU = VK_SAMPLER_ADDRESS_MODE_REPEAT;
  info.addressModeV = VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
  const VkSampler sampler = client.sampler(info);
  cts::SamplerState state;
  state.mag = state.min = VK_FILTER_LINEAR;
  state.address = {VK_SAMPLER_ADDRESS_MODE_REPEAT, VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT, VK_SAMPLER_ADDRESS_MODE_REPEAT};
  uint32_t formats = 0;
  for (const FormatInfo& format : all_formats()) {
    if (!(client.format_properties(format.format).optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT))
      continue;
    if (format.plane_count() > 1 && !format.is_depth()) continue;  // YCbCr: IcdSampling.YcbcrConversion
    ++formats;
    const VkImageAspectFlags aspect = format.is_depth() ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    const Contents contents = format.is_depth() ? depth_contents(*find_format(aspect_format(format.format, aspect)), random)
                              : format.is_compressed() ? block_contents(format, random)
                                                       : plain_contents(cts::info_of(format.format), random);
    const VkImage image = client.make({.format = format.format, .extent = kTextureExtent});
    client.upload(image, contents.data, {aspect, 0, 0, 1}, kTextureExtent);
    for (uint32_t i = 0; i < kCount; ++i) {  // multiples of a 256th of a texel, so that the weights are exact
      places.as<float>()[4 * i] = static_cast<float>(static_cast<int>(random() % 12288) - 4096) / (256 * kWidth);
      places.as<float>()[4 * i + 1] = static_cast<float>(static_cast<int>(random() % 6144) - 2048) / (256 * kHeight);
    }
    client.dispatch(
        "layout(local_size_x = 64) in;\nlayout(binding = 0) uniform sampler2D t;\n"
        "layout(std430, binding = 1) buffer P { vec4 p[]; };\nlayout(std430, binding = 2) buffer O { vec4 o[]; };\n"
        "void main() { uint i = gl_GlobalInvocationID.x; o[i] = textureLod(t, p[i].xy, 0); }",
        {{sampled_image(client.view(image, format.format, {}, aspect), sampler)},
         {storage_buffer(places)},
         {storage_buffer(out)}},
        1);
    double largest = 0;
    bool all_finite = true;
    for (const cts::Colour& texel : contents.texture.levels[0].texels) {
      for (const double v : texel) largest = std::max(largest, std::abs(v)), all_finite &= std::isfinite(v);
    }
    ASSERT_TRUE(all_finite) << format.name;
    for (uint32_t i = 0; i < kCount; ++i) {
      const float* p = places.as<float>() + 4 * i;
      const cts::Sample want = cts::sample(contents.texture, state, {p[0], p[1]}, 0);
      for (uint32_t c = 0; c < (format.is_depth() ? 1u : 4u); ++c) {
        // A weighted sum of four texels in binary32: eight roundings of terms no larger than the largest texel.
        ASSERT_NEAR(out.as<float>()[4 * i + c], want.value[c], 8 * largest * 0x1p-24)
            << format.name << " at " << p[0] << ", " << p[1];
      }
    }
  }
  EXPECT_GE(formats, 100u);
}

}  // namespace
}  // namespace pineda::test
