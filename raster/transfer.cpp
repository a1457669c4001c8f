// Copies and fills of rows, split over the pool when there are enough bytes to pay for it.
#include <emmintrin.h>

#include <algorithm>
#include <cstring>

#include "raster/fill_pattern.h"
#include "raster/raster.h"

namespace pineda::raster {
namespace {

constexpr uint64_t kPieceBytes = 128 << 10;     // work handed out at once
constexpr uint64_t kParallelBytes = 512 << 10;  // below this one core's copy is over before a helper wakes up

// Calls run(slice, first_row, end_row, first_byte, end_byte) for pieces of about kPieceBytes that cover rows x row_bytes x
// slices. Rows longer than a piece are cut.
constexpr uint64_t kCut = kPieceBytes;

template <class Run>
void for_pieces(ThreadPool& pool, uint64_t row_bytes, uint64_t rows, uint64_t slices, const Run& run) {
  const uint64_t rows_per_piece = std::max<uint64_t>(1, kPieceBytes / row_bytes);
  const uint64_t row_pieces = (rows + rows_per_piece - 1) / rows_per_piece;
  const bool cut = rows_per_piece == 1 && row_bytes > 2 * kCut;
  const uint64_t cuts = cut ? (row_bytes + kCut - 1) / kCut : 1;
  const uint64_t total = row_pieces * cuts * slices;
  const auto piece = [&](uint64_t index) {
    const uint64_t first_byte = index % cuts * kCut;
    const uint64_t end_byte = cut ? std::min(row_bytes, first_byte + kCut) : row_bytes;
    const uint64_t first_row = index / cuts % row_pieces * rows_per_piece;
    run(index / cuts / row_pieces, first_row, std::min(rows, first_row + rows_per_piece), first_byte, end_byte);
  };
  const bool parallel = row_bytes * rows * slices >= kParallelBytes && total > 1;
  // Several pieces an index when there are more than parallel_for can count.
  const uint64_t per_index = (total + (1u << 20) - 1) >> 20;
  pool.parallel_for(
      static_cast<uint32_t>((total + per_index - 1) / per_index),
      [&](uint32_t i, uint32_t) {
        for (uint64_t p = i * per_index; p < std::min(total, (i + 1) * per_index); ++p) piece(p);
      },
      parallel);
}

constexpr uint64_t kStreamRowBytes = 512;  // shorter pieces would be mostly edges

void stream_copy(uint8_t* dst, const uint8_t* src, uint64_t bytes) {
  const uint64_t head = std::min<uint64_t>(bytes, -reinterpret_cast<uintptr_t>(dst) & 63);
  std::memcpy(dst, src, head);
  dst += head, src += head, bytes -= head;
  for (; bytes >= 64; bytes -= 64, dst += 64, src += 64) {
    const auto* from = reinterpret_cast<const __m128i*>(src);
    auto* to = reinterpret_cast<__m128i*>(dst);
    const __m128i a = _mm_loadu_si128(from), b = _mm_loadu_si128(from + 1), c = _mm_loadu_si128(from + 2),
                  d = _mm_loadu_si128(from + 3);
    _mm_stream_si128(to, a);
    _mm_stream_si128(to + 1, b);
    _mm_stream_si128(to + 2, c);
    _mm_stream_si128(to + 3, d);
  }
  std::memcpy(dst, src, bytes);
}

bool streams(uint64_t row_bytes, uint64_t rows, uint64_t slices) {
  return row_bytes >= kStreamRowBytes && row_bytes * rows * slices >= kStreamBytes;
}

}  // namespace

void copy_rows(ThreadPool& pool, const CopyRows& copy) {
  CopyRows c = copy;
  if (c.row_bytes == 0 || c.rows == 0 || c.slices == 0) return;
  if (c.src_row_pitch == c.row_bytes && c.dst_row_pitch == c.row_bytes) {  // one long row
    c.row_bytes *= c.rows;
    c.rows = 1;
  }
  const bool stream = streams(c.row_bytes, c.rows, c.slices);
  for_pieces(pool, c.row_bytes, c.rows, c.slices,
             [&](uint64_t slice, uint64_t row, uint64_t end_row, uint64_t first, uint64_t end) {
               for (; row < end_row; ++row) {
                 uint8_t* to = c.dst + slice * c.dst_slice_pitch + row * c.dst_row_pitch + first;
                 const uint8_t* from = c.src + slice * c.src_slice_pitch + row * c.src_row_pitch + first;
                 stream ? stream_copy(to, from, end - first) : static_cast<void>(std::memcpy(to, from, end - first));
               }
               if (stream) _mm_sfence();
             });
}

void fill_rows(ThreadPool& pool, const FillRows& fill) {
  FillRows f = fill;
  if (f.row_bytes == 0 || f.rows == 0 || f.slices == 0 || f.pattern_bytes == 0 || f.pattern_bytes > f.pattern.size()) return;
  if (f.row_pitch == f.row_bytes && f.row_bytes % f.pattern_bytes == 0) {
    f.row_bytes *= f.rows;
    f.rows = 1;
  }
  const bool stream = streams(f.row_bytes, f.rows, f.slices);
  // A piece may begin inside a pattern: it is rotated.
  for_pieces(pool, f.row_bytes, f.rows, f.slices,
             [&](uint64_t slice, uint64_t row, uint64_t end_row, uint64_t first, uint64_t end) {
               uint8_t pattern[16];
               for (uint32_t i = 0; i < f.pattern_bytes; ++i) pattern[i] = f.pattern[(first + i) % f.pattern_bytes];
               const FillPattern filler(pattern, f.pattern_bytes);
               for (; row < end_row; ++row)
                 filler.fill(f.dst + slice * f.slice_pitch + row * f.row_pitch + first, end - first, stream);
               if (stream) _mm_sfence();
             });
}

}  // namespace pineda::raster
