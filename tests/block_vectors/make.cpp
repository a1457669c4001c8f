// Makes tests/block_vectors/blocks.txt: for each bit-exact block format, blocks and a hash of what they decode to, as other
// implementations tell. Not part of the build; how it was run (Debian 12, packages libastcenc-dev and chromium):
//
//   g++ -std=c++23 -O1 -I. -Itests -DPINEDA_BUILD_DIR='"."' tests/block_vectors/make.cpp build/libpineda_base.a -lgtest -lastcenc
//   ln -sf /usr/lib/x86_64-linux-gnu/libvulkan_lvp.so libvk_pineda.so;  ./a.out bc > a.txt    (Mesa 22.3.6)
//   ln -sf /usr/lib/chromium/libvk_swiftshader.so libvk_pineda.so;      ./a.out bc > b.txt    (Chromium 156); equal to a.txt
//                                                                       ./a.out etc > c.txt
//   ./a.out astc > d.txt                                                                      (astcenc 4.2.0)
//   cat a.txt c.txt d.txt > tests/block_vectors/blocks.txt
//
// BC1 to BC5 are not bit-exact: their oracle is the specification's formula, in base/block_codec_test.cpp; signed EAC has its
// formula there too.
extern "C" {  // how Debian builds the library
#include <astcenc.h>
}

#include <cmath>
#include <cstdio>
#include <random>

#include "base/format.h"
#include "base/half.h"
#include "icd_client.h"

namespace pineda::test {
namespace {

uint64_t hash(const std::vector<uint8_t>& bytes) {  // FNV-1a
  uint64_t h = 0xcbf29ce484222325u;
  for (const uint8_t b : bytes) h = (h ^ b) * 0x100000001b3u;
  return h;
}

void print(const FormatInfo& format, const uint8_t* block, const std::vector<uint8_t>& decoded) {
  std::printf("%s ", format.name);
  for (int i = 0; i < format.texel_bytes; ++i) std::printf("%02x", block[i]);
  std::printf(" %016llx\n", static_cast<unsigned long long>(hash(decoded)));
}

// Random blocks that go through every mode.
std::vector<uint8_t> random_blocks(const FormatInfo& format, uint32_t count) {
  std::mt19937 random(format.format);
  std::vector<uint8_t> blocks(size_t(count) * format.texel_bytes);
  for (uint8_t& b : blocks) b = static_cast<uint8_t>(random());
  for (uint32_t i = 0; i < count; ++i) {
    uint8_t* block = &blocks[size_t(i) * format.texel_bytes];
    if (format.format == VK_FORMAT_BC7_UNORM_BLOCK || format.format == VK_FORMAT_BC7_SRGB_BLOCK) {
      const uint32_t mode = i % 8;
      block[0] = static_cast<uint8_t>((block[0] & ~((2u << mode) - 1)) | 1u << mode);
    } else if (format.decoded == VK_FORMAT_R16G16B16A16_SFLOAT) {
      constexpr uint8_t kModes[14] = {0, 1, 2, 6, 10, 14, 18, 22, 26, 30, 3, 7, 11, 15};
      const uint8_t mode = kModes[i % 14];
      block[0] = static_cast<uint8_t>(mode < 2 ? (block[0] & ~3) | mode : (block[0] & ~31) | mode);
    }
  }
  return blocks;
}

// As RGBA floats, by way of a blit: SwiftShader decodes for it.
std::vector<float> fetch(Client& client, const FormatInfo& format, const std::vector<uint8_t>& blocks, uint32_t count) {
  const VkExtent3D extent{count * format.block_width, format.block_height, 1};
  const VkImage image = client.image(format.format, extent, 1, 1, VK_IMAGE_USAGE_SAMPLED_BIT);
  const VkImage wide = client.image(VK_FORMAT_R32G32B32A32_SFLOAT, extent, 1, 1, VK_IMAGE_USAGE_SAMPLED_BIT);
  const auto in = client.buffer(blocks.size()), out = client.buffer(size_t(extent.width) * extent.height * 16);
  std::memcpy(in.data, blocks.data(), blocks.size());
  client.run([&](VkCommandBuffer cb) {
    const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, extent};
    VK(client, CmdCopyBufferToImage)(cb, in.handle, image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    const VkOffset3D end{int32_t(extent.width), int32_t(extent.height), 1};
    const VkImageBlit blit{color_layers(), {{}, end}, color_layers(), {{}, end}};
    VK(client, CmdBlitImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, wide, VK_IMAGE_LAYOUT_GENERAL, 1, &blit, VK_FILTER_NEAREST);
    VK(client, CmdCopyImageToBuffer)(cb, wide, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
  });
  const float* texels = out.as<float>();
  return {texels, texels + size_t(extent.width) * extent.height * 4};
}

// The float as a code of the decoded format.
void append_code(const FormatInfo& format, float value, std::vector<uint8_t>& out) {
  uint16_t code = 0;
  switch (format.decoded) {
    case VK_FORMAT_R8G8B8A8_UNORM:
      out.push_back(static_cast<uint8_t>(std::lround(value * 255)));
      return;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
      code = float_to_half(value);
      break;
    default: {  // EAC: SwiftShader widens 11 bits to 16 with zeros, the specification by replication
      const long x = std::lround(value * 65535) >> 5;
      code = static_cast<uint16_t>((x << 5) + (x >> 6));
      break;
    }
  }
  out.push_back(static_cast<uint8_t>(code));
  out.push_back(static_cast<uint8_t>(code >> 8));
}

void from_driver(VkFormat first, VkFormat last, uint32_t count) {
  Client client;
  for (const FormatInfo& format : all_formats()) {
    if (format.format < first || format.format > last || format.decoded == VK_FORMAT_R8G8B8A8_SRGB) continue;
    if (format.decoded == VK_FORMAT_R16_SNORM || format.decoded == VK_FORMAT_R16G16_SNORM) continue;  // SwiftShader adds 4
    const std::vector<uint8_t> blocks = random_blocks(format, count);
    const std::vector<float> texels = fetch(client, format, blocks, count);
    const uint32_t components = format.decoded == VK_FORMAT_R16_UNORM ? 1 : format.decoded == VK_FORMAT_R16G16_UNORM ? 2 : 4;
    for (uint32_t i = 0; i < count; ++i) {
      std::vector<uint8_t> decoded;
      for (uint32_t y = 0; y < 4; ++y) {
        for (uint32_t x = 0; x < 4; ++x) {
          for (uint32_t c = 0; c < components; ++c) append_code(format, texels[((y * count + i) * 4 + x) * 4 + c], decoded);
        }
      }
      print(format, &blocks[size_t(i) * format.texel_bytes], decoded);
    }
  }
}

class AstcDecoder {
 public:
  explicit AstcDecoder(const FormatInfo& format) : format_(format), srgb_(format.decoded == VK_FORMAT_R8G8B8A8_SRGB) {
    astcenc_config config{};
    astcenc_config_init(srgb_ ? ASTCENC_PRF_LDR_SRGB : ASTCENC_PRF_LDR, format.block_width, format.block_height, 1,
                        ASTCENC_PRE_FASTEST, ASTCENC_FLG_DECOMPRESS_ONLY, &config);
    astcenc_context_alloc(&config, 1, &context_);
  }
  ~AstcDecoder() { astcenc_context_free(context_); }

  std::vector<uint8_t> operator()(const uint8_t* block) {
    std::vector<uint8_t> out(size_t(format_.block_width) * format_.block_height * (srgb_ ? 4 : 8));
    void* slice = out.data();
    astcenc_image image{format_.block_width, format_.block_height, 1, srgb_ ? ASTCENC_TYPE_U8 : ASTCENC_TYPE_F16, &slice};
    const astcenc_swizzle swizzle{ASTCENC_SWZ_R, ASTCENC_SWZ_G, ASTCENC_SWZ_B, ASTCENC_SWZ_A};
    astcenc_decompress_image(context_, block, 16, &image, &swizzle, 0);
    astcenc_decompress_reset(context_);
    normalize(out);
    return out;
  }

 private:
  // Where astcenc 4.2 is not what the specification says today: the error colour in linear formats is 1.0, not 0xff00 of 65536
  // (NaN is allowed too);
  // the alpha of sRGB formats is widened like a linear one (it is left out: the linear format has it).
  void normalize(std::vector<uint8_t>& texels) const {
    constexpr uint16_t kError[4] = {0x3bf8, 0, 0x3bf8, 0x3bf8}, kNan[4] = {0xffff, 0xffff, 0xffff, 0xffff},
                       kMagenta[4] = {0x3c00, 0, 0x3c00, 0x3c00};
    for (size_t i = 0; i < texels.size(); i += srgb_ ? 4 : 8) {
      if (srgb_) texels[i + 3] = 0;
      if (!srgb_ && (!std::memcmp(&texels[i], kError, 8) || !std::memcmp(&texels[i], kNan, 8)))
        std::memcpy(&texels[i], kMagenta, 8);
    }
  }

  const FormatInfo& format_;
  const bool srgb_;
  astcenc_context* context_ = nullptr;
};

bool is_error(const FormatInfo& format, const std::vector<uint8_t>& texels) {
  const std::vector<uint8_t> magenta = format.decoded == VK_FORMAT_R8G8B8A8_SRGB
                                           ? std::vector<uint8_t>{255, 0, 255, 0}
                                           : std::vector<uint8_t>{0, 0x3c, 0, 0, 0, 0x3c, 0, 0x3c};
  return std::equal(magenta.begin(), magenta.end(), texels.begin());
}

// Mostly legal blocks; every eighth may be anything.
void from_astcenc(uint32_t count) {
  for (const FormatInfo& format : all_formats()) {
    if (format.format < VK_FORMAT_ASTC_4x4_UNORM_BLOCK || format.format > VK_FORMAT_ASTC_12x12_SRGB_BLOCK) continue;
    std::mt19937 random(format.format);
    AstcDecoder decode(format);
    for (uint32_t i = 0; i < count;) {
      uint8_t block[16];
      for (uint8_t& b : block) b = static_cast<uint8_t>(random());
      if (i % 16 == 7) block[0] = 0xfc, block[1] = static_cast<uint8_t>((block[1] & 0xf0) | 0x0d);  // void extent
      const std::vector<uint8_t> decoded = decode(block);
      if (is_error(format, decoded) && i % 8 != 7) continue;
      print(format, block, decoded);
      ++i;
    }
  }
}

}  // namespace
}  // namespace pineda::test

int main(int, char** argv) {
  using namespace pineda::test;
  if (!std::strcmp(argv[1], "bc")) from_driver(VK_FORMAT_BC6H_UFLOAT_BLOCK, VK_FORMAT_BC7_UNORM_BLOCK, 112);
  if (!std::strcmp(argv[1], "etc")) from_driver(VK_FORMAT_ETC2_R8G8B8_UNORM_BLOCK, VK_FORMAT_EAC_R11G11_SNORM_BLOCK, 96);
  if (!std::strcmp(argv[1], "astc")) from_astcenc(48);
}
