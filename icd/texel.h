// Decoding one texel on the host, for blits; base/format.h's pack_clear_color is the way back.
#pragma once

#include "base/format.h"

namespace pineda::icd {

// Components as float32, or for integer formats int32/uint32. Absent ones are 0, alpha 1. Depth is in the first.
VkClearColorValue unpack_texel(const FormatInfo& format, const uint8_t* texel);

}  // namespace pineda::icd
