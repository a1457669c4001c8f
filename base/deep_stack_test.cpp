#include "base/deep_stack.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <stdexcept>

namespace pineda {
namespace {

// Touches a kilobyte of stack on each level.
uint32_t recurse(uint32_t levels) {
  volatile char frame[1024];
  frame[0] = static_cast<char>(levels);
  return levels == 0 ? 0 : recurse(levels - 1) + 1 + (frame[0] & 0);
}

constexpr uint32_t kLevels = 4000;  // 4 MiB

void* on_a_small_stack(void* argument) {
  auto& levels = *static_cast<uint32_t*>(argument);
  with_deep_stack([&] {
    with_deep_stack([&] { levels = recurse(kLevels); });  // there is room now
  });
  try {
    with_deep_stack([] { throw std::runtime_error("deep"); });
    levels = 0;
  } catch (const std::runtime_error&) {
  }
  return nullptr;
}

TEST(DeepStack, SmallThreadsRecurseAsDeep) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, 128 << 10), 0);
  pthread_t thread;
  uint32_t levels = 0;
  ASSERT_EQ(pthread_create(&thread, &attributes, on_a_small_stack, &levels), 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  EXPECT_EQ(levels, kLevels);
}

TEST(DeepStack, LargeStacksAreUsedDirectly) {
  const pthread_t self = pthread_self();
  bool same = false;
  with_deep_stack([&] { same = pthread_equal(self, pthread_self()); });
  EXPECT_TRUE(same);
}

}  // namespace
}  // namespace pineda
