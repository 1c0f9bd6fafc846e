#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <thread>
#include <vector>

#include "gecos/servant.hpp"

namespace gecos::session {
namespace {

/// Counts its samples, and notices a sample after its destruction.
class Counting final : public Publisher {
 public:
  Counting(std::atomic<int>& published, bool serves) : published_(published), serves_(serves) {}
  ~Counting() override { alive_ = false; }

  void publish(const StreamDescription&, ByteView, std::int64_t) override { note(); }
  std::string served_as() override { return serves_ ? "LAMP" : ""; }
  void note() {
    EXPECT_TRUE(alive_);
    ++published_;
  }

 private:
  std::atomic<int>& published_;
  const bool serves_;
  bool alive_ = true;
};

TEST(PublisherSlot, OneOfManyServersGetsTheServant) {
  constexpr int servers = 8;
  std::atomic<int> published = 0;
  PublisherSlot slot;
  std::latch together(servers);
  std::atomic<int> accepted = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < servers; ++i) {
    threads.emplace_back([&] {
      const auto publisher = std::make_shared<Counting>(published, true);
      together.arrive_and_wait();
      if (slot.claim(publisher)) ++accepted;
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(accepted, 1);
  EXPECT_EQ(slot.served_as(), "LAMP");
}

TEST(PublisherSlot, AThreadMayPublishWhileServersComeAndGo) {
  std::atomic<int> published = 0;
  std::atomic<bool> over = false;
  PublisherSlot slot;
  std::thread servant([&] {
    while (!over) {
      slot.with([](Publisher& publisher) { static_cast<Counting&>(publisher).note(); });
    }
  });
  for (int server = 0; server < 300; ++server) {
    const int before = published;
    ASSERT_TRUE(slot.claim(std::make_shared<Counting>(published, false)));
    while (published == before) std::this_thread::yield();
    if (server % 2 == 0) slot.release();  // otherwise the next server replaces this one
  }
  over = true;
  servant.join();
}

TEST(PublisherSlot, ReleaseWaitsForTheThreadThatPublishes) {
  std::atomic<int> published = 0;
  PublisherSlot slot;
  auto publisher = std::make_shared<Counting>(published, true);
  const std::weak_ptr<Counting> watched = publisher;
  ASSERT_TRUE(slot.claim(std::move(publisher)));
  std::latch inside(1);
  std::latch go_on(1);
  std::thread servant([&] {
    slot.with([&](Publisher& used) {
      inside.count_down();
      go_on.wait();
      static_cast<Counting&>(used).note();
    });
  });
  inside.wait();
  std::thread server([&] { slot.release(); });
  while (!slot.empty()) std::this_thread::yield();
  EXPECT_FALSE(watched.expired());
  go_on.count_down();
  servant.join();
  server.join();
  EXPECT_TRUE(watched.expired());
  EXPECT_EQ(published, 1);
}

}  // namespace
}  // namespace gecos::session
