// Copies and fills of rows, split over the pool when there are enough bytes to pay for it.
#include <algorithm>
#include <cstring>

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

void fill_bytes(uint8_t* dst, uint64_t bytes, const uint8_t* pattern, uint32_t pattern_bytes) {
  if (pattern_bytes == 1) {
    std::memset(dst, pattern[0], bytes);
    return;
  }
  // One period of whole patterns, then copies of it.
  uint8_t period[16 * 16];
  const uint32_t period_bytes = 16 * pattern_bytes;
  for (uint32_t i = 0; i < period_bytes; i += pattern_bytes) std::memcpy(period + i, pattern, pattern_bytes);
  for (; bytes >= period_bytes; bytes -= period_bytes, dst += period_bytes) std::memcpy(dst, period, period_bytes);
  std::memcpy(dst, period, bytes);
}

}  // namespace

void copy_rows(ThreadPool& pool, const CopyRows& copy) {
  CopyRows c = copy;
  if (c.row_bytes == 0 || c.rows == 0 || c.slices == 0) return;
  if (c.src_row_pitch == c.row_bytes && c.dst_row_pitch == c.row_bytes) {  // one long row
    c.row_bytes *= c.rows;
    c.rows = 1;
  }
  for_pieces(pool, c.row_bytes, c.rows, c.slices,
             [&](uint64_t slice, uint64_t row, uint64_t end_row, uint64_t first, uint64_t end) {
               for (; row < end_row; ++row) {
                 std::memcpy(c.dst + slice * c.dst_slice_pitch + row * c.dst_row_pitch + first,
                             c.src + slice * c.src_slice_pitch + row * c.src_row_pitch + first, end - first);
               }
             });
}

void fill_rows(ThreadPool& pool, const FillRows& fill) {
  FillRows f = fill;
  if (f.row_bytes == 0 || f.rows == 0 || f.slices == 0 || f.pattern_bytes == 0 || f.pattern_bytes > f.pattern.size()) return;
  if (f.row_pitch == f.row_bytes && f.row_bytes % f.pattern_bytes == 0) {
    f.row_bytes *= f.rows;
    f.rows = 1;
  }
  // A piece may begin inside a pattern: it is rotated.
  for_pieces(pool, f.row_bytes, f.rows, f.slices,
             [&](uint64_t slice, uint64_t row, uint64_t end_row, uint64_t first, uint64_t end) {
               uint8_t pattern[16];
               for (uint32_t i = 0; i < f.pattern_bytes; ++i) pattern[i] = f.pattern[(first + i) % f.pattern_bytes];
               for (; row < end_row; ++row) {
                 fill_bytes(f.dst + slice * f.slice_pitch + row * f.row_pitch + first, end - first, pattern, f.pattern_bytes);
               }
             });
}

}  // namespace pineda::raster
