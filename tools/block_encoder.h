// Pictures as blocks of compressed formats, for scenes and benchmark rows: simple encoders (one mode each, endpoints from the
// brightest and the darkest texel), with what the blocks decode to, so that a driver without the format can draw the same
// picture.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/image.h"

namespace pineda::tools {

enum class BlockFormat { kBc1, kBc7, kEtc2, kAstc4x4 };  // all of 4x4 texels, opaque, not sRGB

inline constexpr uint32_t kBlockSide = 4;

struct EncodedImage {
  std::vector<uint8_t> blocks;  // rows of blocks, without padding
  Image decoded;
};

uint32_t block_bytes(BlockFormat format);
EncodedImage encode_blocks(BlockFormat format, const Image& image);

}  // namespace pineda::tools
