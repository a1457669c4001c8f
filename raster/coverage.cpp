#include "raster/coverage.h"

#include <immintrin.h>

#include "raster/edge_list.h"

namespace pineda::raster {

namespace {

inline __m128i next_vertex(__m128i v) { return _mm_shuffle_epi32(v, _MM_SHUFFLE(3, 0, 2, 1)); }

// The three edges at once, in 32 bits. x and y: the vertices relative to the centre of the tile's first pixel (the fourth
// elements are ignored).
TileCover make_small_edges(__m128i x, __m128i y, bool clockwise, int32_t last, TileEdges& edges) {
  const __m128i flip = _mm_set1_epi32(clockwise ? 0 : -1), zero = _mm_setzero_si128();
  const auto oriented = [&](__m128i v) { return _mm_sub_epi32(_mm_xor_si128(v, flip), flip); };
  const __m128i a = oriented(_mm_sub_epi32(y, next_vertex(y))), b = oriented(_mm_sub_epi32(next_vertex(x), x));
  const __m128i top_left =
      _mm_or_si128(_mm_cmpgt_epi32(a, zero), _mm_and_si128(_mm_cmpeq_epi32(a, zero), _mm_cmpgt_epi32(b, zero)));
  const __m128i minus_e = _mm_add_epi32(_mm_mullo_epi32(a, x), _mm_mullo_epi32(b, y));
  // -1 where the edge is neither top nor left
  const __m128i e = _mm_sub_epi32(_mm_add_epi32(_mm_set1_epi32(-1), _mm_sub_epi32(zero, minus_e)), top_left);
  const __m128i c = _mm_srai_epi32(e, 8);
  const __m128i n = _mm_set1_epi32(last);
  const __m128i highest = _mm_add_epi32(c, _mm_mullo_epi32(n, _mm_add_epi32(_mm_max_epi32(a, zero), _mm_max_epi32(b, zero))));
  const __m128i lowest = _mm_add_epi32(c, _mm_mullo_epi32(n, _mm_add_epi32(_mm_min_epi32(a, zero), _mm_min_epi32(b, zero))));
  if (_mm_movemask_ps(_mm_castsi128_ps(highest)) & 7) return TileCover::kNone;
  const __m128i varies = _mm_cmpgt_epi32(zero, lowest);
  _mm_store_si128(reinterpret_cast<__m128i*>(edges.a), _mm_and_si128(a, varies));
  _mm_store_si128(reinterpret_cast<__m128i*>(edges.b), _mm_and_si128(b, varies));
  _mm_store_si128(reinterpret_cast<__m128i*>(edges.c), _mm_and_si128(c, varies));
  return (_mm_movemask_ps(_mm_castsi128_ps(varies)) & 7) == 0 ? TileCover::kFull : TileCover::kPartial;
}

// (x_fx8, y_fx8): centre of the tile's first pixel; `last`: pixels to its last.
TileCover make_wide_edges(const EdgeList& list, int32_t x_fx8, int32_t y_fx8, int64_t last, TileEdges& edges) {
  edges = {};
  bool full = true;
  for (int k = 0; k < list.count; ++k) {
    const auto& [a, b, x0, y0, c0] = list.edge[k];
    const int64_t c = (int64_t{a} * (x_fx8 - x0) + int64_t{b} * (y_fx8 - y0) + c0) >> 8;
    const int64_t highest = c + last * (std::max(a, 0) + std::max(b, 0));
    const int64_t lowest = c + last * (std::min(a, 0) + std::min(b, 0));
    if (highest < 0) return TileCover::kNone;
    if (lowest >= 0) continue;  // holds on the whole tile
    full = false;
    edges.a[k] = a;
    edges.b[k] = b;
    edges.c[k] = static_cast<int32_t>(c);
  }
  return full ? TileCover::kFull : TileCover::kPartial;
}

}  // namespace

TileCover make_tile_edges(const Triangle& tri, int32_t tile_x_px, int32_t tile_y_px, int32_t size_px, TileEdges& edges) {
  // Centre of the tile's first pixel.
  const int32_t x_fx8 = tile_x_px * kSubpixels + kSubpixels / 2, y_fx8 = tile_y_px * kSubpixels + kSubpixels / 2;
  if (tri.shape() != Shape::kTriangle) return make_wide_edges(EdgeList(tri), x_fx8, y_fx8, size_px - 1, edges);
  const bool clockwise = (tri.provoking_and_flags & Triangle::kClockwise) != 0;
  const __m128i x = _mm_sub_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(tri.x_fx8)), _mm_set1_epi32(x_fx8));
  const __m128i y = _mm_sub_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(tri.y_fx8)), _mm_set1_epi32(y_fx8));
  // All vertices within two tiles of the first pixel, and so within 2^15; and within 2^14 of each other.
  const __m128i limit = _mm_set1_epi32(2 * kSmallFx8);
  const __m128i far = _mm_or_si128(_mm_cmpgt_epi32(_mm_abs_epi32(x), limit), _mm_cmpgt_epi32(_mm_abs_epi32(y), limit));
  const __m128i small = _mm_set1_epi32(kSmallFx8);
  const __m128i wide = _mm_or_si128(_mm_cmpgt_epi32(_mm_abs_epi32(_mm_sub_epi32(x, next_vertex(x))), small),
                                    _mm_cmpgt_epi32(_mm_abs_epi32(_mm_sub_epi32(y, next_vertex(y))), small));
  if ((_mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(far, wide))) & 7) == 0)
    return make_small_edges(x, y, clockwise, size_px - 1, edges);

  return make_wide_edges(EdgeList(tri), x_fx8, y_fx8, size_px - 1, edges);
}

Rect pixel_rect(const Triangle& t) {
  const int32_t(&x)[3] = t.x_fx8, (&y)[3] = t.y_fx8;
  switch (t.shape()) {
    case Shape::kTriangle:
      return pixel_bounds(x[0], x[1], x[2], y[0], y[1], y[2]);
    case Shape::kParallelogram: {
      const int32_t x3 = x[1] + x[2] - x[0], y3 = y[1] + y[2] - y[0];
      const Rect r = pixel_bounds(x[0], x[1], x[2], y[0], y[1], y[2]), s = pixel_bounds(x[0], x[1], x3, y[0], y[1], y3);
      return {std::min(r.x0, s.x0), std::min(r.y0, s.y0), std::max(r.x1, s.x1), std::max(r.y1, s.y1)};
    }
    case Shape::kPixelLineX:  // at most half a pixel and the tie above and below the line, which goes on to the last column's
                              // centre
      return {x[2], (std::min(y[0], y[1]) >> 8) - 1, y[2], (std::max(y[0], y[1]) >> 8) + 2};
    case Shape::kPixelLineY:
      return {(std::min(x[0], x[1]) >> 8) - 1, x[2], (std::max(x[0], x[1]) >> 8) + 2, y[2]};
  }
  return {};
}

uint32_t rect_lanes(const Rect& rect, int32_t x_px, int32_t y_px) {
  constexpr uint16_t kColumnsBelow[5] = {0, 0x0505, 0x0F0F, 0x5F5F, 0xFFFF};
  constexpr uint16_t kRowsBelow[5] = {0, 0x0033, 0x00FF, 0x33FF, 0xFFFF};
  const auto cut = [](int32_t v) { return std::clamp(v, 0, 4); };
  return kColumnsBelow[cut(rect.x1 - x_px)] & ~kColumnsBelow[cut(rect.x0 - x_px)] & kRowsBelow[cut(rect.y1 - y_px)] &
         ~kRowsBelow[cut(rect.y0 - y_px)];
}

namespace {

// Position of each block in its tile, x + (y << 16) px.
constexpr auto kBlockXy = [] {
  std::array<uint32_t, kMaxTileBlocks> xy{};
  for (uint32_t block = 0; block < kMaxTileBlocks; ++block)
    xy[block] = morton_x(block) * kBlockDim + (morton_y(block) * kBlockDim << 16);
  return xy;
}();
static_assert(offsetof(FragmentWave, x_px) == 8 && offsetof(FragmentWave, y_px) == 10 &&
              offsetof(FragmentWave, block_index) == 12);

#define PINEDA_ISA_CODE "raster/coverage_impl.inc"
#include "raster/isa_copies.inc"

}  // namespace

const CoverageFunctions& coverage_functions(Isa isa) {
  static constexpr CoverageFunctions kSse42{sse42::cover<3>, sse42::cover<4>}, kAvx2{avx2::cover<3>, avx2::cover<4>},
      kAvx512{avx512::cover<3>, avx512::cover<4>};
  return *for_isa(isa, &kSse42, &kAvx2, &kAvx512);
}

}  // namespace pineda::raster
