#include "raster/blit.h"

#include <emmintrin.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "raster/texel_converter.h"
#include "raster/texel_row.h"

namespace pineda::raster {

BlitAxis::BlitAxis(int32_t source0, int32_t source1, int32_t to_0, int32_t to_1, uint32_t source_limit)
    : scale(to_1 == to_0 ? 0 : (double(source1) - source0) / (double(to_1) - to_0)),
      from0(source0),
      to0(to_0),
      begin(std::min(to_0, to_1)),
      end(std::max(to_0, to_1)),
      limit(source_limit) {}

uint32_t BlitAxis::clamp(double texel) const { return static_cast<uint32_t>(std::clamp(texel, 0.0, double(limit) - 1)); }

uint32_t BlitAxis::nearest(int32_t i) const { return clamp(std::floor(coordinate(i))); }

BlitAxis::Pair BlitAxis::pair(int32_t i) const {
  const double u = coordinate(i) - 0.5, u0 = std::floor(u);
  return {clamp(u0), clamp(u0 + 1), static_cast<float>(u - u0)};
}

namespace {

// What rows share: source columns of each destination column.
struct Columns {
  std::vector<uint32_t> first, second;
  std::vector<float> weight;
};

Columns columns_of(const Blit& blit) {
  Columns columns;
  for (int32_t x = blit.x.begin; x < blit.x.end; ++x) {
    if (blit.linear) {
      const BlitAxis::Pair pair = blit.x.pair(x);
      columns.first.push_back(pair.first);
      columns.second.push_back(pair.second);
      columns.weight.push_back(pair.weight);
    } else {
      columns.first.push_back(blit.x.nearest(x));
    }
  }
  return columns;
}

const uint8_t* source_row(const Blit& blit, uint32_t y, uint32_t z) {
  return blit.source.address + y * blit.source.row_pitch_bytes + z * blit.source.slice_pitch_bytes;
}

// The first texel that is written of a row.
uint8_t* destination_row(const Blit& blit, int32_t y, int32_t z) {
  return blit.destination.address + static_cast<uint64_t>(y) * blit.destination.row_pitch_bytes +
         static_cast<uint64_t>(z) * blit.destination.slice_pitch_bytes +
         static_cast<uint64_t>(blit.x.begin) * blit.destination.format->texel_bytes;
}

template <size_t kBytes>
void gather_texels(uint8_t* to, const uint8_t* from, const std::vector<uint32_t>& columns) {
  for (size_t i = 0; i < columns.size(); ++i) std::memcpy(to + i * kBytes, from + size_t{columns[i]} * kBytes, kBytes);
}

void copy_row(const Blit& blit, const Columns& columns, int32_t y, int32_t z) {
  const uint8_t* from = source_row(blit, blit.y.nearest(y), blit.z.nearest(z));
  uint8_t* to = destination_row(blit, y, z);
  switch (blit.source.format->texel_bytes) {
    case 1:
      return gather_texels<1>(to, from, columns.first);
    case 2:
      return gather_texels<2>(to, from, columns.first);
    case 4:
      return gather_texels<4>(to, from, columns.first);
    case 8:
      return gather_texels<8>(to, from, columns.first);
    default:
      return gather_texels<16>(to, from, columns.first);
  }
}

// Integer formats, and whatever is not filtered.
void convert_row(const Blit& blit, const TexelConverter& converter, const Columns& columns, int32_t y, int32_t z) {
  const uint8_t* from = source_row(blit, blit.y.nearest(y), blit.z.nearest(z));
  converter.run(from, columns.first.data(), columns.first.size(), destination_row(blit, y, z));
}

// "Texel Filtering", VK_FILTER_LINEAR, for consecutive rows: a source row that the next destination row needs again is kept.
class LinearRows {
 public:
  LinearRows(const Blit& blit, const Columns& columns)
      : blit_(blit), columns_(columns), source_(*blit.source.format), destination_(*blit.destination.format) {
    const size_t count = columns.first.size();
    for (Cached& row : cache_) row.texels.resize(count);
    result_.resize(count);
    same_units_ = true;
    const Float4 a = source_.scale(), b = destination_.scale();
    const auto is_unorm = [](const FormatInfo& f) { return f.numeric == Numeric::kUnorm; };
    for (uint32_t c = 0; c < 4; ++c) {
      const bool written = blit.destination.format->component[c].bits != 0;
      if (written && (a[c] != b[c] || !blit.source.format->component[c].bits)) same_units_ = false;
    }
    same_units_ = same_units_ && is_unorm(*blit.source.format) && is_unorm(*blit.destination.format);
  }

  void run(int32_t y, int32_t z) {
    const BlitAxis::Pair rows = blit_.y.pair(y);
    const auto count = static_cast<uint32_t>(result_.size());
    const uint32_t slice = blit_.z.nearest(z);
    uint8_t* to = destination_row(blit_, y, z);
    if (!blit_.linear_z && same_units_) {
      const std::vector<Float4>&top = filtered(rows.first, slice), &bottom = filtered(rows.second, slice);
      return destination_.write_mixed_units(top.data(), bottom.data(), rows.weight, count, to);
    }
    if (!blit_.linear_z) {
      mix_rows(rows, slice, result_);
    } else {
      const BlitAxis::Pair slices = blit_.z.pair(z);
      mix_rows(rows, slices.first, result_);
      mix_rows(rows, slices.second, other_);
      for (uint32_t i = 0; i < count; ++i) result_[i] = mix(result_[i], other_[i], slices.weight);
    }
    if (same_units_) return destination_.write_units(result_.data(), count, to);
    for (Float4& value : result_) value /= source_.scale();
    destination_.write_values(result_.data(), count, to);
  }

 private:
  struct Cached {
    uint64_t key = ~uint64_t{0};
    std::vector<Float4> texels;  // filtered along x
  };

  void mix_rows(const BlitAxis::Pair& rows, uint32_t slice, std::vector<Float4>& out) {
    // The rows of a pair are in different places of the cache unless they are the same row.
    const std::vector<Float4>& top = filtered(rows.first, slice);
    const std::vector<Float4>& bottom = filtered(rows.second, slice);
    out.resize(top.size());
    for (size_t i = 0; i < out.size(); ++i) out[i] = mix(top[i], bottom[i], rows.weight);
  }

  const std::vector<Float4>& filtered(uint32_t y, uint32_t slice) {
    Cached& place = cache_[(y & 1) + 2 * (slice & 1)];
    const uint64_t key = uint64_t{slice} << 32 | y;
    if (place.key == key) return place.texels;
    place.key = key;
    const auto count = static_cast<uint32_t>(place.texels.size());
    const uint8_t* row = source_row(blit_, y, slice);
    source_.read_mixed(row, columns_.first.data(), columns_.second.data(), columns_.weight.data(), count, place.texels.data());
    return place.texels;
  }

  const Blit& blit_;
  const Columns& columns_;
  TexelRow source_, destination_;
  bool same_units_ = false;  // codes of the source are codes of the destination
  Cached cache_[4];
  std::vector<Float4> result_, other_;
};

// Halving RGBA8 images, as for mip levels: the mean of four codes, halves to even. The same bits as LinearRows, whose sums of
// codes and weights of a half are exact.
bool is_halving(const Blit& blit) {
  const FormatInfo& format = *blit.source.format;
  if (blit.source.format != blit.destination.format || format.numeric != Numeric::kUnorm || format.texel_bytes != 4 ||
      blit.linear_z) {
    return false;
  }
  for (const ComponentBits& c : format.component) {
    if (c.bits != 8) return false;
  }
  const auto halves = [](const BlitAxis& axis) {
    if (axis.scale != 2 || axis.begin >= axis.end) return false;
    const double first = 2 * (axis.begin - axis.to0) + axis.from0, last = 2 * (axis.end - 1 - axis.to0) + axis.from0 + 1;
    return first >= 0 && last < axis.limit;
  };
  return halves(blit.x) && halves(blit.y);
}

void halve_row(const Blit& blit, const Columns& columns, int32_t y, int32_t z) {
  const BlitAxis::Pair rows = blit.y.pair(y);
  const uint32_t slice = blit.z.nearest(z);
  const uint8_t* top = source_row(blit, rows.first, slice) + size_t{columns.first[0]} * 4;
  const uint8_t* bottom = source_row(blit, rows.second, slice) + size_t{columns.first[0]} * 4;
  uint8_t* to = destination_row(blit, y, z);
  const __m128i zero = _mm_setzero_si128(), one = _mm_set1_epi16(1);
  // Two source texels a side at once: one destination texel.
  for (size_t i = 0; i < columns.first.size(); ++i) {
    const __m128i a = _mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(top + 8 * i)), zero);
    const __m128i b = _mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(bottom + 8 * i)), zero);
    const __m128i column_sums = _mm_add_epi16(a, b), sum = _mm_add_epi16(column_sums, _mm_srli_si128(column_sums, 8));
    const __m128i odd = _mm_and_si128(_mm_srli_epi16(sum, 2), one);
    const __m128i mean = _mm_srli_epi16(_mm_add_epi16(_mm_add_epi16(sum, one), odd), 2);
    const int32_t texel = _mm_cvtsi128_si32(_mm_packus_epi16(mean, mean));
    std::memcpy(to + 4 * i, &texel, 4);
  }
}

}  // namespace

void blit(ThreadPool& pool, const Blit& blit) {
  if (blit.x.begin >= blit.x.end || blit.y.begin >= blit.y.end || blit.z.begin >= blit.z.end) return;
  const Columns columns = columns_of(blit);
  const auto rows = static_cast<uint64_t>(blit.y.end - blit.y.begin), slices = static_cast<uint64_t>(blit.z.end - blit.z.begin);
  const uint64_t texels = rows * slices * columns.first.size();
  const bool same = blit.source.format == blit.destination.format, halving = blit.linear && is_halving(blit);
  std::optional<TexelConverter> converter;
  if (!same && !blit.linear) converter.emplace(*blit.source.format, *blit.destination.format, texels);
  // Runs of rows, so that LinearRows may keep what two rows share. What a run is does not show in the result.
  constexpr uint64_t kTexelsOfRun = 16384;
  const uint64_t rows_of_run = std::clamp<uint64_t>(kTexelsOfRun / columns.first.size(), 1, rows);
  const uint64_t runs_of_slice = (rows + rows_of_run - 1) / rows_of_run;
  pool.parallel_for(
      static_cast<uint32_t>(runs_of_slice * slices),
      [&](uint32_t run, uint32_t) {
        const int32_t z = blit.z.begin + static_cast<int32_t>(run / runs_of_slice);
        const auto first = static_cast<int32_t>(run % runs_of_slice * rows_of_run);
        const int32_t begin = blit.y.begin + first, end = std::min(begin + static_cast<int32_t>(rows_of_run), blit.y.end);
        if (blit.linear && !halving) {
          LinearRows linear(blit, columns);
          for (int32_t y = begin; y < end; ++y) linear.run(y, z);
          return;
        }
        for (int32_t y = begin; y < end; ++y) {
          if (halving) {
            halve_row(blit, columns, y, z);
          } else if (same) {
            copy_row(blit, columns, y, z);
          } else {
            convert_row(blit, *converter, columns, y, z);
          }
        }
      },
      texels >= kTexelsOfRun);
}

}  // namespace pineda::raster
