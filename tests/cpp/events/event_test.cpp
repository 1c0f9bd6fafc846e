// Events from a generated server to a generated client, over every medium.
#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "../media/kind_names.hpp"
#include "../settles.hpp"
#include "button_client.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"
#include "sender.hpp"

namespace {

using namespace std::chrono_literals;
using buttons::Alarm;
using gecos::Detail;

class Events : public ::testing::TestWithParam<gecos::media::Kind> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(broker_.serve(broker_server_, {gecos::media::Kind::Inproc}));
    gecos::ObjectOptions served;
    served.simulated = true;
    served.media = {GetParam()};
    const auto added = server_.add("ALARM", servant_, std::move(served));
    ASSERT_TRUE(added) << added.error().text;
    auto created = lab_.create<Alarm>("ALARM");
    ASSERT_TRUE(created) << created.error();
    alarm_ = *created;
  }
  void press(const std::string& who, double force, std::uint32_t times) {
    const auto pressed = alarm_.press(who, force, times).get();
    ASSERT_TRUE(pressed) << pressed.error();
  }

  gecos::Lab broker_lab_;
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  gecos::Lab lab_;
  buttons::Sender servant_;
  gecos::Server server_{lab_};
  Alarm alarm_;
};

TEST_P(Events, ReachASubscriberOnceAndInOrder) {
  auto pressed = alarm_.pressed(gecos::stream).value();
  press("ann", 2.5, 2);
  press("bob", 0.5, 1);
  for (const std::string who : {"ann", "ann", "bob"}) {
    const auto event = pressed.next(10s);
    ASSERT_TRUE(event) << event.error();
    EXPECT_EQ(event->value.who, who);
    EXPECT_EQ(event->value.force, who == "ann" ? 2.5 : 0.5);
    EXPECT_EQ(event->lost, 0U);
  }
  EXPECT_FALSE(pressed.next(0ms)) << "each once";
  EXPECT_EQ(pressed.latest()->value.who, "bob");
}

TEST_P(Events, BeginAfterTheSubscription) {
  auto early = alarm_.pressed(gecos::stream).value();
  press("long ago", 1, 3);
  ASSERT_TRUE(early.next(10s));
  auto late = alarm_.pressed(gecos::stream).value();
  EXPECT_FALSE(late.latest()) << "nothing has occurred";
  EXPECT_FALSE(late.next(0ms));
  press("now", 1, 1);
  const auto event = late.next(10s);
  ASSERT_TRUE(event) << event.error();
  EXPECT_EQ(event->value.who, "now");
  EXPECT_EQ(event->lost, 0U);
}

TEST_P(Events, BeginAfterTheFirstSubscriptionOfAll) {
  press("long ago", 1, 3);  // nobody has ever subscribed
  auto pressed = alarm_.pressed(gecos::stream).value();
  EXPECT_FALSE(pressed.latest());
  press("now", 1, 1);
  const auto event = pressed.next(10s);
  ASSERT_TRUE(event) << event.error();
  EXPECT_EQ(event->value.who, "now");
  EXPECT_EQ(event->lost, 0U);
}

TEST_P(Events, TheFirstReadingTellsHowManyWereMissed) {
  auto lifted = alarm_.lifted(gecos::stream).value();
  ASSERT_TRUE(alarm_.lift(10).get());
  std::uint64_t heard = 0, lost = 0;
  while (heard + lost < 10) {
    const auto event = lifted.next(10s);
    ASSERT_TRUE(event) << event.error() << " after " << heard << " and " << lost;
    ++heard;
    lost += event->lost;
  }
  EXPECT_EQ(heard + lost, 10U);
  if (GetParam() == gecos::media::Kind::Lcm) return;  // events may still come while they are read
  EXPECT_EQ(heard, 4U) << "the depth of the event";
}

TEST_P(Events, MayBeSentByAnyThread) {
  constexpr std::uint64_t of_each = 50;
  auto pressed = alarm_.pressed(gecos::stream).value();
  std::vector<std::jthread> senders;
  for (const std::string who : {"ann", "bob", "eve"}) {
    senders.emplace_back([this, who] {
      for (std::uint64_t i = 0; i < of_each; ++i) servant_.publish_pressed({who, 1});
    });
  }
  for (std::uint64_t told = 0; told < 3 * of_each;) {
    const auto event = pressed.next(10s);
    ASSERT_TRUE(event) << event.error() << " after " << told;
    told += 1 + event->lost;
    ASSERT_LE(told, 3 * of_each);
    ASSERT_EQ(event->value.who.size(), 3U);
  }
}

TEST_P(Events, AnEventOutOfRangeIsNotSent) {
  auto pressed = alarm_.pressed(gecos::stream).value();
  press("strong", 10.5, 1);
  press("weak", 1, 1);
  const auto event = pressed.next(10s);
  ASSERT_TRUE(event) << event.error();
  EXPECT_EQ(event->value.who, "weak");
  EXPECT_EQ(event->lost, 0U);
}

TEST_P(Events, HaveAHistoryThatBeginsAfterTheSubscriptionAndIsAsLongAsTheirDepth) {
  auto early = alarm_.lifted(gecos::stream).value();
  ASSERT_TRUE(alarm_.lift(3).get());
  EXPECT_TRUE(settles([&] { return early.history().size() == 3; }));
  auto late = alarm_.lifted(gecos::stream).value();
  EXPECT_TRUE(late.history().empty()) << "those events are over";
  ASSERT_TRUE(alarm_.lift(1).get());
  const auto newest = [](auto& events) {
    const auto kept = events.history();
    return kept.empty() ? 0 : kept.back().sequence;
  };
  EXPECT_TRUE(settles([&] { return newest(late) == 4; }));
  EXPECT_EQ(late.history().size(), 1U);
  EXPECT_TRUE(settles([&] { return newest(early) == 4; }));
  EXPECT_EQ(early.history().size(), 4U);
  ASSERT_TRUE(alarm_.lift(1).get());
  EXPECT_TRUE(settles([&] { return newest(early) == 5; }));
  const auto kept = early.history();
  EXPECT_EQ(kept.size(), 4U) << "the depth of the event";
  EXPECT_EQ(kept.front().sequence, 2U);
  EXPECT_EQ(late.next(10s)->sequence, 4U) << "the history reads nothing";
}

TEST_P(Events, AreGivenToAFunctionOnceAndInOrder) {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> told;
  auto listening = gecos::listen(alarm_.pressed(gecos::stream).value(), [&](const auto& event) {
    const std::lock_guard lock(mutex);
    told.push_back(event.value.who);
    changed.notify_all();
  });
  press("ann", 2.5, 2);
  press("bob", 0.5, 1);
  {
    std::unique_lock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, 30s, [&] { return told.size() == 3; }));
  }
  listening.close();
  EXPECT_EQ(told, (std::vector<std::string>{"ann", "ann", "bob"}));
}

TEST_P(Events, NeedTheStatusThatTheyDeclare) {
  const auto refused = alarm_.silenced(gecos::stream);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::Denied) << refused.error();
  const auto lease = gecos::actor(alarm_);
  auto silenced = alarm_.silenced(gecos::stream).value();
  ASSERT_TRUE(alarm_.silence(7).get());
  const auto event = silenced.next(10s);
  ASSERT_TRUE(event) << event.error();
  EXPECT_EQ(event->value.zone, 7);
}

INSTANTIATE_TEST_SUITE_P(Over, Events,
                         ::testing::Values(gecos::media::Kind::Inproc, gecos::media::Kind::Shm,
                                           gecos::media::Kind::Lcm),
                         gecos::media::name_of);

}  // namespace
