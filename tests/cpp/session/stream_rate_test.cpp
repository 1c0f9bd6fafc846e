// A publisher and a reader at 1 kHz: nothing is lost unseen, and neither end allocates.
#include <time.h>

#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>

#include "../robcl/allocations.hpp"
#include "gecos/session/client/leader_lock.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;

constexpr std::int32_t warm_up = 10;  ///< samples after which memory is used again
constexpr auto period = 1ms;

/// `make soak` asks for more.
std::int32_t samples() {
  const char* const seconds = std::getenv("STREAM_SECONDS");
  const bool asked = seconds != nullptr && *seconds != '\0';
  return 1000 * (asked ? std::stoi(seconds) : 1);
}

void sleep_until(gecos::TimePoint when) {
  const auto since = when.time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since);
  const timespec at{static_cast<time_t>(seconds.count()),
                    static_cast<long>((since - seconds).count())};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
  }
}

TEST(LeaderLock, AThreadThatFollowsForTheFirstTimeAllocatesNothing) {
  gecos::session::LeaderLock lead;
  const robcl::CountAllocations count;
  lead.follow(
      nullptr, [] { return true; }, gecos::TimePoint::max());
  EXPECT_EQ(count.so_far(), 0);
}

class StreamRate : public probe::OverMedia {};
// The media whose samples lie in memory that both ends see.
INSTANTIATE_TEST_SUITE_P(Over, StreamRate,
                         ::testing::Values(gecos::media::Kind::Inproc, gecos::media::Kind::Shm),
                         gecos::media::name_of);

TEST_P(StreamRate, NeitherPublisherNorReaderAllocatesAtOneKilohertz) {
  const std::int32_t total = warm_up + samples();
  auto probe = connect(lab_);
  auto level = probe.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();

  std::atomic<int> allocated_by_publisher{-1};  // publishes nothing but itself
  std::thread publisher([&] {
    gecos::TimePoint next = std::chrono::steady_clock::now();
    const auto publish = [&](std::int32_t value) {
      servant_.publish(value);
      sleep_until(next += period);
    };
    for (std::int32_t value = 1; value <= warm_up; ++value) publish(value);
    const robcl::CountAllocations count;
    for (std::int32_t value = warm_up + 1; value <= total; ++value) publish(value);
    allocated_by_publisher = count.so_far();
  });

  std::uint64_t got = 0;
  std::uint64_t lost = 0;
  std::int32_t first = 0;  // a reader that begins late counts only what it loses after that sample
  std::int32_t value = 0;
  const auto read = [&] {
    const auto sample = level->next(20s);
    if (!sample) return false;
    if (sample->value <= value) ADD_FAILURE() << sample->value << " after " << value;
    value = sample->value;
    if (first == 0) first = value;
    lost += sample->lost;
    ++got;
    return true;
  };
  while (value < warm_up && read()) {
  }
  const robcl::CountAllocations count;
  while (value < total && read()) {
  }
  const int allocated_by_reader = count.so_far();
  publisher.join();

  EXPECT_EQ(got + lost, static_cast<std::uint64_t>(total - first + 1))
      << lost << " samples were passed over";
  EXPECT_EQ(allocated_by_publisher, 0);
  EXPECT_EQ(allocated_by_reader, 0);
}

}  // namespace
