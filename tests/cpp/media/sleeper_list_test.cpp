#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "gecos/media/buffers/stream_ring.hpp"

namespace gecos::media {
namespace {

class CountingSleeper final : public Sleeper {
 public:
  void wake_if_asleep() override { ++woken; }
  std::atomic<int> woken{0};
};

TEST(SleeperList, WakesThoseThatWereAddedAndNotRemoved) {
  SleeperList list;
  const auto one = std::make_shared<CountingSleeper>();
  const auto other = std::make_shared<CountingSleeper>();
  list.wake();
  list.add(one);
  list.wake();
  list.add(other);
  list.wake();
  list.remove(one.get());
  list.wake();
  EXPECT_EQ(one->woken, 2);
  EXPECT_EQ(other->woken, 2);
}

TEST(SleeperList, DoesNotKeepASleeper) {
  SleeperList list;
  auto sleeper = std::make_shared<CountingSleeper>();
  const std::weak_ptr<CountingSleeper> watched = sleeper;
  list.add(sleeper);
  list.wake();
  sleeper.reset();
  EXPECT_TRUE(watched.expired());
  list.wake();
}

TEST(SleeperList, ChangesWhileItsWriterWakes) {
  SleeperList list;
  const auto stays = std::make_shared<CountingSleeper>();
  list.add(stays);
  std::atomic<bool> ended{false};
  std::thread changing([&] {
    for (int i = 0; i < 1000; ++i) {
      const auto comes = std::make_shared<CountingSleeper>();
      list.add(comes);
      if (i % 2 == 0) list.remove(comes.get());
    }
    ended = true;
  });
  int times = 0;
  for (; !ended || times == 0; ++times) list.wake();
  changing.join();
  EXPECT_EQ(stays->woken, times);
}

}  // namespace
}  // namespace gecos::media
