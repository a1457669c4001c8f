#include "raster/tile_buffer.h"

#include <cstring>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#else
#error "tile buffers have an x86-64 implementation only"
#endif

#include "raster/coverage.h"
#include "raster/fill_pattern.h"

namespace pineda::raster {
namespace {

constexpr uint32_t kPlaneBytes = kLanes * 4;

inline uint32_t lane_of(uint32_t x, uint32_t y) { return morton(x & 3, y & 3); }

// One texel of a block. Texels of more than 4 bytes lie in planes of 32-bit words.
void get_texel(uint32_t texel_bytes, const uint8_t* block, uint32_t lane, uint8_t* texel) {
  if (texel_bytes <= 4) {
    std::memcpy(texel, block + lane * texel_bytes, texel_bytes);
    return;
  }
  for (uint32_t p = 0; p < texel_bytes / 4; ++p) std::memcpy(texel + p * 4, block + p * kPlaneBytes + lane * 4, 4);
}

void set_texel(uint32_t texel_bytes, uint8_t* block, uint32_t lane, const uint8_t* texel) {
  if (texel_bytes <= 4) {
    std::memcpy(block + lane * texel_bytes, texel, texel_bytes);
    return;
  }
  for (uint32_t p = 0; p < texel_bytes / 4; ++p) std::memcpy(block + p * kPlaneBytes + lane * 4, texel + p * 4, 4);
}

inline __m128i load16(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }
inline void store16(void* p, __m128i v) { _mm_storeu_si128(static_cast<__m128i*>(p), v); }

// Whole blocks, one specialisation for each texel size. Quads are 2x2, so rows and quads are each other's 2-texel interleave.
template <uint32_t kBytes>
struct WholeBlock;

template <>
struct WholeBlock<1> {
  static void load(const uint8_t* m, size_t pitch, uint8_t* block) {
    uint32_t row[4];
    for (int y = 0; y < 4; ++y) std::memcpy(&row[y], m + y * pitch, 4);
    store16(block, interleave(_mm_set_epi32(0, 0, static_cast<int>(row[2]), static_cast<int>(row[0])),
                              _mm_set_epi32(0, 0, static_cast<int>(row[3]), static_cast<int>(row[1]))));
  }
  static void store(const uint8_t* block, uint8_t* m, size_t pitch) {
    const __m128i v = load16(block);  // even words: row 0 of a quad pair, odd words: row 1
    const __m128i even_odd = _mm_shuffle_epi8(v, _mm_set_epi8(15, 14, 11, 10, 13, 12, 9, 8, 7, 6, 3, 2, 5, 4, 1, 0));
    uint32_t row[4];
    store16(row, even_odd);
    for (int y = 0; y < 4; ++y) std::memcpy(m + y * pitch, &row[y], 4);
  }
  static __m128i interleave(__m128i even, __m128i odd) { return _mm_unpacklo_epi16(even, odd); }
};

template <>
struct WholeBlock<2> {
  static void load(const uint8_t* m, size_t pitch, uint8_t* block) {
    for (int half = 0; half < 2; ++half) {
      const __m128i even = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(m + 2 * half * pitch));
      const __m128i odd = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(m + (2 * half + 1) * pitch));
      store16(block + half * 16, _mm_unpacklo_epi32(even, odd));
    }
  }
  static void store(const uint8_t* block, uint8_t* m, size_t pitch) {
    for (int half = 0; half < 2; ++half) {
      const __m128i rows = _mm_shuffle_epi32(load16(block + half * 16), _MM_SHUFFLE(3, 1, 2, 0));
      _mm_storel_epi64(reinterpret_cast<__m128i*>(m + 2 * half * pitch), rows);
      _mm_storel_epi64(reinterpret_cast<__m128i*>(m + (2 * half + 1) * pitch), _mm_unpackhi_epi64(rows, rows));
    }
  }
};

template <>
struct WholeBlock<4> {
  static void load(const uint8_t* m, size_t pitch, uint8_t* block) {
    for (int half = 0; half < 2; ++half) {
      const __m128i even = load16(m + 2 * half * pitch), odd = load16(m + (2 * half + 1) * pitch);
      store16(block + half * 32, _mm_unpacklo_epi64(even, odd));
      store16(block + half * 32 + 16, _mm_unpackhi_epi64(even, odd));
    }
  }
  static void store(const uint8_t* block, uint8_t* m, size_t pitch) {
    for (int half = 0; half < 2; ++half) {
      const __m128i left = load16(block + half * 32), right = load16(block + half * 32 + 16);
      store16(m + 2 * half * pitch, _mm_unpacklo_epi64(left, right));
      store16(m + (2 * half + 1) * pitch, _mm_unpackhi_epi64(left, right));
    }
  }
};

template <>
struct WholeBlock<8> {
  static void load(const uint8_t* m, size_t pitch, uint8_t* block) {
    for (int q = 0; q < 4; ++q) {
      const uint8_t* p = m + (q >> 1) * 2 * pitch + (q & 1) * 16;
      const __m128 top = _mm_castsi128_ps(load16(p)), bottom = _mm_castsi128_ps(load16(p + pitch));
      store16(block + q * 16, _mm_castps_si128(_mm_shuffle_ps(top, bottom, _MM_SHUFFLE(2, 0, 2, 0))));
      store16(block + kPlaneBytes + q * 16, _mm_castps_si128(_mm_shuffle_ps(top, bottom, _MM_SHUFFLE(3, 1, 3, 1))));
    }
  }
  static void store(const uint8_t* block, uint8_t* m, size_t pitch) {
    for (int q = 0; q < 4; ++q) {
      uint8_t* p = m + (q >> 1) * 2 * pitch + (q & 1) * 16;
      const __m128i low = load16(block + q * 16), high = load16(block + kPlaneBytes + q * 16);
      store16(p, _mm_unpacklo_epi32(low, high));
      store16(p + pitch, _mm_unpackhi_epi32(low, high));
    }
  }
};

template <>
struct WholeBlock<16> {
  static void load(const uint8_t* m, size_t pitch, uint8_t* block) {
    for (int q = 0; q < 4; ++q) {
      const uint8_t* p = m + (q >> 1) * 2 * pitch + (q & 1) * 32;
      __m128 r0 = _mm_castsi128_ps(load16(p)), r1 = _mm_castsi128_ps(load16(p + 16));
      __m128 r2 = _mm_castsi128_ps(load16(p + pitch)), r3 = _mm_castsi128_ps(load16(p + pitch + 16));
      _MM_TRANSPOSE4_PS(r0, r1, r2, r3);
      store16(block + q * 16, _mm_castps_si128(r0));
      store16(block + kPlaneBytes + q * 16, _mm_castps_si128(r1));
      store16(block + 2 * kPlaneBytes + q * 16, _mm_castps_si128(r2));
      store16(block + 3 * kPlaneBytes + q * 16, _mm_castps_si128(r3));
    }
  }
  static void store(const uint8_t* block, uint8_t* m, size_t pitch) {
    for (int q = 0; q < 4; ++q) {
      uint8_t* p = m + (q >> 1) * 2 * pitch + (q & 1) * 32;
      __m128 r0 = _mm_castsi128_ps(load16(block + q * 16)), r1 = _mm_castsi128_ps(load16(block + kPlaneBytes + q * 16));
      __m128 r2 = _mm_castsi128_ps(load16(block + 2 * kPlaneBytes + q * 16)),
             r3 = _mm_castsi128_ps(load16(block + 3 * kPlaneBytes + q * 16));
      _MM_TRANSPOSE4_PS(r0, r1, r2, r3);
      store16(p, _mm_castps_si128(r0));
      store16(p + 16, _mm_castps_si128(r1));
      store16(p + pitch, _mm_castps_si128(r2));
      store16(p + pitch + 16, _mm_castps_si128(r3));
    }
  }
};

// Calls whole(block, x, y) for blocks inside `rect` and part(block, x, y) for the others that touch the tile; x and y in px.
template <class Whole, class Part>
inline void for_blocks(const TilePosition& tile, const Whole& whole, const Part& part) {
  const int32_t blocks = tile.size_px / static_cast<int32_t>(kBlockDim);
  for (int32_t by = 0; by < blocks; ++by) {
    const int32_t y = tile.y_px + by * 4;
    const bool rows_inside = y >= tile.rect.y0 && y + 4 <= tile.rect.y1;
    for (int32_t bx = 0; bx < blocks; ++bx) {
      const int32_t x = tile.x_px + bx * 4;
      const uint32_t block = morton(static_cast<uint32_t>(bx), static_cast<uint32_t>(by));
      if (rows_inside && x >= tile.rect.x0 && x + 4 <= tile.rect.x1) {
        whole(block, x, y);
      } else {
        part(block, x, y);
      }
    }
  }
}

// Calls each(lane, x, y) for the pixels of the block at (x, y) that lie in `rect`.
template <class Each>
inline void for_lanes(const Rect& rect, int32_t x, int32_t y, const Each& each) {
  const Rect r = intersect(rect, {x, y, x + 4, y + 4});
  for (int32_t py = r.y0; py < r.y1; ++py) {
    for (int32_t px = r.x0; px < r.x1; ++px) each(lane_of(static_cast<uint32_t>(px - x), static_cast<uint32_t>(py - y)), px, py);
  }
}

// Rows of an image lie in different pages, where no hardware prefetcher follows. Asking for the lines of the next row of blocks
// while this one is copied halves the time of a store (0.54 to 0.30 ms for 1920x1080 texels of 4 bytes on Sapphire Rapids, as
// fast as memset).
inline void prefetch_next_rows(const uint8_t* next, size_t pitch, const TilePosition& tile, int32_t y) {
  constexpr uintptr_t kLineBytes = 64;
  if (y + 8 > tile.rect.y1 || reinterpret_cast<uintptr_t>(next) % kLineBytes >= 16) return;
  for (uint32_t row = 0; row < 4; ++row) __builtin_prefetch(next + row * pitch, 1);
}

template <uint32_t kBytes>
void load_blocks(size_t pitch, const uint8_t* address, const TilePosition& tile, SamplePlane to) {
  const auto at = [&](int32_t x, int32_t y) {
    return address + static_cast<size_t>(y) * pitch + static_cast<size_t>(x) * kBytes;
  };
  const size_t block_bytes = size_t{kLanes * kBytes} * to.planes;
  for_blocks(
      tile,
      [&](uint32_t block, int32_t x, int32_t y) { WholeBlock<kBytes>::load(at(x, y), pitch, to.data + block * block_bytes); },
      [&](uint32_t block, int32_t x, int32_t y) {
        uint8_t* b = to.data + block * block_bytes;
        std::memset(b, 0, kLanes * kBytes);
        for_lanes(tile.rect, x, y, [&](uint32_t lane, int32_t px, int32_t py) { set_texel(kBytes, b, lane, at(px, py)); });
      });
}

template <uint32_t kBytes>
void store_blocks(uint8_t* address, size_t pitch, const TilePosition& tile, SamplePlane from, const EqualBlocks& equal) {
  const auto at = [&](int32_t x, int32_t y) {
    return address + static_cast<size_t>(y) * pitch + static_cast<size_t>(x) * kBytes;
  };
  const size_t block_bytes = size_t{kLanes * kBytes} * from.planes;
  const auto source = [&](uint32_t block) {
    return (equal.equal && equal.equal[block] ? equal.equal_from : from.data) + block * block_bytes;
  };
  for_blocks(
      tile,
      [&](uint32_t block, int32_t x, int32_t y) {
        prefetch_next_rows(at(x, y + 4), pitch, tile, y);
        WholeBlock<kBytes>::store(source(block), at(x, y), pitch);
      },
      [&](uint32_t block, int32_t x, int32_t y) {
        const uint8_t* b = source(block);
        for_lanes(tile.rect, x, y, [&](uint32_t lane, int32_t px, int32_t py) { get_texel(kBytes, b, lane, at(px, py)); });
      });
}

// A block that holds `texel` 16 times.
void make_block(uint32_t texel_bytes, const uint8_t* texel, uint8_t* block) {
  for (uint32_t lane = 0; lane < kLanes; ++lane) set_texel(texel_bytes, block, lane, texel);
}

// Calls f with the texel's size as a constant; Pass refuses other sizes.
template <class F>
inline void with_texel_bytes(uint32_t texel_bytes, const F& f) {
  switch (texel_bytes) {
    case 1:
      return f(std::integral_constant<uint32_t, 1>());
    case 2:
      return f(std::integral_constant<uint32_t, 2>());
    case 4:
      return f(std::integral_constant<uint32_t, 4>());
    case 8:
      return f(std::integral_constant<uint32_t, 8>());
    case 16:
      return f(std::integral_constant<uint32_t, 16>());
    default:
      return;
  }
}

}  // namespace

void load_tile(const PassAttachment& a, const uint8_t* address, const TilePosition& tile, SamplePlane to) {
  with_texel_bytes(a.texel_bytes, [&](auto bytes) { load_blocks<bytes>(a.row_pitch_bytes, address, tile, to); });
}

void store_tile(const PassAttachment& a, uint8_t* address, size_t row_pitch_bytes, const TilePosition& tile, SamplePlane from,
                const EqualBlocks& equal) {
  with_texel_bytes(a.texel_bytes, [&](auto bytes) { store_blocks<bytes>(address, row_pitch_bytes, tile, from, equal); });
}

void clear_tile(uint32_t texel_bytes, const uint8_t* texel, int32_t size_px, SamplePlane to) {
  alignas(64) uint8_t block[kLanes * 16];
  make_block(texel_bytes, texel, block);
  const size_t count = static_cast<size_t>(size_px) * static_cast<size_t>(size_px) / kLanes;
  with_texel_bytes(texel_bytes, [&](auto bytes) {
    constexpr size_t kBlockBytes = size_t{kLanes} * bytes;
    for (size_t i = 0; i < count; ++i) std::memcpy(to.data + i * kBlockBytes * to.planes, block, kBlockBytes);
  });
}

void fill_tile_rect(uint32_t texel_bytes, const uint8_t* texel, const Rect& rect, SamplePlane to) {
  alignas(64) uint8_t block[kLanes * 16];
  make_block(texel_bytes, texel, block);
  const size_t block_bytes = kLanes * texel_bytes;
  for (int32_t y = rect.y0 & ~3; y < rect.y1; y += 4) {
    for (int32_t x = rect.x0 & ~3; x < rect.x1; x += 4) {
      uint8_t* b = to.data + morton(static_cast<uint32_t>(x) / 4, static_cast<uint32_t>(y) / 4) * block_bytes * to.planes;
      if (rect.contains({x, y, x + 4, y + 4})) {
        std::memcpy(b, block, block_bytes);
      } else {
        for_lanes(rect, x, y, [&](uint32_t lane, int32_t, int32_t) { set_texel(texel_bytes, b, lane, texel); });
      }
    }
  }
}

void fill_memory_rect(uint32_t texel_bytes, uint8_t* address, size_t row_pitch_bytes, const uint8_t* texel, const Rect& rect,
                      bool stream) {
  if (rect.empty()) return;
  const size_t bytes = static_cast<size_t>(rect.x1 - rect.x0) * texel_bytes;
  const FillPattern filler(texel, texel_bytes);
  for (int32_t y = rect.y0; y < rect.y1; ++y) {
    uint8_t* const row = address + static_cast<size_t>(y) * row_pitch_bytes + static_cast<size_t>(rect.x0) * texel_bytes;
    filler.fill(row, bytes, stream);
  }
  if (stream) _mm_sfence();
}

}  // namespace pineda::raster
