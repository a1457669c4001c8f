// Every format that the driver advertises, for every use of it that goes through memory: upload and fetch, clear, blit from and
// to it. The oracle is the host's side of the table (base/format.h), which base and kernels tests hold against the
// specification's formulas, and base/block_codec.h, which its test holds against other decoders.
#include <cmath>
#include <random>

#include "base/block_codec.h"
#include "base/format.h"
#include "format_shaders.h"
#include "icd_pipeline_client.h"

namespace pineda::test {
namespace {

constexpr uint32_t kSeed = 20240621;
constexpr VkExtent3D kExtent{21, 19, 1};  // no multiple of any block
constexpr uint32_t kTexels = kExtent.width * kExtent.height;

// Formats of colour planes need a conversion: their tests are elsewhere.
bool is_ycbcr(const FormatInfo& format) { return format.plane_count() > 1 && !format.is_depth_or_stencil(); }

uint32_t blocks(uint32_t texels, uint32_t size) { return (texels + size - 1) / size; }

// One aspect of a format: what is uploaded, and what a shader sees of it.
struct Aspect {
  const FormatInfo* stored;  // blocks or texels
  const FormatInfo* shown;   // plain
  VkImageAspectFlags aspect;
};

std::vector<Aspect> aspects_of(const FormatInfo& format) {
  if (format.is_compressed()) return {{&format, find_format(format.decoded), VK_IMAGE_ASPECT_COLOR_BIT}};
  std::vector<Aspect> out;
  for (const VkImageAspectFlags aspect : {VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_ASPECT_STENCIL_BIT}) {
    const FormatInfo* plane = find_format(aspect_format(format.format, aspect));
    if (plane && plane->is_plain()) out.push_back({plane, plane, aspect});
  }
  return out;
}

std::vector<uint8_t> random_data(const FormatInfo& stored) {
  std::mt19937 random(kSeed + stored.format);
  std::vector<uint8_t> data(size_t{blocks(kExtent.width, stored.block_width)} * blocks(kExtent.height, stored.block_height) *
                            stored.texel_bytes);
  for (uint8_t& byte : data) byte = static_cast<uint8_t>(random());
  return data;
}

// All texels of what is shown, without gaps.
std::vector<uint8_t> decode(const Aspect& aspect, const std::vector<uint8_t>& data) {
  const FormatInfo& stored = *aspect.stored;
  if (!stored.is_compressed()) return data;
  const uint32_t bytes = aspect.shown->texel_bytes, columns = blocks(kExtent.width, stored.block_width);
  std::vector<uint8_t> out(size_t{kTexels} * bytes);
  for (uint32_t y = 0; y < kExtent.height; ++y) {
    for (uint32_t x = 0; x < kExtent.width; ++x) {
      uint8_t block[kMaxBlockBytes];
      const size_t index = size_t{y / stored.block_height} * columns + x / stored.block_width;
      block_decoder(stored)(stored, &data[index * stored.texel_bytes], block);
      const size_t texel = size_t{y % stored.block_height} * stored.block_width + x % stored.block_width;
      std::memcpy(&out[(size_t{y} * kExtent.width + x) * bytes], block + texel * bytes, bytes);
    }
  }
  return out;
}

class FormatClient : public PipelineClient {
 public:
  FormatClient() : out_(buffer(size_t{kTexels} * 16)) {
    set_layout_ = set_layout({{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_ALL, nullptr},
                              {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_ALL, nullptr}});
    layout_ = pipeline_layout(set_layout_, 8);
    EXPECT_EQ(compute_pipeline(layout_, module(kFetchFloatCompute), nullptr, &float_), VK_SUCCESS);
    EXPECT_EQ(compute_pipeline(layout_, module(kFetchUintCompute), nullptr, &uint_), VK_SUCCESS);
    EXPECT_EQ(compute_pipeline(layout_, module(kFetchSintCompute), nullptr, &sint_), VK_SUCCESS);
  }

  VkFormatFeatureFlags features(const FormatInfo& format) {
    VkFormatProperties properties;
    VK(*this, GetPhysicalDeviceFormatProperties)(physical, format.format, &properties);
    return properties.optimalTilingFeatures;
  }

  // RGBA of every texel as 32-bit words, after texelFetch.
  const VkClearColorValue* fetch(VkImageView view, const FormatInfo& shown) {
    const VkDescriptorSet set = descriptor_set(set_layout_);
    write_image(set, 0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, view, nearest_sampler());
    write_buffer(set, 1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, {out_.handle, 0, VK_WHOLE_SIZE});
    run([&](VkCommandBuffer cb) {
      const VkPipeline pipeline = shown.numeric == Numeric::kUint ? uint_ : shown.numeric == Numeric::kSint ? sint_ : float_;
      VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      VK(*this, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
      const uint32_t size[2] = {kExtent.width, kExtent.height};
      VK(*this, CmdPushConstants)(cb, layout_, VK_SHADER_STAGE_ALL, 0, 8, size);
      VK(*this, CmdDispatch)(cb, (size[0] + 7) / 8, (size[1] + 7) / 8, 1);
    });
    return out_.as<VkClearColorValue>();
  }

  // Stores all texels of the buffer in an image, or loads them.
  void storage(VkImageView view, const FormatInfo& format, const Buffer& texels, bool store) {
    if (!storage_layout_) {
      storage_set_layout_ = set_layout({{0, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_ALL, nullptr},
                                        {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_ALL, nullptr}});
      storage_layout_ = pipeline_layout(storage_set_layout_, 12);
      EXPECT_EQ(compute_pipeline(storage_layout_, module(kStorageFloatCompute), nullptr, &storage_[0]), VK_SUCCESS);
      EXPECT_EQ(compute_pipeline(storage_layout_, module(kStorageUintCompute), nullptr, &storage_[1]), VK_SUCCESS);
      EXPECT_EQ(compute_pipeline(storage_layout_, module(kStorageSintCompute), nullptr, &storage_[2]), VK_SUCCESS);
    }
    const VkDescriptorSet set = descriptor_set(storage_set_layout_);
    write_image(set, 0, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, view);
    write_buffer(set, 1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, {texels.handle, 0, VK_WHOLE_SIZE});
    run([&](VkCommandBuffer cb) {
      const int kind = format.numeric == Numeric::kUint ? 1 : format.numeric == Numeric::kSint ? 2 : 0;
      VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, storage_[kind]);
      VK(*this, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, storage_layout_, 0, 1, &set, 0, nullptr);
      const uint32_t push[3] = {kExtent.width, kExtent.height, store};
      VK(*this, CmdPushConstants)(cb, storage_layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), push);
      VK(*this, CmdDispatch)(cb, (push[0] + 7) / 8, (push[1] + 7) / 8, 1);
    });
  }

  void upload(VkImage image, const Aspect& aspect, const std::vector<uint8_t>& data) {
    const Buffer in = buffer(data.size());
    std::memcpy(in.data, data.data(), data.size());
    run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy region{0, 0, 0, {aspect.aspect, 0, 0, 1}, {}, kExtent};
      VK(*this, CmdCopyBufferToImage)(cb, in.handle, image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    });
  }

  std::vector<uint8_t> download(VkImage image, const Aspect& aspect) {
    std::vector<uint8_t> data(random_data(*aspect.stored).size());
    const Buffer out = buffer(data.size());
    run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy region{0, 0, 0, {aspect.aspect, 0, 0, 1}, {}, kExtent};
      VK(*this, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
    });
    std::memcpy(data.data(), out.data, data.size());
    return data;
  }

  void blit(VkImage from, VkImage to, VkFilter filter = VK_FILTER_NEAREST,
            VkImageAspectFlags aspects = VK_IMAGE_ASPECT_COLOR_BIT) {
    run([&](VkCommandBuffer cb) {
      const VkOffset3D end{kExtent.width, kExtent.height, 1};
      const VkImageBlit region{{aspects, 0, 0, 1}, {{}, end}, {aspects, 0, 0, 1}, {{}, end}};
      VK(*this, CmdBlitImage)(cb, from, VK_IMAGE_LAYOUT_GENERAL, to, VK_IMAGE_LAYOUT_GENERAL, 1, &region, filter);
    });
  }

 private:
  Buffer out_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorSetLayout storage_set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout storage_layout_ = VK_NULL_HANDLE;
  VkPipeline storage_[3] = {};
  VkPipeline float_ = VK_NULL_HANDLE, uint_ = VK_NULL_HANDLE, sint_ = VK_NULL_HANDLE;
};

// The same bits, or NaN for NaN.
bool equal(const FormatInfo& shown, const VkClearColorValue& got, const VkClearColorValue& want, uint32_t components = 4) {
  for (uint32_t c = 0; c < components; ++c) {
    const bool both_nan = !shown.is_integer() && std::isnan(got.float32[c]) && std::isnan(want.float32[c]);
    if (got.uint32[c] != want.uint32[c] && !both_nan) return false;
  }
  return true;
}

TEST(IcdFormat, EverySampledFormatIsFetched) {
  uint32_t formats = 0;
  for (const FormatInfo& format : all_formats()) {
    FormatClient client;
    if (!(client.features(format) & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT) || is_ycbcr(format)) continue;
    ++formats;
    for (const Aspect& aspect : aspects_of(format)) {
      const VkImage image = client.image(format.format, kExtent, 1, 1, VK_IMAGE_USAGE_SAMPLED_BIT);
      const std::vector<uint8_t> data = random_data(*aspect.stored), texels = decode(aspect, data);
      client.upload(image, aspect, data);
      const VkClearColorValue* got = client.fetch(client.view(image, format.format, {}, aspect.aspect), *aspect.shown);
      for (uint32_t i = 0; i < kTexels; ++i) {
        VkClearColorValue want = unpack_texel(*aspect.shown, &texels[size_t{i} * aspect.shown->texel_bytes]);
        const uint32_t components = aspect.aspect == VK_IMAGE_ASPECT_COLOR_BIT ? 4 : 1;  // depth: the others are undefined
        ASSERT_TRUE(equal(*aspect.shown, got[i], want, components)) << format.name << " texel " << i;
      }
      // X8_D24 has 8 undefined bits.
      if (aspect.stored->format == VK_FORMAT_X8_D24_UNORM_PACK32) continue;
      EXPECT_EQ(client.download(image, aspect), data) << format.name;
    }
  }
  EXPECT_GE(formats, 130u);
}

TEST(IcdFormat, EveryFormatIsCleared) {
  FormatClient client;
  for (const FormatInfo& format : all_formats()) {
    if (!(client.features(format) & VK_FORMAT_FEATURE_TRANSFER_DST_BIT) || format.is_compressed() || is_ycbcr(format)) continue;
    const VkImage image = client.image(format.format, kExtent);
    VkClearColorValue color{};
    for (uint32_t c = 0; c < 4; ++c) {
      if (format.is_integer()) {
        color.uint32[c] = 0x01020304u * (c + 1);
      } else {
        color.float32[c] = 0.3f + 0.17f * static_cast<float>(c);
      }
    }
    const VkClearDepthStencilValue depth_stencil{0.3f, 0xA7};
    client.run([&](VkCommandBuffer cb) {
      const VkImageSubresourceRange range{format.aspects, 0, 1, 0, 1};
      if (format.is_depth_or_stencil()) {
        VK(client, CmdClearDepthStencilImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &depth_stencil, 1, &range);
      } else {
        VK(client, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
      }
    });
    for (const Aspect& aspect : aspects_of(format)) {
      uint8_t want[16] = {0xA7};
      if (aspect.aspect == VK_IMAGE_ASPECT_COLOR_BIT) pack_clear_color(*aspect.stored, color, want);
      if (aspect.aspect == VK_IMAGE_ASPECT_DEPTH_BIT) pack_depth(*aspect.stored, depth_stencil.depth, want);
      const std::vector<uint8_t> got = client.download(image, aspect);
      for (uint32_t i = 0; i < kTexels; ++i) {
        ASSERT_EQ(std::memcmp(&got[size_t{i} * aspect.stored->texel_bytes], want, aspect.stored->texel_bytes), 0) << format.name;
      }
    }
  }
}

// The widest format of the same kind.
VkFormat wide_format(const FormatInfo& shown) {
  return shown.numeric == Numeric::kUint   ? VK_FORMAT_R32G32B32A32_UINT
         : shown.numeric == Numeric::kSint ? VK_FORMAT_R32G32B32A32_SINT
                                           : VK_FORMAT_R32G32B32A32_SFLOAT;
}

TEST(IcdFormat, EveryFormatIsBlittedFrom) {
  FormatClient client;
  for (const FormatInfo& format : all_formats()) {
    if (!(client.features(format) & VK_FORMAT_FEATURE_BLIT_SRC_BIT) || format.is_depth_or_stencil() || is_ycbcr(format)) continue;
    const Aspect aspect = aspects_of(format)[0];
    const FormatInfo& wide = *find_format(wide_format(*aspect.shown));
    const VkImage source = client.image(format.format, kExtent), destination = client.image(wide.format, kExtent);
    const std::vector<uint8_t> data = random_data(*aspect.stored), texels = decode(aspect, data);
    client.upload(source, aspect, data);
    client.blit(source, destination);
    const std::vector<uint8_t> got = client.download(destination, {&wide, &wide, VK_IMAGE_ASPECT_COLOR_BIT});
    for (uint32_t i = 0; i < kTexels; ++i) {
      VkClearColorValue texel;
      std::memcpy(&texel, &got[16 * size_t{i}], 16);
      const VkClearColorValue want = unpack_texel(*aspect.shown, &texels[size_t{i} * aspect.shown->texel_bytes]);
      ASSERT_TRUE(equal(*aspect.shown, texel, want)) << format.name << " texel " << i;
    }
  }
}

TEST(IcdFormat, EveryFormatIsBlittedTo) {
  FormatClient client;
  std::mt19937 random(kSeed);
  for (const FormatInfo& format : all_formats()) {
    if (!(client.features(format) & VK_FORMAT_FEATURE_BLIT_DST_BIT) || format.is_depth_or_stencil()) continue;
    const FormatInfo& wide = *find_format(wide_format(format));
    std::vector<VkClearColorValue> texels(kTexels);
    for (VkClearColorValue& texel : texels) {
      for (uint32_t c = 0; c < 4; ++c) {
        if (format.is_integer()) {  // what fits: other values are undefined
          const uint32_t bits = format.component[c].bits ? format.component[c].bits : 8;
          texel.uint32[c] = static_cast<uint32_t>(random()) >> (33 - bits);
        } else {
          texel.float32[c] = static_cast<float>(random() / 0x1p32 * 2.5 - 1.25);
        }
      }
    }
    std::vector<uint8_t> data(size_t{kTexels} * 16);
    std::memcpy(data.data(), texels.data(), data.size());
    const VkImage source = client.image(wide.format, kExtent), destination = client.image(format.format, kExtent);
    client.upload(source, {&wide, &wide, VK_IMAGE_ASPECT_COLOR_BIT}, data);
    client.blit(source, destination);
    const std::vector<uint8_t> got = client.download(destination, {&format, &format, VK_IMAGE_ASPECT_COLOR_BIT});
    for (uint32_t i = 0; i < kTexels; ++i) {
      uint8_t want[16] = {};
      pack_clear_color(format, texels[i], want);
      ASSERT_EQ(std::memcmp(&got[size_t{i} * format.texel_bytes], want, format.texel_bytes), 0) << format.name << " texel " << i;
    }
  }
}

// Stores and loads of images that the shader declares without a format.
TEST(IcdFormat, EveryStorageFormatIsWrittenAndRead) {
  FormatClient client;
  std::mt19937 random(kSeed);
  const auto texels = client.buffer(size_t{kTexels} * 16);
  uint32_t formats = 0;
  for (const FormatInfo& format : all_formats()) {
    if (!(client.features(format) & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT)) continue;
    ++formats;
    const VkImage image = client.image(format.format, kExtent, 1, 1, VK_IMAGE_USAGE_STORAGE_BIT);
    const VkImageView view = client.view(image, format.format);
    auto* values = texels.as<VkClearColorValue>();
    for (uint32_t i = 0; i < kTexels; ++i) {
      for (uint32_t c = 0; c < 4; ++c) {
        if (format.is_integer()) {
          const uint32_t bits = format.component[c].bits ? format.component[c].bits : 8;
          values[i].uint32[c] = static_cast<uint32_t>(random()) >> (33 - bits);
        } else {
          values[i].float32[c] = static_cast<float>(random() / 0x1p32 * 2.5 - 1.25);
        }
      }
    }
    const Aspect aspect{&format, &format, VK_IMAGE_ASPECT_COLOR_BIT};
    std::vector<uint8_t> want(size_t{kTexels} * format.texel_bytes);
    for (uint32_t i = 0; i < kTexels; ++i) pack_clear_color(format, values[i], &want[size_t{i} * format.texel_bytes]);
    client.storage(view, format, texels, true);
    ASSERT_EQ(client.download(image, aspect), want) << format.name;
    client.storage(view, format, texels, false);
    for (uint32_t i = 0; i < kTexels; ++i) {
      ASSERT_TRUE(equal(format, values[i], unpack_texel(format, &want[size_t{i} * format.texel_bytes]))) << format.name;
    }
  }
  EXPECT_GE(formats, 40u);
}

TEST(IcdFormat, DepthAndStencilAreBlittedTogether) {
  FormatClient client;
  for (const FormatInfo& format : all_formats()) {
    if (!format.is_depth_or_stencil() || !(client.features(format) & VK_FORMAT_FEATURE_BLIT_SRC_BIT)) continue;
    const VkImage source = client.image(format.format, kExtent), destination = client.image(format.format, kExtent);
    for (const Aspect& aspect : aspects_of(format)) client.upload(source, aspect, random_data(*aspect.stored));
    client.blit(source, destination, VK_FILTER_NEAREST, format.aspects);
    for (const Aspect& aspect : aspects_of(format)) EXPECT_EQ(client.download(destination, aspect), random_data(*aspect.stored));
  }
}

}  // namespace
}  // namespace pineda::test
