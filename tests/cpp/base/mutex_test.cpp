#include "gecos/base/mutex.hpp"

#include <gtest/gtest.h>

#include <latch>
#include <mutex>
#include <thread>
#include <vector>

namespace gecos {
namespace {

TEST(FutexMutex, OneAtATimeIsInside) {
  constexpr int threads = 4;
  constexpr int times = 20'000;
  FutexMutex mutex;
  int count = 0;
  std::latch all(threads);
  std::vector<std::thread> counting;
  for (int i = 0; i < threads; ++i) {
    counting.emplace_back([&] {
      all.arrive_and_wait();
      for (int time = 0; time < times; ++time) {
        const std::lock_guard lock(mutex);
        ++count;
      }
    });
  }
  for (auto& thread : counting) thread.join();
  EXPECT_EQ(count, threads * times);
}

TEST(FutexMutex, WhoSleepsIsWoken) {
  FutexMutex mutex;
  std::unique_lock held(mutex);
  std::vector<std::thread> waiting;
  for (int i = 0; i < 3; ++i) waiting.emplace_back([&] { const std::lock_guard lock(mutex); });
  held.unlock();
  for (auto& thread : waiting) thread.join();
}

TEST(FutexMutex, TryLockDoesNotWait) {
  FutexMutex mutex;
  ASSERT_TRUE(mutex.try_lock());
  EXPECT_FALSE(mutex.try_lock());
  mutex.unlock();
  EXPECT_TRUE(mutex.try_lock());
  mutex.unlock();
}

}  // namespace
}  // namespace gecos
