// A client that moves texels of any format in and out of images: uploads and downloads, fetches and storage accesses by compute
// shaders, blits; and the host's decoding, for comparison.
#pragma once

#include <cmath>
#include <random>

#include "base/block_codec.h"
#include "base/format.h"
#include "format_shaders.h"
#include "icd_pipeline_client.h"

namespace pineda::test {

inline constexpr uint32_t kFormatSeed = 20240621;
inline constexpr VkExtent3D kExtent{21, 19, 1};  // no multiple of any block
inline constexpr uint32_t kTexels = kExtent.width * kExtent.height;

// Formats of colour planes need a conversion: their tests are elsewhere.
inline bool is_ycbcr(const FormatInfo& format) { return format.plane_count() > 1 && !format.is_depth_or_stencil(); }

inline uint32_t blocks(uint32_t texels, uint32_t size) { return (texels + size - 1) / size; }

// One aspect of a format: what is uploaded, and what a shader sees of it.
struct Aspect {
  const FormatInfo* stored;  // blocks or texels
  const FormatInfo* shown;   // plain
  VkImageAspectFlags aspect;
};

inline std::vector<Aspect> aspects_of(const FormatInfo& format) {
  if (format.is_compressed()) return {{&format, find_format(format.decoded), VK_IMAGE_ASPECT_COLOR_BIT}};
  std::vector<Aspect> out;
  for (const VkImageAspectFlags aspect : {VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_ASPECT_STENCIL_BIT}) {
    const FormatInfo* plane = find_format(aspect_format(format.format, aspect));
    if (plane && plane->is_plain()) out.push_back({plane, plane, aspect});
  }
  return out;
}

inline std::vector<uint8_t> random_data(const FormatInfo& stored) {
  std::mt19937 random(kFormatSeed + stored.format);
  std::vector<uint8_t> data(size_t{blocks(kExtent.width, stored.block_width)} * blocks(kExtent.height, stored.block_height) *
                            stored.texel_bytes);
  for (uint8_t& byte : data) byte = static_cast<uint8_t>(random());
  return data;
}

// All texels of what is shown, without gaps.
inline std::vector<uint8_t> decode(const Aspect& aspect, const std::vector<uint8_t>& data) {
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
inline bool equal(const FormatInfo& shown, const VkClearColorValue& got, const VkClearColorValue& want, uint32_t components = 4) {
  for (uint32_t c = 0; c < components; ++c) {
    const bool both_nan = !shown.is_integer() && std::isnan(got.float32[c]) && std::isnan(want.float32[c]);
    if (got.uint32[c] != want.uint32[c] && !both_nan) return false;
  }
  return true;
}

}  // namespace pineda::test
