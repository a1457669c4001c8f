// An RGBA8 picture in host memory: PNG files, hash, mipmaps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pineda::tools {

struct Image {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba;  // rows top to bottom, no padding

  const uint8_t* pixel(uint32_t x, uint32_t y) const { return &rgba[4 * (size_t{y} * width + x)]; }
  uint8_t* pixel(uint32_t x, uint32_t y) { return &rgba[4 * (size_t{y} * width + x)]; }
};

void save_png(const std::string& path, const Image& image);  // throws ToolError
Image load_image(const std::string& path);                   // throws ToolError; PNG, JPEG, TGA, BMP, ...
Image decode_image(const uint8_t* bytes, size_t size_bytes, const std::string& name);  // the same from memory

// XXH64 of the pixels, seed 0, as 16 hexadecimal digits. The golden hashes under tests/golden are made of it.
std::string hash_of(const Image& image);

// All levels of the mip chain, the picture itself first. Each level is the area average of the one before, in integers only, so
// that textures are the same on every machine; sizes that are no power of two are weighted exactly.
std::vector<Image> make_mip_chain(Image base);

}  // namespace pineda::tools
