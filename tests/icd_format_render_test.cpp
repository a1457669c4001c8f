// Every format that is advertised as an attachment, through the API: rendered to, blended, with several samples (rendered,
// resolved, fetched, copied, stored to and loaded from by shaders). Expected values: cts-subset/reference.
#include <gtest/gtest.h>

#include "base/format.h"
#include "format_oracle.h"
#include "image_client.h"

namespace pineda::test {
namespace {

constexpr uint32_t kSeed = 20250301, kSide = 16, kPixels = kSide * kSide;
constexpr VkExtent3D kExtent{kSide, kSide, 1};
// Scaling a binary32 value to codes rounds once, and so did the value.
constexpr double kRenderSlack = 0x1p-23;

// A fragment shader that writes element (pixel * samples + sample) of a buffer.
std::string copy_shader(const std::string& prefix, bool every_sample) {
  return "layout(std430, binding = 0) readonly buffer V { " + prefix + "vec4 v[]; };\nlayout(location = 0) out " + prefix +
         "vec4 o;\nlayout(push_constant) uniform P { uint samples; };\n"
         "void main() { uint p = uint(gl_FragCoord.y) * 16 + uint(gl_FragCoord.x);\n  o = v[p * samples + " +
         (every_sample ? "gl_SampleID" : "0") + "]; }";
}

// `count` colours, as a shader reads them; the exact values.
std::vector<cts::Colour> random_colours(const cts::FormatInfo& format, uint32_t count, const Client::Buffer& buffer,
                                        std::mt19937& random) {
  std::vector<cts::Colour> colours(count);
  for (uint32_t i = 0; i < count; ++i) {
    for (uint32_t c = 0; c < 4; ++c) {
      colours[i][c] = random_channel(format, "rgba"[c], random);
      buffer.as<uint32_t>()[4 * i + c] = shader_word(format, colours[i][c]);
    }
  }
  return colours;
}

std::vector<const cts::FormatInfo*> formats_with(ImageClient& client, VkFormatFeatureFlags features) {
  std::vector<const cts::FormatInfo*> out;
  for (const cts::FormatInfo& format : cts::colour_formats()) {
    if ((client.format_properties(format.format).optimalTilingFeatures & features) == features) out.push_back(&format);
  }
  return out;
}

// The reference knows every colour format that the driver does: none is left out of the tests below.
TEST(IcdFormatRender, TheReferenceKnowsEveryFormat) {
  for (const FormatInfo& format : all_formats()) {
    if (!format.is_plain() || format.is_depth_or_stencil()) continue;
    EXPECT_NO_THROW(cts::info_of(format.format)) << format.name;
  }
}

TEST(IcdFormatRender, EveryColourFormat) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto values = client.buffer(kPixels * 16);
  const auto formats = formats_with(client, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT);
  EXPECT_GE(formats.size(), 60u);
  uint32_t turn = 0;
  for (const cts::FormatInfo* format : formats) {
    const bool linear =
        turn++ % 4 == 3 && client.format_properties(format->format).linearTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT;
    const VkImage image = client.make({.format = format->format,
                                       .extent = kExtent,
                                       .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                       .tiling = linear ? VK_IMAGE_TILING_LINEAR : VK_IMAGE_TILING_OPTIMAL});
    const std::vector<cts::Colour> colours = random_colours(*format, kPixels, values, random);
    client.draw({.fragment = copy_shader(glsl_prefix(*format), false),
                 .bindings = {{storage_buffer(values)}},
                 .push = {1},
                 .color = client.view(image, format->format),
                 .color_format = format->format,
                 .extent = {kSide, kSide}});
    const std::vector<uint8_t> got = client.download(image, kPixels * format->bytes, color_layers(), kExtent);
    for (uint32_t i = 0; i < kPixels; ++i) {
      ASSERT_EQ(differs(*format, &got[i * format->bytes], colours[i], kRenderSlack), "") << "pixel " << i;
    }
  }
}

// Colours: source alpha over what is there; alphas: their sum.
TEST(IcdFormatRender, EveryBlendableFormat) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto values = client.buffer(kPixels * 16);
  const auto formats = formats_with(client, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT);
  EXPECT_GE(formats.size(), 35u);
  for (const cts::FormatInfo* format : formats) {
    const VkImage image =
        client.make({.format = format->format, .extent = kExtent, .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT});
    std::vector<cts::Colour> colours = random_colours(*format, kPixels, values, random);
    for (uint32_t i = 0; i < kPixels; ++i) {  // a source alpha between 0 and 1 for every format
      colours[i][3] = static_cast<float>(random() / 0x1p32);
      values.as<float>()[4 * i + 3] = static_cast<float>(colours[i][3]);
    }
    const std::vector<uint8_t> before = random_texels(*format, kPixels, random);
    client.upload(image, before, color_layers(), kExtent);
    client.draw({.fragment = copy_shader("", false),
                 .bindings = {{storage_buffer(values)}},
                 .push = {1},
                 .color = client.view(image, format->format),
                 .color_format = format->format,
                 .extent = {kSide, kSide},
                 .blend = {VK_TRUE, VK_BLEND_FACTOR_SRC_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA, VK_BLEND_OP_ADD,
                           VK_BLEND_FACTOR_ONE, VK_BLEND_FACTOR_ONE, VK_BLEND_OP_ADD, 0xF}});
    const std::vector<uint8_t> got = client.download(image, kPixels * format->bytes, color_layers(), kExtent);
    const cts::Numeric numeric = format->channels[0].numeric;
    const bool fixed = numeric != cts::Numeric::kSfloat && numeric != cts::Numeric::kUfloat;
    const double lowest = numeric == cts::Numeric::kSnorm ? -1 : 0;
    for (uint32_t i = 0; i < kPixels; ++i) {
      cts::Colour source = colours[i], want;
      const cts::Colour there = cts::decode(*format, reinterpret_cast<const std::byte*>(&before[i * format->bytes]));
      double terms = 1;
      for (uint32_t c = 0; c < 4; ++c) {  // "Blending": fixed-point attachments clamp the source first
        if (fixed) source[c] = std::clamp(source[c], lowest, 1.0);
        want[c] = c == 3 ? source[3] + there[3] : source[c] * source[3] + there[c] * (1 - source[3]);
        terms = std::max({terms, std::abs(source[c]), std::abs(there[c])});
      }
      // Four roundings of terms of this size.
      ASSERT_EQ(differs(*format, &got[i * format->bytes], want, 4 * terms * 0x1p-24), "") << "pixel " << i;
    }
  }
}

struct DepthFormat {
  VkFormat format;
  double steps;  // codes for 1.0; 0: binary32
  uint32_t bytes;
};

TEST(IcdFormatRender, EveryDepthFormat) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto values = client.buffer(kPixels * 4);
  for (const DepthFormat& format : {DepthFormat{VK_FORMAT_D16_UNORM, 65535, 2},
                                    {VK_FORMAT_X8_D24_UNORM_PACK32, 16777215, 4},
                                    {VK_FORMAT_D32_SFLOAT, 0, 4},
                                    {VK_FORMAT_D16_UNORM_S8_UINT, 65535, 2},
                                    {VK_FORMAT_D24_UNORM_S8_UINT, 16777215, 4},
                                    {VK_FORMAT_D32_SFLOAT_S8_UINT, 0, 4}}) {
    ASSERT_TRUE(client.format_properties(format.format).optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT);
    for (uint32_t i = 0; i < kPixels; ++i) values.as<float>()[i] = static_cast<float>(random() / 0x1p32);
    values.as<float>()[0] = 0, values.as<float>()[1] = 1;
    const VkImage image =
        client.make({.format = format.format, .extent = kExtent, .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT});
    const VkImageAspectFlags aspects = find_format(format.format)->aspects;
    client.draw({.fragment = "layout(std430, binding = 0) readonly buffer V { float v[]; };"
                             "void main() { gl_FragDepth = v[uint(gl_FragCoord.y) * 16 + uint(gl_FragCoord.x)]; }",
                 .bindings = {{storage_buffer(values)}},
                 .depth = client.view(image, format.format, {}, aspects),
                 .depth_format = format.format,
                 .extent = {kSide, kSide}});
    const std::vector<uint8_t> got =
        client.download(image, kPixels * format.bytes, {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, 1}, kExtent);
    for (uint32_t i = 0; i < kPixels; ++i) {
      const float want = values.as<float>()[i];
      uint32_t code = 0;
      std::memcpy(&code, &got[i * format.bytes], format.bytes);
      if (format.steps == 0) {
        ASSERT_EQ(code, std::bit_cast<uint32_t>(want));
      } else {  // the nearest code, or with 24 bits of mantissa its neighbour
        ASSERT_NEAR(code & 0xFFFFFF, want * format.steps, format.bytes == 2 ? 0.501 : 1) << "format " << format.format;
      }
    }
  }
}

// ---- several samples ----

struct MultisampleCase {
  ImageClient& client;
  const cts::FormatInfo& format;
  uint32_t samples;
  VkImage image;
  VkImageView view;
};

// Every sample of a multisampled image, by texelFetch or imageLoad, as words.
void read_samples(const MultisampleCase& c, VkImageView view, const Client::Buffer& out, bool storage) {
  const std::string prefix = glsl_prefix(c.format);
  const std::string declared = storage ? "readonly uniform " + prefix + "image2DMS" : "uniform " + prefix + "sampler2DMS";
  const std::string texel = storage ? "imageLoad" : "texelFetch";
  c.client.dispatch(
      "#extension GL_EXT_shader_image_load_formatted : require\n"
      "layout(local_size_x = 64) in;\nlayout(push_constant) uniform P { uint samples; };\n"
      "layout(binding = 0) " +
          declared + " image;\nlayout(std430, binding = 1) writeonly buffer O { " + prefix +
          "vec4 o[]; };\nvoid main() { uint i = gl_GlobalInvocationID.x, p = i / samples;\n"
          "  o[i] = " +
          texel + "(image, ivec2(p % 16, p / 16), int(i % samples)); }",
      {{storage ? storage_image(view) : sampled_image(view, c.client.nearest_sampler())}, {storage_buffer(out)}},
      kPixels * c.samples / 64, {c.samples});
}

void expect_samples(const MultisampleCase& c, const std::vector<cts::Colour>& colours, const Client::Buffer& out,
                    const char* what) {
  for (uint32_t i = 0; i < kPixels * c.samples; ++i) {
    for (uint32_t n = 0; n < 4; ++n) {
      const cts::Channel* channel = c.format.channel("rgba"[n]);
      const double got = from_word(c.format, out.as<uint32_t>()[4 * i + n]);
      if (!channel) {
        ASSERT_EQ(got, n == 3 ? 1 : 0) << c.format.name;
        continue;
      }
      // A decoded code is rounded to binary32 once more: compare with the number that the code stands for.
      const cts::Bracket near = cts::representable(*channel, got);
      const double decoded = std::abs(got - near.low) < std::abs(near.high - got) ? near.low : near.high;
      ASSERT_NEAR(got, decoded, std::abs(decoded) * 0x1p-23) << c.format.name;
      ASSERT_TRUE(holds(*channel, decoded, colours[i][n], kRenderSlack * (1 + std::abs(colours[i][n]))))
          << what << " " << c.format.name << " x" << c.samples << " element " << i << " channel " << n << " is " << got << " for "
          << colours[i][n];
    }
  }
}

// The mean of the samples that were fetched, for numbers; sample 0 of integers ("Multisample Resolve").
void expect_resolved(const MultisampleCase& c, VkImage resolved, const Client::Buffer& fetched, const char* what) {
  const std::vector<uint8_t> got = c.client.download(resolved, kPixels * c.format.bytes, color_layers(), kExtent);
  for (uint32_t i = 0; i < kPixels; ++i) {
    cts::Colour want{};
    double terms = 1;
    for (uint32_t s = 0; s < c.samples; ++s) {
      for (uint32_t n = 0; n < 4; ++n) {
        const double sample = from_word(c.format, fetched.as<uint32_t>()[4 * (i * c.samples + s) + n]);
        terms = std::max(terms, std::abs(sample));
        if (!c.format.is_integer()) want[n] += sample / c.samples;
        if (c.format.is_integer() && s == 0) want[n] = sample;
      }
    }
    // Sixteen additions, each rounded.
    ASSERT_EQ(differs(c.format, &got[i * c.format.bytes], want, 16 * terms * 0x1p-24), "")
        << what << " x" << c.samples << " pixel " << i;
  }
}

TEST(IcdFormatRender, EverySampleOfEveryColourFormat) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const auto values = client.buffer(kPixels * 16 * 16), out = client.buffer(kPixels * 16 * 16);
  uint32_t turn = 0;
  for (const cts::FormatInfo* format : formats_with(client, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT)) {
    const uint32_t samples = 2u << turn++ % 4;  // 2, 4, 8, 16 in turn
    const bool stores = client.format_properties(format->format).optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
    const VkImageUsageFlags usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const ImageInfo info{.format = format->format, .extent = kExtent, .samples = samples, .usage = usage};
    const VkImage image = client.make(info), copy = client.make(info);
    const VkImage resolved[2] = {client.make({.format = format->format, .extent = kExtent, .usage = usage}),
                                 client.make({.format = format->format, .extent = kExtent, .usage = usage})};
    const MultisampleCase c{client, *format, samples, image, client.view(image, format->format)};
    std::vector<cts::Colour> colours = random_colours(*format, kPixels * samples, values, random);
    client.draw({.fragment = copy_shader(glsl_prefix(*format), true),
                 .bindings = {{storage_buffer(values)}},
                 .push = {samples},
                 .color = c.view,
                 .resolve = client.view(resolved[0], format->format),
                 .color_format = format->format,
                 .samples = samples,
                 .extent = {kSide, kSide}});
    client.run([&](VkCommandBuffer cb) {
      const VkImageCopy whole{color_layers(), {}, color_layers(), {}, kExtent};
      VK(client, CmdCopyImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, copy, VK_IMAGE_LAYOUT_GENERAL, 1, &whole);
      const VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT,
                                    VK_ACCESS_TRANSFER_READ_BIT};
      VK(client, CmdPipelineBarrier)
      (cb, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
      const VkImageResolve resolve{color_layers(), {}, color_layers(), {}, kExtent};
      VK(client, CmdResolveImage)(cb, copy, VK_IMAGE_LAYOUT_GENERAL, resolved[1], VK_IMAGE_LAYOUT_GENERAL, 1, &resolve);
    });
    read_samples(c, client.view(copy, format->format), out, false);
    expect_samples(c, colours, out, "fetched");
    expect_resolved(c, resolved[0], out, "resolved by the pass");
    expect_resolved(c, resolved[1], out, "resolved by the command");
    if (!stores || HasFatalFailure()) continue;
    // Stored by a compute shader to an image that is then loaded, and fetched.
    ImageInfo stored_info = info;
    stored_info.usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const VkImage stored = client.make(stored_info);
    const VkImageView stored_view = client.view(stored, format->format);
    colours = random_colours(*format, kPixels * samples, values, random);
    const std::string prefix = glsl_prefix(*format);
    client.dispatch(
        "layout(local_size_x = 64) in;\nlayout(push_constant) uniform P { uint samples; };\n"
        "layout(binding = 0) writeonly uniform " +
            prefix +
            "image2DMS image;\n"
            "layout(std430, binding = 1) readonly buffer V { " +
            prefix +
            "vec4 v[]; };\n"
            "void main() { uint i = gl_GlobalInvocationID.x, p = i / samples;\n"
            "  imageStore(image, ivec2(p % 16, p / 16), int(i % samples), v[i]); }",
        {{storage_image(stored_view)}, {storage_buffer(values)}}, kPixels * samples / 64, {samples});
    for (const bool storage : {true, false}) {
      read_samples(c, stored_view, out, storage);
      expect_samples(c, colours, out, storage ? "loaded" : "fetched after a store");
    }
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace pineda::test
