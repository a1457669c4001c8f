// Copies, fills and dispatches against plain loops.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <vector>

#include "raster/raster.h"

namespace pineda::raster {
namespace {

TEST(Transfer, CopiesRowsOfAnyShape) {
  ThreadPool pool(3);
  std::mt19937 rng(4);
  for (const auto& [row_bytes, rows, slices] :
       {std::array<uint64_t, 3>{1, 1, 1}, {7, 5, 3}, {4096, 300, 2}, {1500000, 2, 1}, {300000, 4, 2}, {64, 0, 1}}) {
    for (const uint64_t padding : {uint64_t{0}, uint64_t{13}}) {
      const uint64_t pitch = row_bytes + padding, slice_pitch = pitch * rows + padding;
      std::vector<uint8_t> src(slice_pitch * slices + 1), dst(src.size(), 0xAA), expected = dst;
      for (uint8_t& v : src) v = static_cast<uint8_t>(rng());
      for (uint64_t s = 0; s < slices; ++s) {
        for (uint64_t r = 0; r < rows; ++r) {
          for (uint64_t b = 0; b < row_bytes; ++b)
            expected[s * slice_pitch + r * pitch + b] = src[s * slice_pitch + r * pitch + b];
        }
      }
      copy_rows(pool, {src.data(), dst.data(), row_bytes, rows, slices, pitch, pitch, slice_pitch, slice_pitch});
      ASSERT_TRUE(dst == expected) << row_bytes << ' ' << rows << ' ' << slices;
    }
  }
}

TEST(Transfer, FillsWithEveryPatternLength) {
  ThreadPool pool(3);
  for (uint32_t pattern_bytes = 1; pattern_bytes <= 16; ++pattern_bytes) {
    for (const auto& [row_texels, rows] : {std::array<uint64_t, 2>{1, 1}, {11, 9}, {60000, 3}, {3000, 50}}) {
      for (const uint64_t padding : {uint64_t{0}, uint64_t{5}}) {
        FillRows fill{};
        fill.row_bytes = row_texels * pattern_bytes;
        fill.rows = rows;
        fill.slices = 2;
        fill.row_pitch = fill.row_bytes + padding;
        fill.slice_pitch = fill.row_pitch * rows;
        fill.pattern_bytes = pattern_bytes;
        for (uint32_t i = 0; i < 16; ++i) fill.pattern[i] = static_cast<uint8_t>(i * 17 + 3);
        std::vector<uint8_t> dst(fill.slice_pitch * 2, 0xAA), expected = dst;
        fill.dst = dst.data();
        for (uint64_t r = 0; r < rows * 2; ++r) {
          for (uint64_t b = 0; b < fill.row_bytes; ++b) expected[r * fill.row_pitch + b] = fill.pattern[b % pattern_bytes];
        }
        fill_rows(pool, fill);
        ASSERT_TRUE(dst == expected) << pattern_bytes << ' ' << row_texels;
      }
    }
  }
}

// Every invocation adds 1 to its own counter; shared memory must be there and zero.
struct Counters {
  std::array<uint32_t, 3> base, count, local;
  std::vector<std::atomic<uint32_t>> hits;
  std::atomic<uint32_t> dirty{0};
};

void compute_kernel(const KernelHandle*, const void* draw, void*, const PrimRecord* prims, uint32_t prim_count,
                    const void* waves) {
  auto& c = *static_cast<Counters*>(const_cast<void*>(static_cast<const DrawContext*>(draw)->sets[0]));
  const uint32_t local = c.local[0] * c.local[1] * c.local[2];
  for (uint32_t p = 0; p < prim_count; ++p) {
    const auto& group = *static_cast<const WorkgroupRecord*>(prims[p].prim);
    const uint64_t index =
        (uint64_t{group.id[2] - c.base[2]} * c.count[1] + (group.id[1] - c.base[1])) * c.count[0] + (group.id[0] - c.base[0]);
    auto* shared = static_cast<uint8_t*>(group.shared_memory);
    for (uint32_t i = 0; shared && i < 1000; ++i) {
      c.dirty += shared[i] != 0;
      shared[i] = 1;
    }
    for (uint32_t i = 0; i < prims[p].wave_count; ++i) {
      const ComputeWave& wave = static_cast<const ComputeWave*>(waves)[prims[p].first_wave + i];
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        if (wave.mask >> lane & 1) ++c.hits[index * local + wave.first_invocation + lane];
      }
    }
  }
}

TEST(Dispatch, RunsEveryInvocationOnce) {
  for (const uint32_t threads : {1u, 3u}) {
    ThreadPool pool(threads);
    for (const std::array<uint32_t, 3> count : {std::array<uint32_t, 3>{1, 1, 1}, {5, 3, 2}, {700, 1, 1}, {0, 4, 4}}) {
      for (const std::array<uint32_t, 3> local : {std::array<uint32_t, 3>{1, 1, 1}, {16, 1, 1}, {5, 7, 3}, {64, 4, 1}}) {
        for (const uint32_t shared_bytes : {0u, 1000u, 32768u}) {
          Counters counters{{3, 0, 9}, count, local, {}, {}};
          counters.hits =
              std::vector<std::atomic<uint32_t>>(size_t{count[0]} * count[1] * count[2] * local[0] * local[1] * local[2]);
          DrawContext context{};
          context.sets[0] = &counters;
          dispatch(pool, {{compute_kernel, nullptr}, &context, counters.base, count, local, shared_bytes});
          for (const auto& hits : counters.hits) ASSERT_EQ(hits.load(), 1u);
          EXPECT_EQ(counters.dirty.load(), 0u);
        }
      }
    }
  }
}

}  // namespace
}  // namespace pineda::raster
