#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "shaders/extreme_integers_comp.h"
#include "shaders/extreme_pack_comp.h"
#include "shaders/extreme_srgb_comp.h"
#include "shaders/extreme_undefined_comp.h"
#include "tools/error.h"
#include "tools/extreme/rig.h"

namespace pineda::tools {
namespace {

// ---- defined integers
// --------------------------------------------------------------------------------------------------------------

constexpr uint32_t kEnds[] = {0, 1, 2, 31, 32, 0x7FFFFFFF, 0x80000000, 0x80000001, 0xFFFFFFFF, 0x55555555, 16777217, 0xFFFFFF7F};

uint32_t as_word(int32_t value) { return static_cast<uint32_t>(value); }

int32_t signed_msb(int32_t value) { return 31 - std::countl_zero(as_word(value < 0 ? ~value : value)); }

// The operations of shaders/extreme_integers.comp, in its order.
std::vector<uint32_t> defined_results(uint32_t a, uint32_t b) {
  const auto sa = static_cast<int32_t>(a), sb = static_cast<int32_t>(b);
  uint32_t reversed = 0;
  for (int bit = 0; bit < 32; ++bit) reversed |= (a >> bit & 1) << (31 - bit);
  return {a + b,
          a - b,
          a * b,
          0u - a,
          sa < 0 ? 0u - a : a,
          as_word((sa > 0) - (sa < 0)),
          a + b + (uint64_t{a} + b > 0xFFFFFFFF),
          static_cast<uint32_t>(uint64_t{a} * b >> 32),
          static_cast<uint32_t>(static_cast<uint64_t>(int64_t{sa} * sb) >> 32),
          a ? as_word(31 - std::countl_zero(a)) : 0xFFFFFFFF,
          as_word(signed_msb(sa)),
          a ? as_word(std::countr_zero(a)) : 0xFFFFFFFF,
          as_word(std::popcount(a)),
          reversed,
          a >> (b & 31),
          as_word(sa >> (b & 31)),
          0,
          b,
          std::bit_cast<uint32_t>(static_cast<float>(sa)),
          std::bit_cast<uint32_t>(static_cast<float>(a))};
}

Outcome judge_words(const std::vector<uint32_t>& results, const std::vector<uint32_t>& wanted) {
  size_t differing = 0;
  for (size_t i = 0; i < wanted.size(); ++i) differing += results[i] != wanted[i];
  return {.verdict = differing ? Verdict::kWrong : Verdict::kExact,
          .measured = fmt::format("{} of {} results differ", differing, wanted.size()),
          .truth = "two's complement, nearest binary32",
          .bytes = bytes_of(results)};
}

Outcome integer_ends(ExtremeRig& rig) {
  std::vector<uint32_t> operands, wanted;
  for (const uint32_t a : kEnds) {
    for (const uint32_t b : kEnds) {
      operands.insert(operands.end(), {a, b});
      const std::vector<uint32_t> results = defined_results(a, b);
      wanted.insert(wanted.end(), results.begin(), results.end());
    }
  }
  return judge_words(
      rig.compute_as<uint32_t>(extreme_integers_comp, operands, wanted.size(), static_cast<uint32_t>(operands.size() / 2)),
      wanted);
}

// ---- what is undefined
// -------------------------------------------------------------------------------------------------------------

// Only the operands of one invocation in three are in question: the others, and the first result of all, must be right.
Outcome undefined(ExtremeRig& rig, std::span<const uint32_t> odd_a, std::span<const uint32_t> odd_b, size_t first, size_t last) {
  constexpr size_t kOperations = 10, kInvocations = 96;
  std::vector<uint32_t> operands;
  for (uint32_t i = 0; i < kInvocations; ++i) {
    const bool odd = i % 3 == 1;
    operands.push_back(odd ? odd_a[i % odd_a.size()] : std::bit_cast<uint32_t>(1000.5f + static_cast<float>(i)));
    operands.push_back(odd ? odd_b[i % odd_b.size()] : 1 + i % 31);
  }
  const std::vector<uint32_t> results =
      rig.compute_as<uint32_t>(extreme_undefined_comp, operands, kOperations * kInvocations, kInvocations / 16);
  size_t differing = 0;
  for (size_t i = 0; i < kInvocations; ++i) {
    const uint32_t a = operands[2 * i], b = operands[2 * i + 1];
    const uint32_t* const got = &results[kOperations * i];
    differing += got[0] != b * 3 + a;
    if (i % 3 == 1) continue;
    const float x = std::bit_cast<float>(a);
    const uint32_t wanted[] = {
        got[0], a / b, a % b, a / b, a % b, a << b, a >> b, a >> b, as_word(static_cast<int32_t>(x)), static_cast<uint32_t>(x)};
    for (size_t k = first; k <= last; ++k) differing += got[k] != wanted[k];
  }
  std::string shown;
  for (size_t k = first; k <= last; ++k) shown += fmt::format("{}{:#x}", shown.empty() ? "" : ", ", results[kOperations + k]);
  return {.verdict = differing ? Verdict::kWrong : Verdict::kWithin,
          .measured = fmt::format("{} other results differ; gives {}", differing, shown),
          .truth = "any value; what is defined beside it unchanged",
          .bound = "undefined in SPIR-V: no crash, other invocations and results right",
          .bytes = bytes_of(results)};
}

constexpr uint32_t kDividends[] = {0, 1, 0x80000000, 0xFFFFFFFF, 7}, kZero[] = {0}, kLeast[] = {0x80000000},
                   kMinusOne[] = {0xFFFFFFFF};
constexpr uint32_t kShifted[] = {0xDEADBEEF, 1, 0x80000000}, kFar[] = {32, 33, 63, 64, 0x80000000, 0xFFFFFFFF};

Outcome division_by_zero(ExtremeRig& rig) { return undefined(rig, kDividends, kZero, 1, 4); }
Outcome division_overflow(ExtremeRig& rig) { return undefined(rig, kLeast, kMinusOne, 3, 4); }
Outcome far_shifts(ExtremeRig& rig) { return undefined(rig, kShifted, kFar, 5, 7); }
Outcome float_to_int(ExtremeRig& rig) {
  const float odd[] = {2147483648.0f,
                       -2147483904.0f,
                       4294967296.0f,
                       -1,
                       1e30f,
                       std::numeric_limits<float>::infinity(),
                       std::numeric_limits<float>::quiet_NaN()};
  std::vector<uint32_t> bits;
  for (const float x : odd) bits.push_back(std::bit_cast<uint32_t>(x));
  constexpr uint32_t kOne[] = {1};
  return undefined(rig, bits, kOne, 8, 9);
}

// ---- packing
// -----------------------------------------------------------------------------------------------------------------------

double half_value(uint32_t bits) {
  const int exponent = static_cast<int>(bits >> 10 & 31);
  const double fraction = (bits & 1023) / 1024.0, sign = bits & 0x8000 ? -1 : 1;
  if (exponent == 31) return fraction == 0 ? sign * std::numeric_limits<double>::infinity() : std::nan("");
  return sign * (exponent == 0 ? std::ldexp(fraction, -14) : std::ldexp(1 + fraction, exponent - 15));
}

// The binary16 nearest to x, ties to even; NaN: 0x7E00.
uint32_t nearest_half(float x) {
  if (std::isnan(x)) return 0x7E00;
  const uint32_t sign = std::signbit(x) ? 0x8000 : 0;
  const double magnitude = std::abs(double{x});
  if (magnitude >= 65520) return sign | 0x7C00;
  uint32_t low = 0, high = 0x7BFF;  // the last one not above x
  while (low < high) {
    const uint32_t middle = (low + high + 1) / 2;
    (half_value(middle) <= magnitude ? low : high) = half_value(middle) <= magnitude ? middle : middle - 1;
  }
  const double below = magnitude - half_value(low), above = (low == 0x7BFF ? 65536 : half_value(low + 1)) - magnitude;
  return sign | (below < above || (below == above && low % 2 == 0) ? low : low + 1);
}

constexpr size_t kPackOperations = 9;

std::vector<float> pack_ends() {
  std::vector<float> values{0,
                            -0.0f,
                            0.5f,
                            1,
                            -1,
                            2,
                            -2,
                            1e30f,
                            -1e30f,
                            65504,
                            65519.996f,
                            65520,
                            65536,
                            -65520,
                            1e-8f,
                            0x1p-24f,
                            0x1p-25f,
                            0x1.000002p-25f,
                            0x1p-14f,
                            0x1.ffcp-15f,
                            std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(),
                            std::numeric_limits<float>::max(),
                            1e-45f};
  for (const float codes : {255.0f, 127.0f, 65535.0f, 32767.0f}) {
    for (const float code : {0.25f, 0.75f, 1.25f, 100.25f, 100.75f})
      values.push_back(code / codes), values.push_back(-code / codes);
    values.push_back((codes - 0.25f) / codes);
  }
  return values;
}

// Whether code is round(clamp(x) * scale), where a tie within binary32's rounding may go either way.
bool is_rounded(double code, double x, double low, double scale) {
  const double exact = std::clamp(std::isnan(x) ? 0 : x, low, 1.0) * scale;
  return std::abs(code - exact) <= 0.5 + scale * 0x1p-23;
}

Outcome packing(ExtremeRig& rig) {
  const std::vector<float> values = pack_ends();
  const std::vector<uint32_t> results =
      rig.compute_as<uint32_t>(extreme_pack_comp, values, kPackOperations * values.size(), static_cast<uint32_t>(values.size()));
  size_t differing = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const uint32_t* const got = &results[kPackOperations * i];
    const double x = values[i];
    differing += !is_rounded(got[0] & 0xFF, x, 0, 255);
    differing += !is_rounded(static_cast<int8_t>(got[1] & 0xFF), x, -1, 127);
    differing += !is_rounded(got[2] & 0xFFFF, x, 0, 65535);
    differing += !is_rounded(static_cast<int16_t>(got[3] & 0xFFFF), x, -1, 32767);
  }
  return {.verdict = differing ? Verdict::kWrong : Verdict::kExact,
          .measured = fmt::format("{} of {} results differ", differing, 4 * values.size()),
          .truth = "round(clamp(x) * (2^b - 1)), or 2^(b-1) - 1",
          .bytes = bytes_of(results)};
}

// Rounding is the implementation's choice between the neighbours; overflow may give infinity or the largest number.
Outcome half_overflow(ExtremeRig& rig) {
  const std::vector<float> values = pack_ends();
  const std::vector<uint32_t> results =
      rig.compute_as<uint32_t>(extreme_pack_comp, values, kPackOperations * values.size(), static_cast<uint32_t>(values.size()));
  size_t differing = 0, beyond = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const uint32_t got = results[kPackOperations * i + 4] & 0xFFFF, wanted = nearest_half(values[i]);
    differing += got != wanted;
    const bool denormal = std::abs(values[i]) < 0x1p-14f;  // may be flushed to zero
    beyond += (got ^ wanted) & 0x8000
                  ? true
                  : std::abs(int(got & 0x7FFF) - int(wanted & 0x7FFF)) > 1 && !(denormal && (got & 0x7FFF) == 0);
  }
  return {.verdict = beyond      ? Verdict::kWrong
                     : differing ? Verdict::kWithin
                                 : Verdict::kExact,
          .measured = fmt::format("{} of {} results differ", differing, values.size()),
          .truth = "to nearest, ties to even; 65520 and more: infinity",
          .bound = "a neighbour; zero for denormals",
          .bytes = bytes_of(results)};
}

Outcome unpacking(ExtremeRig& rig) {  // every binary16; every 8-bit and 16-bit code
  std::vector<uint32_t> words(65536);
  for (uint32_t i = 0; i < words.size(); ++i) words[i] = i;
  const std::vector<uint32_t> results =
      rig.compute_as<uint32_t>(extreme_pack_comp, words, kPackOperations * words.size(), static_cast<uint32_t>(words.size()));
  size_t differing = 0, beyond = 0;
  for (const uint32_t word : words) {
    const uint32_t* const got = &results[kPackOperations * word];
    const auto check_one = [&](uint32_t bits, double truth) {
      const float value = std::bit_cast<float>(bits);
      if (std::isnan(truth) ? std::isnan(value) : value == static_cast<float>(truth)) return;
      ++differing;
      const bool denormal = std::abs(truth) < 0x1p-14;
      beyond += !(std::abs(value - truth) <= 4 * 0x1p-24 * std::abs(truth) || (denormal && value == 0));
    };
    check_one(got[5], (word & 255) / 255.0);
    check_one(got[6], std::max(static_cast<int8_t>(word & 255) / 127.0, -1.0));
    check_one(got[7], half_value(word));
    check_one(got[8], std::max(static_cast<int16_t>(word) / 32767.0, -1.0));
  }
  return {.verdict = beyond      ? Verdict::kWrong
                     : differing ? Verdict::kWithin
                                 : Verdict::kExact,
          .measured = fmt::format("{} of {} results differ", differing, 4 * words.size()),
          .truth = "code / (2^b - 1), max(code / (2^(b-1) - 1), -1), the binary16's value",
          .bound = "4 half ULP; zero for denormals",
          .bytes = bytes_of(results)};
}

// ---- attachments
// -------------------------------------------------------------------------------------------------------------------

// Each value goes to a pixel of its own, as a rectangle of one colour.
std::vector<std::byte> store(ExtremeRig& rig, VkFormat format, uint32_t bytes_per_pixel, const std::vector<float>& values) {
  RigDraw draw;
  const float count = static_cast<float>(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const float left = 2 * static_cast<float>(i) / count - 1, right = 2 * static_cast<float>(i + 1) / count - 1;
    const std::vector<RigVertex> pixel = rectangle(left, -1, right, 1, 0, {values[i], 0, 0, 1});
    draw.vertices.insert(draw.vertices.end(), pixel.begin(), pixel.end());
  }
  return rig.draw({.extent = {static_cast<uint32_t>(values.size()), 1}, .colour = format, .bytes_per_pixel = bytes_per_pixel},
                  std::span(&draw, 1));
}

Outcome attachment_ends(ExtremeRig& rig) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<float> values{-kInfinity, -1e30f, -1, -0.0f, 0,         0.25f / 255,  0.75f / 255,
                                  0.5f,       1,      2,  1e30f, kInfinity, 254.75f / 255};
  const std::vector<std::byte> unorm = store(rig, VK_FORMAT_R8G8B8A8_UNORM, 4, values);
  size_t differing = 0;
  std::string which;
  const auto take = [&](const char* format, int code, float value, double low, double largest_code) {
    if (is_rounded(code, value, low, largest_code)) return;
    ++differing;
    which += fmt::format("{} {:g} became {} in {}", which.empty() ? ":" : ";", value, code, format);
  };
  for (size_t i = 0; i < values.size(); ++i) take("UNORM", static_cast<uint8_t>(unorm[4 * i]), values[i], 0, 255);
  if (rig.has_format(VK_FORMAT_R8G8B8A8_SNORM, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT)) {
    const std::vector<std::byte> snorm = store(rig, VK_FORMAT_R8G8B8A8_SNORM, 4, values);
    for (size_t i = 0; i < values.size(); ++i) take("SNORM", static_cast<int8_t>(snorm[4 * i]), values[i], -1, 127);
  }
  return {.verdict = differing ? Verdict::kWrong : Verdict::kExact,
          .measured = fmt::format("{} codes differ{}", differing, which),
          .truth = "clamped, then to nearest",
          .bytes = bytes_of(unorm)};
}

Outcome attachment_half(ExtremeRig& rig) {
  const std::vector<float> values{65504,    65519.996f, 65520,     65536, 1e30f, -65520, std::numeric_limits<float>::infinity(),
                                  0x1p-24f, 0x1p-25f,   0x1.8p-24f};
  const std::vector<std::byte> bytes = store(rig, VK_FORMAT_R16G16B16A16_SFLOAT, 8, values);
  size_t differing = 0, beyond = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    uint16_t got;
    std::memcpy(&got, &bytes[8 * i], sizeof got);
    const uint32_t wanted = nearest_half(values[i]);
    differing += got != wanted;
    beyond += std::abs(int(got) - int(wanted)) > 1;
  }
  return {.verdict = beyond      ? Verdict::kWrong
                     : differing ? Verdict::kWithin
                                 : Verdict::kExact,
          .measured = fmt::format("{} of {} differ from the nearest", differing, values.size()),
          .truth = "to nearest; 65520 and more: infinity",
          .bound = "a neighbour (rounding toward zero is allowed)",
          .bytes = bytes_of(bytes)};
}

double linear_of(double code) {
  const double c = code / 255;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

Outcome srgb_decode(ExtremeRig& rig) {
  const Texture texture = create_texture(rig.context(), {.extent = {256, 1, 1}, .format = VK_FORMAT_R8G8B8A8_SRGB},
                                         [](const TexelPlace& place) { return place.x; });
  const SamplerHandle sampler = create_sampler(rig.context(), {});
  const RigTexture bound{texture, sampler};
  const std::vector<float> linear = rig.compute_as<float>(extreme_srgb_comp, std::vector<uint32_t>{0}, 256, 256, &bound);
  double worst = 0;
  bool exact = true;
  for (uint32_t code = 0; code < 256; ++code) {
    worst = std::max(worst, std::abs(linear[code] - linear_of(code)));
    exact &= linear[code] == static_cast<float>(linear_of(code));
  }
  // Half of the smallest distance of two codes: the inverse gives the code back.
  constexpr double kBound = 0.5 / 255 / 12.92;
  return {.verdict = !(worst <= kBound) ? Verdict::kWrong
                     : exact            ? Verdict::kExact
                                        : Verdict::kWithin,
          .measured = fmt::format("largest error {:.1e}", worst),
          .truth = "the sRGB EOTF, rounded to binary32",
          .bound = fmt::format("{:.1e}: half the distance of the two lowest codes", kBound),
          .bytes = bytes_of(linear)};
}

Outcome srgb_encode(ExtremeRig& rig) {
  std::vector<float> values{-1, 0, 1, 2, std::numeric_limits<float>::infinity(), 0.0031308f, 0.00313081f};
  std::vector<int> wanted{0, 0, 255, 255, 255, 10, 10};
  for (int code = 0; code < 256; ++code) values.push_back(static_cast<float>(linear_of(code))), wanted.push_back(code);
  const std::vector<std::byte> bytes = store(rig, VK_FORMAT_R8G8B8A8_SRGB, 4, values);
  size_t differing = 0;
  for (size_t i = 0; i < values.size(); ++i) differing += static_cast<int>(static_cast<uint8_t>(bytes[4 * i])) != wanted[i];
  return {.verdict = differing ? Verdict::kWrong : Verdict::kExact,
          .measured = fmt::format("{} of {} codes differ", differing, values.size()),
          .truth = "0 to 255 again, clamped at the ends",
          .bytes = bytes_of(bytes)};
}

constexpr const char* kSpirv =
    "SPIR-V 1.6, Arithmetic, Bit and Conversion Instructions; Vulkan 1.3, Precision of SPIR-V Instructions";
constexpr const char* kUndefined = "SPIR-V 1.6: the result is undefined; Vulkan 1.3, Robustness: nothing else may suffer";
constexpr const char* kPacking = "GLSL.std.450: PackUnorm4x8 and its relatives; Vulkan 1.3, Fixed-Point Data Conversions";
constexpr const char* kFixed = "Vulkan 1.3, Conversion From Floating-Point to Normalized Fixed-Point";
constexpr const char* kSmallFloats = "IEEE 754 binary16; Vulkan 1.3, 16-Bit Floating-Point Numbers";
constexpr const char* kSrgb = "Khronos Data Format 1.3, sRGB transfer functions";

constexpr ExtremeCase kCases[] = {
    {"integers", "ends of 32 bits", "20 operations on 144 pairs: wrapping, extended products, bit fields, findMSB, int to float",
     kSpirv, integer_ends},
    {"integers", "division by zero", "x / 0 and x mod 0, signed and not", kUndefined, division_by_zero},
    {"integers", "INT_MIN / -1", "The quotient that no int holds", kUndefined, division_overflow},
    {"integers", "shifts by 32 and more", "<<, >> of both kinds", kUndefined, far_shifts},
    {"integers", "float to int out of range", "2^31, -2^31 - 256, 2^32, -1 to uint, 1e30, infinity, NaN", kUndefined,
     float_to_int},
    {"integers", "packing at the ends", "packUnorm, packSnorm 4x8 and 2x16 of infinities, ends and near ties", kPacking, packing},
    {"integers", "binary16 overflow", "packHalf2x16 around 65504, 65520, 2^-14, 2^-25", kSmallFloats, half_overflow},
    {"integers", "unpacking every code", "unpackHalf2x16, unpackUnorm4x8, unpackSnorm of all 65,536 words", kPacking, unpacking},
    {"integers", "UNORM and SNORM attachments", "Infinities, ends and near ties", kFixed, attachment_ends},
    {"integers", "binary16 attachments", "Around 65504, 65520 and 2^-24", kSmallFloats, attachment_half},
    {"integers", "sRGB, reading", "All 256 codes", kSrgb, srgb_decode},
    {"integers", "sRGB, writing", "All 256 codes' values give their codes back", kSrgb, srgb_encode},
};

}  // namespace

std::span<const ExtremeCase> integer_cases() { return kCases; }

}  // namespace pineda::tools
