// Unpacking against the specification's formulas, exhaustively for components of up to 16 bits; packing against
// base/format_pack.cpp.
#include "compiler/kernels/texel.h"

#include <bit>
#include <cmath>

#include "compiler/kernels/test_rig.h"

namespace pineda::kernels::test {
namespace {

using ir::Builder;
using ir::Value;

uint32_t words_of(const FormatInfo& format) { return word_count(format); }

ArrayKernel unpacker(const FormatInfo& format) {
  return ArrayKernel(words_of(format), [&](Builder& b, const std::vector<Value>& in) {
    Words words{};
    for (size_t w = 0; w < in.size(); ++w) words[w] = in[w];
    const Channels out = unpack(b, format, words);
    return std::vector<Value>(out.begin(), out.end());
  });
}

ArrayKernel packer(const FormatInfo& format) {
  return ArrayKernel(4, [&](Builder& b, const std::vector<Value>& in) {
    Channels values;
    for (uint32_t c = 0; c < 4; ++c) values[c] = b.bitcast(channel_type(format), in[c]);
    const Words words = pack(b, format, values);
    return std::vector<Value>(words.begin(), words.begin() + words_of(format));
  });
}

// 65536 texels in which every component takes each of its codes (of 16 bits or fewer), and 4096 random ones.
std::vector<std::vector<uint32_t>> texels(const FormatInfo& format) {
  std::mt19937 random(kSeed);
  std::vector<std::vector<uint32_t>> words(words_of(format));
  for (uint32_t i = 0; i < 0x11000; ++i) {
    uint32_t texel[4] = {};
    for (uint32_t c = 0; c < 4; ++c) {
      const ComponentBits where = format.component[c];
      if (where.bits == 0) continue;
      uint32_t code = i < 0x10000 && where.bits <= 16 ? i * (2 * c + 1) : static_cast<uint32_t>(random());
      if (where.bits < 32) code &= (1u << where.bits) - 1;
      texel[where.first_bit / 32] |= code << where.first_bit % 32;
    }
    if (format.numeric == Numeric::kSharedExp) texel[0] |= i << 27;
    for (size_t w = 0; w < words.size(); ++w) words[w].push_back(texel[w]);
  }
  return words;
}

TEST(Texel, UnpacksEveryFormat) {
  for (const FormatInfo* format : all_formats()) {
    const auto words = texels(*format);
    const auto values = unpacker(*format)(words);
    for (size_t i = 0; i < words[0].size(); ++i) {
      uint32_t texel[4] = {};
      for (size_t w = 0; w < words.size(); ++w) texel[w] = words[w][i];
      const VkClearColorValue host = unpack_texel(*format, reinterpret_cast<const uint8_t*>(texel));
      for (uint32_t c = 0; c < 4; ++c) {
        if (!std::isnan(host.float32[c])) {
          ASSERT_EQ(values[c][i], host.uint32[c]) << format->name << " on the host";
        }
        const double want = decode_texel(*format, c, reinterpret_cast<const uint8_t*>(texel));
        if (format->is_integer()) {
          ASSERT_EQ(values[c][i], static_cast<uint32_t>(static_cast<int64_t>(want))) << format->name;
        } else if (std::isnan(want)) {
          ASSERT_TRUE(std::isnan(std::bit_cast<float>(values[c][i]))) << format->name;
        } else {  // correctly rounded
          ASSERT_EQ(std::bit_cast<float>(values[c][i]), static_cast<float>(want))
              << format->name << " component " << c << " texel " << i;
        }
      }
    }
  }
}

// Values around every code boundary of small components, special values, random bits.
std::vector<float> floats_to_pack(const FormatInfo& format) {
  std::vector<float> x{0.0f,      -0.0f, 1.0f,   -1.0f,    2.0f,     -3.0f,    INFINITY,
                       -INFINITY, NAN,   1e-40f, 65504.0f, 65519.0f, 65520.0f, 1e30f};
  const double scale = code_scale(format, 0);
  for (int code = 0; code <= std::min(scale, 1100.0); ++code) {
    const float middle = static_cast<float>((code + 0.5) / scale);
    for (const float v : {middle, std::nextafter(middle, 0.0f), std::nextafter(middle, 2.0f), static_cast<float>(code / scale)}) {
      x.push_back(v);
      x.push_back(-v);
    }
  }
  std::mt19937 random(kSeed);
  for (int i = 0; i < 20000; ++i) x.push_back(std::bit_cast<float>(static_cast<uint32_t>(random())));
  for (int i = 0; i < 20000; ++i) x.push_back(static_cast<float>(random() / 0x1p31 - 1));
  return x;
}

TEST(Texel, PacksAsTheHostDoes) {
  for (const FormatInfo* format : all_formats()) {
    if (format->is_depth() || format->is_scaled()) continue;
    const std::vector<float> x = floats_to_pack(*format);
    std::vector<std::vector<uint32_t>> in(4);
    for (size_t i = 0; i < x.size(); ++i) {
      for (uint32_t c = 0; c < 4; ++c) in[c].push_back(std::bit_cast<uint32_t>(x[(i + c * 977) % x.size()]));
    }
    const auto words = packer(*format)(in);
    for (size_t i = 0; i < x.size(); ++i) {
      VkClearColorValue color;
      for (uint32_t c = 0; c < 4; ++c) color.uint32[c] = in[c][i];
      uint8_t want[16] = {};
      pack_clear_color(*format, color, want);
      uint32_t got[4] = {};
      for (size_t w = 0; w < words.size(); ++w) got[w] = words[w][i];
      ASSERT_EQ(std::memcmp(got, want, format->texel_bytes), 0)
          << format->name << " from " << color.float32[0] << ", " << color.float32[1] << ", " << color.float32[2] << ", "
          << color.float32[3];
    }
  }
}

TEST(Texel, HostRoundsToNearest) {
  std::mt19937 random(kSeed);
  for (const FormatInfo* format : all_formats()) {
    if (format->is_integer() || format->is_depth() || format->is_scaled() || format->is_float()) continue;
    for (int i = 0; i < 2000; ++i) {
      VkClearColorValue color;
      for (float& v : color.float32) v = static_cast<float>(random() / 0x1p31 - 0.5);
      uint8_t texel[16] = {};
      pack_clear_color(*format, color, texel);
      for (uint32_t c = 0; c < 4; ++c) {
        if (format->component[c].bits == 0) continue;
        const double low = format->numeric == Numeric::kSnorm ? -1 : 0;
        const double want = std::min(std::max<double>(color.float32[c], low), 1.0);
        const uint32_t code = code_of(*format, c, texel);
        const bool encoded = format->numeric == Numeric::kSrgb && c < 3;
        const double s = encoded ? (want <= 0.0031308 ? 12.92 * want : 1.055 * std::pow(want, 1 / 2.4) - 0.055) : want;
        const double stored = encoded ? code / 255.0 : decode_reference(*format, c, code);
        ASSERT_LE(std::fabs(stored - s) * code_scale(*format, c), 0.5 + 1e-6) << format->name << " " << color.float32[c];
      }
    }
  }
}

// Unsigned small floats: the nearest code, found by trying all of them.
TEST(Texel, HostRoundsSmallFloatsToNearest) {
  const FormatInfo& format = *find_format(VK_FORMAT_B10G11R11_UFLOAT_PACK32);
  std::mt19937 random(kSeed);
  for (const uint32_t c : {0u, 2u}) {
    const uint32_t codes = 31u << (format.component[c].bits - 5);  // finite ones
    for (int i = 0; i < 3000; ++i) {
      VkClearColorValue color{};
      color.float32[c] = static_cast<float>(std::exp2(random() / 0x1p32 * 40 - 22));
      uint8_t texel[4];
      pack_clear_color(format, color, texel);
      const uint32_t code = code_of(format, c, texel);
      ASSERT_LT(code, codes);
      const auto error = [&](uint32_t k) { return std::fabs(decode_reference(format, c, k) - color.float32[c]); };
      ASSERT_TRUE(code == 0 || error(code) <= error(code - 1)) << color.float32[c];
      ASSERT_TRUE(code + 1 == codes || error(code) <= error(code + 1)) << color.float32[c];
    }
  }
}

// Section "RGB to Shared Exponent Conversion", in double.
TEST(Texel, HostSharesTheSpecifiedExponent) {
  const FormatInfo& format = *find_format(VK_FORMAT_E5B9G9R9_UFLOAT_PACK32);
  std::mt19937 random(kSeed);
  for (int i = 0; i < 20000; ++i) {
    VkClearColorValue color{};
    for (float& v : color.float32) v = static_cast<float>(std::exp2(random() / 0x1p32 * 40 - 22));
    double clamped[3], largest = 0;
    for (int c = 0; c < 3; ++c) largest = std::max(largest, clamped[c] = std::min<double>(color.float32[c], 65408));
    int exponent = std::max(-16, std::ilogb(largest)) + 1 + 15;
    if (std::floor(largest / std::exp2(exponent - 24) + 0.5) == 512) ++exponent;
    uint8_t texel[4];
    pack_clear_color(format, color, texel);
    for (uint32_t c = 0; c < 3; ++c) {
      ASSERT_EQ(code_of(format, c, texel), std::floor(clamped[c] / std::exp2(exponent - 24) + 0.5));
    }
    ASSERT_EQ(texel[3] >> 3, exponent);
  }
}

TEST(Texel, UnpackThenPackIsIdentity) {
  for (const FormatInfo* format : all_formats()) {
    if (format->is_depth() || format->is_scaled()) continue;
    const auto words = texels(*format);
    const auto again = packer(*format)(unpacker(*format)(words));
    for (size_t i = 0; i < words[0].size(); ++i) {
      for (uint32_t c = 0; c < 4; ++c) {
        uint32_t before[4] = {}, after[4] = {};
        for (size_t w = 0; w < words.size(); ++w) before[w] = words[w][i], after[w] = again[w][i];
        const uint32_t code = code_of(*format, c, reinterpret_cast<const uint8_t*>(before));
        const uint32_t bits = format->component[c].bits;
        if (format->numeric == Numeric::kSnorm && bits != 0 && code == 1u << (bits - 1)) continue;  // a second code of -1
        if (format->is_float() && std::isnan(decode_reference(*format, c, code))) continue;
        if (format->numeric == Numeric::kSharedExp) {  // many codes of one value
          ASSERT_EQ(decode_texel(*format, c, reinterpret_cast<const uint8_t*>(after)),
                    decode_texel(*format, c, reinterpret_cast<const uint8_t*>(before)));
          continue;
        }
        ASSERT_EQ(code_of(*format, c, reinterpret_cast<const uint8_t*>(after)), code) << format->name << " component " << c;
      }
    }
  }
}

}  // namespace
}  // namespace pineda::kernels::test
