#include "raster/thread_pool.h"

#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <atomic>
#include <thread>
#include <vector>

namespace pineda::raster {
namespace {

TEST(ThreadPool, RunsEveryIndexOnce) {
  for (const uint32_t threads : {1u, 2u, 5u}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const uint32_t count : {0u, 1u, 2u, 7u, 1000u}) {
      for (const bool helpers : {false, true}) {
        std::vector<std::atomic<uint32_t>> hits(count);
        std::vector<uint32_t> by_thread(threads);  // each thread writes its own
        pool.parallel_for(
            count,
            [&](uint32_t i, uint32_t thread) {
              ASSERT_LT(thread, threads);
              ++by_thread[thread];
              hits[i].fetch_add(1);
            },
            helpers);
        for (uint32_t i = 0; i < count; ++i) EXPECT_EQ(hits[i].load(), 1u);
        uint32_t sum = 0;
        for (const uint32_t n : by_thread) sum += n;
        EXPECT_EQ(sum, count);
      }
    }
  }
}

// Many short jobs in a row, with pauses that let workers fall asleep: late workers must never touch the next job.
TEST(ThreadPool, ShortJobsInARow) {
  ThreadPool pool(4);
  for (uint32_t job = 0; job < 3000; ++job) {
    uint32_t plain[8] = {};  // not atomic: the job's end must order these writes before the reads below
    pool.parallel_for(8, [&](uint32_t i, uint32_t) { plain[i] = job + i; });
    for (uint32_t i = 0; i < 8; ++i) ASSERT_EQ(plain[i], job + i);
    if (job % 500 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

TEST(ThreadPool, SetsTheFloatEnvironmentAndPutsItBack) {
  const unsigned before = _mm_getcsr();
  _mm_setcsr(before | 0x8040);  // flush denormals, as some applications do
  ThreadPool pool(3);
  std::atomic<uint32_t> wrong{0};
  pool.parallel_for(64, [&](uint32_t, uint32_t) { wrong += (_mm_getcsr() & 0xFFC0) != 0x1F80; });
  EXPECT_EQ(wrong.load(), 0u);
  EXPECT_EQ(_mm_getcsr() & 0x8040, 0x8040u);
  _mm_setcsr(before);
}

TEST(ThreadPool, AnExceptionReachesTheCallerAndThePoolGoesOn) {
  ThreadPool pool(3);
  for (int round = 0; round < 50; ++round) {
    EXPECT_THROW(pool.parallel_for(100,
                                   [](uint32_t i, uint32_t) {
                                     if (i % 10 == 7) throw std::bad_alloc();
                                   }),
                 std::bad_alloc);
    std::atomic<uint32_t> sum{0};
    pool.parallel_for(10, [&](uint32_t i, uint32_t) { sum += i; });
    EXPECT_EQ(sum.load(), 45u);
  }
}

TEST(ThreadPool, DestructionWithoutWork) { ThreadPool pool(4); }

}  // namespace
}  // namespace pineda::raster
