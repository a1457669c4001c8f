#include "base/format.h"

#include <algorithm>

namespace pineda {
namespace {

constexpr uint16_t S = kUseSampled, L = kUseLinear, C = kUseColor, B = kUseBlend, D = kUseDepth, V = kUseVertex;

constexpr FormatInfo kFormats[] = {
#define PINEDA_FORMAT(name, bytes, numeric, r, g, b, a, uses) \
  {VK_FORMAT_##name, #name, bytes, Numeric::k##numeric, {{r, g, b, a}}, uses},
#include "base/formats.inc"
#undef PINEDA_FORMAT
};

constexpr int kCoreFormats = VK_FORMAT_ASTC_12x12_SRGB_BLOCK + 1;

// Row of kFormats for each core VkFormat, -1 where there is none.
constexpr auto kRows = [] {
  std::array<int16_t, kCoreFormats> rows{};
  rows.fill(-1);
  for (size_t i = 0; i < std::size(kFormats); ++i) rows[kFormats[i].format] = static_cast<int16_t>(i);
  return rows;
}();

}  // namespace

const FormatInfo* find_format(VkFormat format) {
  if (format < 0 || format >= kCoreFormats || kRows[format] < 0) return nullptr;
  return &kFormats[kRows[format]];
}

}  // namespace pineda
