// Block decoders. The bit-exact formats against what other implementations decode (tests/block_vectors/make.cpp tells which and
// how); BC1 to BC5 against the specification's real-number formulas. Any bytes decode without leaving the block.
#include "base/block_codec.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/paths.h"

namespace pineda {
namespace {

constexpr uint32_t kSeed = 20240617;

std::vector<uint8_t> decode(const FormatInfo& format, const uint8_t* block) {
  std::vector<uint8_t> texels(size_t{format.block_width} * format.block_height * texel_bytes(format.decoded));
  block_decoder(format)(format, block, texels.data());
  return texels;
}

uint64_t hash(const std::vector<uint8_t>& bytes) {  // FNV-1a
  uint64_t h = 0xcbf29ce484222325u;
  for (const uint8_t b : bytes) h = (h ^ b) * 0x100000001b3u;
  return h;
}

bool is_astc(const FormatInfo& format) {
  return block_decoder(format) == block_decoder(*find_format(VK_FORMAT_ASTC_4x4_UNORM_BLOCK));
}

TEST(BlockCodec, AgreesWithOtherDecodersBitForBit) {
  std::map<std::string, const FormatInfo*> formats;
  for (const FormatInfo& format : all_formats()) formats[format.name] = &format;
  std::ifstream file(tests::source_dir() + "/tests/block_vectors/blocks.txt");
  std::map<std::string, int> tested, failed;
  for (std::string name, block_text, hash_text; file >> name >> block_text >> hash_text;) {
    const FormatInfo& format = *formats.at(name);
    uint8_t block[16] = {};
    for (size_t i = 0; i < block_text.size() / 2; ++i) {
      block[i] = static_cast<uint8_t>(std::stoul(block_text.substr(2 * i, 2), nullptr, 16));
    }
    ++tested[name];
    std::vector<uint8_t> texels = decode(format, block);
    if (is_astc(format) && format.decoded == VK_FORMAT_R8G8B8A8_SRGB) {  // without alpha: make.cpp tells why
      for (size_t i = 3; i < texels.size(); i += 4) texels[i] = 0;
    }
    const bool equal = hash(texels) == std::stoull(hash_text, nullptr, 16);
    if (!equal && failed[name]++ < 3) ADD_FAILURE() << name << " " << block_text;
  }
  for (const FormatInfo& format : all_formats()) {
    // The sRGB formats of BC7 and ETC2 share the decoder, and BC1 to BC5 have formulas.
    if (!format.is_compressed() || format.format < VK_FORMAT_BC6H_UFLOAT_BLOCK) continue;
    if (!is_astc(format) && format.decoded == VK_FORMAT_R8G8B8A8_SRGB) continue;
    if (format.decoded == VK_FORMAT_R16_SNORM || format.decoded == VK_FORMAT_R16G16_SNORM) continue;
    EXPECT_GE(tested[format.name], 48) << format.name;
  }
  for (const auto& [name, count] : failed) {
    if (count) std::printf("%s: %d of %d differ\n", name.c_str(), count, tested[name]);
  }
}

// The colours of a BC1 block as real numbers.
std::array<double, 3> s3tc_color(const uint8_t* block, uint32_t texel, bool three_colors, bool* black) {
  const uint32_t c[2] = {block[0] | block[1] * 256u, block[2] | block[3] * 256u};
  const uint32_t code = block[4 + texel / 4] >> 2 * (texel % 4) & 3;
  double weight1[4] = {0, 1, 1 / 3.0, 2 / 3.0};
  *black = false;
  if (three_colors && c[0] <= c[1]) {
    weight1[2] = 0.5;
    *black = code == 3;
  }
  const auto mix = [&](int shift, int largest) {
    const double a = (c[0] >> shift & largest) / double(largest), b = (c[1] >> shift & largest) / double(largest);
    return *black ? 0.0 : a * (1 - weight1[code]) + b * weight1[code];
  };
  return {mix(11, 31), mix(5, 63), mix(0, 31)};
}

double rgtc_value(const uint8_t* block, uint32_t texel, bool is_signed) {
  uint64_t bits = 0;
  for (int i = 0; i < 6; ++i) bits |= uint64_t{block[2 + i]} << 8 * i;
  const uint32_t code = bits >> 3 * texel & 7;
  const int red[2] = {is_signed ? static_cast<int8_t>(block[0]) : block[0], is_signed ? static_cast<int8_t>(block[1]) : block[1]};
  const double scale = is_signed ? 127 : 255;
  const double v0 = std::max(red[0] / scale, -1.0), v1 = std::max(red[1] / scale, -1.0);
  if (code == 0) return v0;
  if (code == 1) return v1;
  if (red[0] > red[1]) return ((8 - code) * v0 + (code - 1.0) * v1) / 7;
  if (code == 6) return is_signed ? -1 : 0;
  if (code == 7) return 1;
  return ((6 - code) * v0 + (code - 1.0) * v1) / 5;
}

// The nearest code: half a code, and what doubles round.
constexpr double kHalf = 0.5 + 1e-9;

void test_color(VkFormat format_name, uint32_t offset, bool three_colors,
                const std::function<double(const uint8_t*, uint32_t)>& alpha) {
  const FormatInfo& format = *find_format(format_name);
  std::mt19937 random(kSeed + format_name);
  for (int i = 0; i < 4000; ++i) {
    uint8_t block[16];
    for (uint8_t& b : block) b = static_cast<uint8_t>(random());
    const std::vector<uint8_t> texels = decode(format, block);
    for (uint32_t t = 0; t < 16; ++t) {
      bool black = false;
      const auto want = s3tc_color(block + offset, t, three_colors, &black);
      for (uint32_t c = 0; c < 3; ++c) ASSERT_LE(std::fabs(texels[4 * t + c] - 255 * want[c]), kHalf) << format.name;
      const double a = alpha ? alpha(block, t) : black && format_name == VK_FORMAT_BC1_RGBA_UNORM_BLOCK ? 0 : 1;
      ASSERT_LE(std::fabs(texels[4 * t + 3] - 255 * a), kHalf) << format.name;
    }
  }
}

TEST(BlockCodec, S3tcIsTheNearestCode) {
  test_color(VK_FORMAT_BC1_RGB_UNORM_BLOCK, 0, true, {});
  test_color(VK_FORMAT_BC1_RGBA_UNORM_BLOCK, 0, true, {});
  test_color(VK_FORMAT_BC2_UNORM_BLOCK, 8, false,
             [](const uint8_t* block, uint32_t t) { return (block[t / 2] >> 4 * (t % 2) & 15) / 15.0; });
  test_color(VK_FORMAT_BC3_UNORM_BLOCK, 8, false, [](const uint8_t* block, uint32_t t) { return rgtc_value(block, t, false); });
}

TEST(BlockCodec, RgtcIsTheNearestCode) {
  std::mt19937 random(kSeed);
  for (const VkFormat f :
       {VK_FORMAT_BC4_UNORM_BLOCK, VK_FORMAT_BC4_SNORM_BLOCK, VK_FORMAT_BC5_UNORM_BLOCK, VK_FORMAT_BC5_SNORM_BLOCK}) {
    const FormatInfo& format = *find_format(f);
    const bool is_signed = f == VK_FORMAT_BC4_SNORM_BLOCK || f == VK_FORMAT_BC5_SNORM_BLOCK;
    const uint32_t channels = format.texel_bytes / 8;
    for (int i = 0; i < 4000; ++i) {
      uint8_t block[16];
      for (uint8_t& b : block) b = static_cast<uint8_t>(random());
      const std::vector<uint8_t> texels = decode(format, block);
      for (uint32_t t = 0; t < 16; ++t) {
        for (uint32_t c = 0; c < channels; ++c) {
          const uint8_t* code = &texels[(t * channels + c) * 2];
          const auto raw = static_cast<uint16_t>(code[0] | code[1] << 8);
          const double got = is_signed ? static_cast<int16_t>(raw) : raw, scale = is_signed ? 32767 : 65535;
          ASSERT_LE(std::fabs(got - scale * rgtc_value(block + 8 * c, t, is_signed)), kHalf) << format.name;
        }
      }
    }
  }
}

// "Signed R11 EAC start" and "Unsigned R11 EAC start", as real numbers. Widening 11 bits to 16 by replication loses less than a
// code.
TEST(BlockCodec, EacIsItsFormula) {
  constexpr int kModifiers[3][8] = {{-3, -6, -9, -15, 2, 5, 8, 14}, {-1, -2, -3, -10, 0, 1, 2, 9}, {-3, -5, -7, -9, 2, 4, 6, 8}};
  constexpr int kTable[3] = {0, 13, 15};
  std::mt19937 random(kSeed);
  for (const VkFormat f : {VK_FORMAT_EAC_R11_UNORM_BLOCK, VK_FORMAT_EAC_R11_SNORM_BLOCK}) {
    const bool is_signed = f == VK_FORMAT_EAC_R11_SNORM_BLOCK;
    for (int i = 0; i < 3000; ++i) {
      uint8_t block[8];
      for (uint8_t& b : block) b = static_cast<uint8_t>(random());
      block[1] = static_cast<uint8_t>((block[1] & 0xf0) | kTable[i % 3]);
      const double multiplier = block[1] >> 4 ? block[1] >> 4 : 1 / 8.0;
      const double base = is_signed ? std::max<double>(static_cast<int8_t>(block[0]), -127) : block[0] + 0.5;
      const double one = is_signed ? 127.875 : 255.875;
      uint64_t bits = 0;
      for (int k = 2; k < 8; ++k) bits = bits << 8 | block[k];
      const std::vector<uint8_t> texels = decode(*find_format(f), block);
      for (int pixel = 0; pixel < 16; ++pixel) {
        const int modifier = kModifiers[i % 3][bits >> (45 - 3 * pixel) & 7], texel = pixel % 4 * 4 + pixel / 4;
        const double want = std::clamp((base + modifier * multiplier) / one, is_signed ? -1.0 : 0.0, 1.0);
        const auto raw = static_cast<uint16_t>(texels[2 * texel] | texels[2 * texel + 1] << 8);
        const double got = is_signed ? static_cast<int16_t>(raw) : raw;
        ASSERT_LT(std::fabs(got - want * (is_signed ? 32767 : 65535)), 1.0);
      }
    }
  }
}

TEST(BlockCodec, AnyBytesDecodeInsideTheBlock) {
  std::mt19937 random(kSeed);
  for (const FormatInfo& format : all_formats()) {
    if (!format.is_compressed()) continue;
    const size_t bytes = size_t{format.block_width} * format.block_height * texel_bytes(format.decoded);
    std::vector<uint8_t> texels(bytes + 16);
    for (int i = 0; i < 3000; ++i) {
      uint8_t block[16];
      for (uint8_t& b : block) b = static_cast<uint8_t>(random());
      std::fill(texels.begin(), texels.end(), uint8_t{0xA5});
      block_decoder(format)(format, block, texels.data());
      for (size_t k = bytes; k < texels.size(); ++k) ASSERT_EQ(texels[k], 0xA5) << format.name;
    }
  }
}

}  // namespace
}  // namespace pineda
