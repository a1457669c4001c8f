// Row-major memory <-> block-linear tiles, against base/abi.h's picture of a block.
#include "raster/tile_buffer.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "raster/coverage.h"

namespace pineda::raster {
namespace {

// Byte `byte` of texel (x, y) in a tile buffer, straight from the description in base/abi.h.
size_t buffer_offset(uint32_t texel_bytes, uint32_t x, uint32_t y, uint32_t byte) {
  static constexpr uint32_t kLane[4][4] = {{0, 1, 4, 5}, {2, 3, 6, 7}, {8, 9, 12, 13}, {10, 11, 14, 15}};
  const uint32_t lane = kLane[y % 4][x % 4];
  const size_t block = size_t{morton(x / 4, y / 4)} * 16 * texel_bytes;
  if (texel_bytes <= 4) return block + lane * texel_bytes + byte;
  return block + byte / 4 * 64 + lane * 4 + byte % 4;
}

TEST(TileBuffer, LoadAndStoreEveryTexelSize) {
  std::mt19937 rng(1);
  for (const uint32_t bytes : {1u, 2u, 4u, 8u, 16u}) {
    for (const int32_t size : {16, 32, 64}) {
      for (const Rect area : {Rect{0, 0, 200, 200}, Rect{70, 67, 93, 99}}) {
        constexpr uint32_t kWidth = 200, kHeight = 200;
        const size_t pitch = kWidth * bytes + 12;
        std::vector<uint8_t> memory(pitch * kHeight);
        for (uint8_t& v : memory) v = static_cast<uint8_t>(rng());
        PassAttachment a;
        a.address = memory.data();
        a.row_pitch_bytes = pitch;
        a.texel_bytes = bytes;
        TilePosition tile{64, 64, size, {}};
        tile.rect = intersect({64, 64, 64 + size, 64 + size}, area);
        PodBuffer<uint8_t> buffer;
        const size_t buffer_bytes = static_cast<size_t>(size * size) * bytes;
        std::memset(buffer.append(buffer_bytes), 0xCC, buffer_bytes);
        load_tile(a, a.address, tile, {buffer.data()});
        for (int32_t y = 0; y < size; ++y) {
          for (int32_t x = 0; x < size; ++x) {
            const int32_t px = 64 + x, py = 64 + y;
            const bool inside = tile.rect.contains({px, py, px + 1, py + 1});
            for (uint32_t b = 0; b < bytes; ++b) {
              const uint8_t expected = inside ? memory[static_cast<size_t>(py) * pitch + static_cast<size_t>(px) * bytes + b] : 0;
              ASSERT_EQ(buffer[buffer_offset(bytes, static_cast<uint32_t>(x), static_cast<uint32_t>(y), b)], expected)
                  << bytes << " bytes, texel " << x << ' ' << y;
            }
          }
        }
        // Back into other memory: the rectangle and nothing else.
        std::vector<uint8_t> stored(memory.size(), 0xEE);
        a.address = stored.data();
        store_tile(a, a.address, a.row_pitch_bytes, tile, {buffer.data()});
        for (size_t i = 0; i < stored.size(); ++i) {
          const auto py = static_cast<int32_t>(i / pitch), px = static_cast<int32_t>(i % pitch / bytes);
          const bool inside = tile.rect.contains({px, py, px + 1, py + 1});
          ASSERT_EQ(stored[i], inside ? memory[i] : 0xEE);
        }
      }
    }
  }
}

TEST(TileBuffer, ClearsAndFills) {
  const uint8_t texel[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}, zero[16] = {};
  for (const uint32_t bytes : {1u, 2u, 4u, 8u, 16u}) {
    PodBuffer<uint8_t> buffer;
    buffer.append(64 * 64 * bytes);
    clear_tile(bytes, zero, 64, {buffer.data()});
    const Rect rect{3, 9, 42, 31};
    fill_tile_rect(bytes, texel, rect, {buffer.data()});
    std::vector<uint8_t> memory(64 * 64 * bytes);
    fill_memory_rect(bytes, memory.data(), 64 * bytes, texel, rect, bytes % 2 == 0);
    for (uint32_t y = 0; y < 64; ++y) {
      for (uint32_t x = 0; x < 64; ++x) {
        const bool inside = x >= 3 && x < 42 && y >= 9 && y < 31;
        for (uint32_t b = 0; b < bytes; ++b) {
          const uint8_t expected = inside ? texel[b] : 0;
          ASSERT_EQ(buffer[buffer_offset(bytes, x, y, b)], expected);
          ASSERT_EQ(memory[(y * 64 + x) * bytes + b], expected);
        }
      }
    }
  }
}

}  // namespace
}  // namespace pineda::raster
