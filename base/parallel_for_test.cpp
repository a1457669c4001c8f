#include "base/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace pineda {
namespace {

TEST(ParallelFor, DoesEachPieceOnce) {
  for (const uint32_t count : {0u, 1u, 2u, 1000u}) {
    std::vector<std::atomic<int>> done(count);
    parallel_for(count, [&](uint32_t i) { ++done[i]; });
    for (const auto& times : done) EXPECT_EQ(times, 1);
  }
}

TEST(ParallelFor, Nests) {
  std::atomic<int> pieces{0};
  parallel_for(8, [&](uint32_t) { parallel_for(8, [&](uint32_t) { ++pieces; }); });
  EXPECT_EQ(pieces, 64);
}

TEST(ParallelFor, AFailureReachesTheCaller) {
  std::atomic<int> pieces{0};
  const auto piece = [&](uint32_t i) {
    ++pieces;
    if (i == 3) throw std::runtime_error("three");
  };
  EXPECT_THROW(parallel_for(10, piece), std::runtime_error);
  EXPECT_EQ(pieces, 10);
}

}  // namespace
}  // namespace pineda
