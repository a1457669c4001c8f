// Decoders of block-compressed formats: one block to texels of FormatInfo::decoded, in exact integer arithmetic after the Khronos
// Data Format Specification (chapters "S3TC", "RGTC", "BPTC", "ETC1/ETC2" and "ASTC"). One definition, no tables of another
// library.
#pragma once

#include "base/format.h"

namespace pineda {

inline constexpr uint32_t kMaxBlockTexels = 12 * 12;
inline constexpr uint32_t kMaxBlockBytes = kMaxBlockTexels * 8;

// Writes block_width * block_height texels, row after row without gaps.
using BlockDecoder = void (*)(const FormatInfo& format, const uint8_t* block, uint8_t* texels);

// Null for formats without blocks.
BlockDecoder block_decoder(const FormatInfo& format);

}  // namespace pineda
