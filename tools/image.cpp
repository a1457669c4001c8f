#include "tools/image.h"

#include <algorithm>
#include <array>
#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_WRITE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "tools/error.h"

namespace pineda::tools {
namespace {

using StbPixels = std::unique_ptr<stbi_uc, void (*)(void*)>;

Image take(StbPixels pixels, int width, int height, const std::string& name) {
  if (!pixels) fail("{}: cannot be read as a picture ({})", name, stbi_failure_reason());
  Image image{.width = static_cast<uint32_t>(width), .height = static_cast<uint32_t>(height), .rgba = {}};
  image.rgba.assign(pixels.get(), pixels.get() + size_t{4} * image.width * image.height);
  return image;
}

// How one texel of a smaller row covers texels of the larger one, along one axis: of `larger` texels shared among `smaller`,
// texel i covers [i * larger, (i + 1) * larger) in units of 1 / smaller texel.
struct Footprint {
  uint32_t first = 0, count = 0;
  std::array<uint32_t, 4> weights{};  // sum to `larger`; halving covers at most 4 texels (a third, one, one, a third ...)
};

Footprint footprint_of(uint32_t i, uint32_t larger, uint32_t smaller) {
  const uint32_t begin = i * larger, end = begin + larger;
  Footprint footprint{.first = begin / smaller};
  for (uint32_t texel = footprint.first; texel * smaller < end; ++texel) {
    footprint.weights[footprint.count++] = std::min(end, (texel + 1) * smaller) - std::max(begin, texel * smaller);
  }
  return footprint;
}

Image half_size(const Image& source) {
  Image result{.width = std::max(1u, source.width / 2), .height = std::max(1u, source.height / 2), .rgba = {}};
  result.rgba.resize(size_t{4} * result.width * result.height);
  const uint64_t total_weight = uint64_t{source.width} * source.height;
  for (uint32_t y = 0; y < result.height; ++y) {
    const Footprint rows = footprint_of(y, source.height, result.height);
    for (uint32_t x = 0; x < result.width; ++x) {
      const Footprint columns = footprint_of(x, source.width, result.width);
      std::array<uint64_t, 4> sum{};
      for (uint32_t j = 0; j < rows.count; ++j) {
        for (uint32_t i = 0; i < columns.count; ++i) {
          const uint64_t weight = uint64_t{rows.weights[j]} * columns.weights[i];
          const uint8_t* texel = source.pixel(columns.first + i, rows.first + j);
          for (int channel = 0; channel < 4; ++channel) sum[channel] += weight * texel[channel];
        }
      }
      for (int channel = 0; channel < 4; ++channel) {
        result.pixel(x, y)[channel] = static_cast<uint8_t>((sum[channel] + total_weight / 2) / total_weight);
      }
    }
  }
  return result;
}

}  // namespace

void save_png(const std::string& path, const Image& image) {
  const int width = static_cast<int>(image.width), height = static_cast<int>(image.height);
  if (!stbi_write_png(path.c_str(), width, height, 4, image.rgba.data(), 4 * width)) fail("{}: cannot be written", path);
}

Image load_image(const std::string& path) {
  int width = 0, height = 0, channels = 0;
  StbPixels pixels(stbi_load(path.c_str(), &width, &height, &channels, 4), stbi_image_free);
  return take(std::move(pixels), width, height, path);
}

Image decode_image(const uint8_t* bytes, size_t size_bytes, const std::string& name) {
  int width = 0, height = 0, channels = 0;
  StbPixels pixels(stbi_load_from_memory(bytes, static_cast<int>(size_bytes), &width, &height, &channels, 4), stbi_image_free);
  return take(std::move(pixels), width, height, name);
}

std::string hash_of(const Image& image) { return fmt::format("{:016x}", XXH64(image.rgba.data(), image.rgba.size(), 0)); }

std::vector<Image> make_mip_chain(Image base) {
  std::vector<Image> levels{std::move(base)};
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(half_size(levels.back()));
  return levels;
}

}  // namespace pineda::tools
