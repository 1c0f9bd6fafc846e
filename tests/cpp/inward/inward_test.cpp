// Inward streams from a generated client to a generated server, over every medium.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "../media/kind_names.hpp"
#include "../robcl/allocations.hpp"
#include "../settles.hpp"
#include "feeder_client.hpp"
#include "follower.hpp"
#include "gecos/broker/broker.hpp"

namespace {

using namespace std::chrono_literals;
using feeding::Dancer;
using feeding::in_words;
using feeding::Remark;
using feeding::Step;
using gecos::Detail;

constexpr std::int64_t second_ns = 1'000'000'000;

/// Nobody loses a lease here because the machine was busy.
gecos::LabOptions patient() {
  gecos::LabOptions options;
  options.lease_ttl = 20s;
  return options;
}

class InwardStreams : public ::testing::TestWithParam<gecos::media::Kind> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(broker_.serve(broker_server_, {gecos::media::Kind::Inproc}));
    gecos::ObjectOptions served;
    served.simulated = true;
    served.media = {GetParam()};
    const auto added = server_.add("DANCER", servant_, std::move(served));
    ASSERT_TRUE(added) << added.error().text;
    dancer_ = create(lab_);
    other_ = create(other_lab_);
  }
  static Dancer create(gecos::Lab& lab) {
    auto created = lab.create<Dancer>("DANCER");
    EXPECT_TRUE(created) << created.error();
    return created ? *created : Dancer();
  }
  /// Asks until `wanted` samples have been taken: over lcm a sample may be on its way.
  template <class T>
  static std::vector<T> taken(const std::function<gecos::Command<std::vector<T>>()>& ask,
                              std::size_t wanted) {
    std::vector<T> all;
    EXPECT_TRUE(settles([&] {
      const auto values = ask().get();
      if (!values) return false;
      all.insert(all.end(), values->begin(), values->end());
      return all.size() >= wanted;
    })) << all.size()
        << " came";
    return all;
  }
  std::vector<double> speeds(std::size_t wanted) {
    return taken<double>([&] { return other_.speeds(); }, wanted);
  }
  /// Lets the servant read `speed` until the counts are `wanted`.
  void expect_speed_told(const std::string& wanted) {
    std::string told;
    EXPECT_TRUE(settles([&] {
      static_cast<void>(other_.speeds().get());
      told = other_.told("speed").get().value_or("nothing");
      return told == wanted;
    })) << told;
  }

  gecos::Lab broker_lab_;
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  feeding::PlainFollower servant_;
  gecos::Lab server_lab_{patient()};
  gecos::Server server_{server_lab_};
  gecos::Lab lab_{patient()};
  gecos::Lab other_lab_{patient()};
  Dancer dancer_;
  Dancer other_;
};
INSTANTIATE_TEST_SUITE_P(Over, InwardStreams,
                         ::testing::Values(gecos::media::Kind::Inproc, gecos::media::Kind::Shm,
                                           gecos::media::Kind::Lcm),
                         gecos::media::name_of);

TEST_P(InwardStreams, ReachTheServantInOrder) {
  const auto lease = gecos::actor(dancer_);
  ASSERT_TRUE(lease) << lease.error();
  auto speed = dancer_.speed(gecos::writer);
  ASSERT_TRUE(speed) << speed.error();
  for (const double value : {0.5, 1.0, 1.5}) {
    const auto sent = speed->send(value);
    ASSERT_TRUE(sent) << sent.error();
  }
  EXPECT_EQ(speeds(3), (std::vector{0.5, 1.0, 1.5}));
  ASSERT_TRUE(speed->send(2.0));
  EXPECT_EQ(speeds(1), std::vector{2.0});
  EXPECT_EQ(in_words(speed->report().get().value()), "admitted 4");
  EXPECT_FALSE(speed->report().get()->expired);
}

/// A client that chooses the size of its samples itself.
struct Greedy : Dancer {
  explicit Greedy(const Dancer& dancer)
      : Object(dancer), Dancer(dancer) {}  // Object: a virtual base
  auto open(std::size_t largest) const {
    gecos::InwardDescription speed = feeding::FollowerInterface::speed_stream;
    speed.largest = largest;
    return gecos_session_->open_writer(speed).map([](const auto&) {});
  }
};

TEST_P(InwardStreams, OfSamplesThatTakeTheServersMemoryAreRefused) {
  EXPECT_TRUE(Greedy(dancer_).open(64 * 1024)) << "the interface of the client may be newer";
  const auto refused = Greedy(dancer_).open(64 * 1024 + 1);
  EXPECT_EQ(refused.has_value(), GetParam() != gecos::media::Kind::Shm)
      << "elsewhere samples have the bounds of the medium, or are of this process";
  if (!refused) {
    EXPECT_NE(refused.error().text.find("bytes, and the reader accepts at most "),
              std::string::npos)
        << refused.error().text;
  }
}

TEST_P(InwardStreams, AreNotSentWithoutALease) {
  auto speed = dancer_.speed(gecos::writer);
  ASSERT_TRUE(speed) << speed.error();
  const auto sent = speed->send(1.0);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().detail, Detail::Denied);
  EXPECT_EQ(sent.error().text,
            "a sample for inward stream 'speed' of DANCER was not sent: the stream needs actor "
            "status; hold a lease while you send: call actor(object) of gecos");
  EXPECT_EQ(in_words(speed->report().get().value()), "admitted 0");
  EXPECT_TRUE(speed->report().get()->expired) << "no sample has come";
}

TEST_P(InwardStreams, OfASensorNeedNoLease) {
  auto remark = dancer_.remark(gecos::writer);
  ASSERT_TRUE(remark) << remark.error();
  ASSERT_TRUE(remark->send(Remark{"ab ovo"}));
  ASSERT_TRUE(remark->send(Remark{""}));
  EXPECT_EQ(taken<std::string>([&] { return other_.remarks(); }, 2),
            (std::vector<std::string>{"ab ovo", ""}));
}

TEST_P(InwardStreams, OfASensorAreRefusedWhileAnotherIsMaster) {
  auto remark = dancer_.remark(gecos::writer);
  ASSERT_TRUE(remark) << remark.error();
  {
    const auto master = gecos::master(other_);
    ASSERT_TRUE(master) << master.error();
    ASSERT_TRUE(remark->send(Remark{"unheard"}));
    EXPECT_TRUE(settles([&] {
      EXPECT_EQ(other_.remarks().get().value(), std::vector<std::string>{});
      return other_.told("remark").get().value_or("").starts_with("admitted 0, no_status 1");
    }));
  }
  ASSERT_TRUE(remark->send(Remark{"heard"}));
  EXPECT_EQ(taken<std::string>([&] { return other_.remarks(); }, 1),
            std::vector<std::string>{"heard"});
}

TEST_P(InwardStreams, OutOfRangeAreNotSent) {
  const auto lease = gecos::actor(dancer_);
  auto speed = dancer_.speed(gecos::writer);
  auto alter = dancer_.alter(gecos::writer);
  ASSERT_TRUE(lease && speed && alter);
  for (const double wrong : {2.5, -0.1, std::nan("")}) {
    const auto sent = speed->send(wrong);
    ASSERT_FALSE(sent) << wrong;
    EXPECT_EQ(sent.error().detail, Detail::BadParameter);
  }
  EXPECT_EQ(speed->send(2.5).error().text,
            "speed: 2.5 is outside [0.0, 2.0] m/s; give at most 2.0 m/s");
  EXPECT_FALSE(alter->send(Step{0.5, 1}));
  EXPECT_EQ(speeds(0), std::vector<double>{});
  EXPECT_EQ(in_words(speed->report().get().value()), "admitted 0");
}

TEST_P(InwardStreams, ThatWaitWhenTheLeaseIsReleasedHaveNoEffect) {
  auto speed = dancer_.speed(gecos::writer);
  ASSERT_TRUE(speed) << speed.error();
  {
    const auto lease = gecos::actor(dancer_);
    ASSERT_TRUE(lease) << lease.error();
    ASSERT_TRUE(speed->send(1.0));
  }
  expect_speed_told(
      "admitted 0, no_status 1; the sender does not have the status, or the status has ended");
  const auto known = speed->report().get();
  ASSERT_TRUE(known) << known.error();
  EXPECT_EQ(known->no_status, 1u) << "the sender learns of it";
}

TEST_P(InwardStreams, OfAStatusThatAnotherHasTakenOverHaveNoEffect) {
  auto speed = dancer_.speed(gecos::writer);
  auto theirs = other_.speed(gecos::writer);
  ASSERT_TRUE(speed && theirs);
  {
    const auto lease = gecos::actor(dancer_);
    ASSERT_TRUE(lease) << lease.error();
    ASSERT_TRUE(speed->send(1.0));
  }
  const auto lease = gecos::actor(other_);
  ASSERT_TRUE(lease) << lease.error();
  ASSERT_TRUE(theirs->send(2.0));
  EXPECT_EQ(speeds(1), std::vector{2.0});
  expect_speed_told(
      "admitted 1, no_status 1; the sender does not have the status, or the status has ended");
}

TEST_P(InwardStreams, FromBeforeAStopHaveNoEffectAndLaterOnesDo) {
  const auto lease = gecos::actor(dancer_);
  auto speed = dancer_.speed(gecos::writer);
  ASSERT_TRUE(lease && speed);
  ASSERT_TRUE(speed->send(1.0));
  ASSERT_TRUE(gecos::stop(dancer_).get());  // renews the lease of its own session
  expect_speed_told(
      "admitted 0, no_status 1; the sender does not have the status, or the status has ended");
  ASSERT_TRUE(speed->send(0.25));
  EXPECT_EQ(speeds(1), std::vector{0.25});
}

TEST_P(InwardStreams, HaveNoEffectWhileAnotherProgramHasTakenOverTheSharedStatus) {
  const auto lease = gecos::actor(dancer_, "two hands");
  const auto others = gecos::actor(other_, "two hands");
  auto speed = dancer_.speed(gecos::writer);
  auto takers = other_.speed(gecos::writer);
  ASSERT_TRUE(lease && others && speed && takers);
  ASSERT_TRUE(speed->send(1.0));
  EXPECT_EQ(speeds(1), std::vector{1.0});
  ASSERT_TRUE(gecos::take_over(other_).get());
  ASSERT_TRUE(speed->send(2.0));  // under the epoch from before
  expect_speed_told(
      "admitted 1, no_status 1; the sender does not have the status, or the status has ended");
  ASSERT_TRUE(gecos::ping(dancer_).get());  // tells it the newer epoch
  ASSERT_TRUE(speed->send(0.5));
  expect_speed_told(
      "admitted 1, no_status 2; the sender does not have the status, or the status has ended");
  ASSERT_TRUE(takers->send(1.5));
  EXPECT_EQ(speeds(1), std::vector{1.5});
  ASSERT_TRUE(gecos::give_back(other_).get());
  ASSERT_TRUE(speed->send(0.25));
  EXPECT_EQ(speeds(1), std::vector{0.25});
}

TEST_P(InwardStreams, ThatAreOlderThanTheWatchdogHaveNoEffect) {
  const auto lease = gecos::actor(dancer_);
  auto alter = dancer_.alter(gecos::writer);
  ASSERT_TRUE(lease && alter);
  ASSERT_TRUE(alter->send(Step{0.01, 1}, gecos::unix_now_ns() - 30 * second_ns));
  ASSERT_TRUE(alter->send(Step{0.01, 2}));
  EXPECT_EQ(taken<std::int32_t>([&] { return other_.steps(); }, 1), std::vector<std::int32_t>{2});
  const auto known = alter->report().get();
  ASSERT_TRUE(known) << known.error();
  EXPECT_EQ(
      in_words(*known),
      "admitted 1, too_old 1; the sample is older than the watchdog or the lifespan of the stream");
  EXPECT_FALSE(known->expired);
}

TEST_P(InwardStreams, LoseTheOldestWhenTheServantReadsTooRarely) {
  const auto lease = gecos::actor(dancer_);
  auto alter = dancer_.alter(gecos::writer);
  ASSERT_TRUE(lease && alter);
  std::vector<std::int32_t> counts;
  constexpr std::int32_t sent = 100;
  for (std::int32_t count = 1; count <= sent; ++count) ASSERT_TRUE(alter->send(Step{0, count}));
  EXPECT_TRUE(settles([&] {
    const auto now = other_.steps().get();
    if (now) counts.insert(counts.end(), now->begin(), now->end());
    return !counts.empty() && counts.back() == sent;
  }));
  EXPECT_TRUE(std::ranges::is_sorted(counts));
  const auto known = alter->report().get();
  ASSERT_TRUE(known) << known.error();
  EXPECT_EQ(known->admitted, counts.size());
  EXPECT_EQ(known->admitted + known->lost, static_cast<std::uint64_t>(sent));
  if (GetParam() != gecos::media::Kind::Lcm) {
    EXPECT_EQ(known->admitted, 8u) << "the declared depth";
  }
}

TEST_P(InwardStreams, FeedTheCommandThatRuns) {
  const auto lease = gecos::actor(dancer_);
  auto alter = dancer_.alter(gecos::writer);
  ASSERT_TRUE(lease && alter);
  const auto follow = dancer_.follow();
  ASSERT_TRUE(settles([&] { return follow.feedback().has_value(); })) << "it runs";
  ASSERT_TRUE(alter->send(Step{0.1, 7}));  // feeds nothing
  alter->feeds(follow);
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(alter->send(Step{0.025, i}));
    ASSERT_TRUE(settles([&] { return follow.feedback()->count == i && follow.feedback()->x > 0; }));
  }
  ASSERT_TRUE(alter->send(Step{0, -1}));
  const auto sum = follow.get();
  ASSERT_TRUE(sum) << sum.error();
  EXPECT_NEAR(*sum, 0.1, 1e-12);
  ASSERT_TRUE(alter->send(Step{0.1, 8}));  // the command has ended
  EXPECT_TRUE(settles([&] {
    EXPECT_EQ(other_.steps().get().value(), std::vector<std::int32_t>{});
    return in_words(alter->report().get().value()) ==
           "admitted 5, command_not_running 2; its command does not run";
  })) << in_words(alter->report().get().value());
}

TEST_P(InwardStreams, OfAnotherSessionDoNotFeedACommand) {
  const auto lease = gecos::actor(dancer_, "shared");
  const auto shared = gecos::actor(other_, "shared");
  auto theirs = other_.alter(gecos::writer);
  ASSERT_TRUE(lease && shared && theirs);
  auto follow = dancer_.follow();
  ASSERT_TRUE(settles([&] { return follow.feedback().has_value(); })) << "it runs";
  theirs->feeds(follow);
  const auto sent = theirs->send(Step{0.1, -1});
  ASSERT_FALSE(sent);
  EXPECT_TRUE(
      sent.error().text.ends_with("the command that the sample feeds belongs to another session"))
      << sent.error().text;
  theirs->feeds_no_command();
  ASSERT_TRUE(theirs->send(Step{0.1, -1}));
  EXPECT_TRUE(settles([&] {
    return in_words(theirs->report().get().value()) ==
           "admitted 0, command_not_running 1; its command does not run";
  }));
  EXPECT_EQ(follow.state(), gecos::State::Running);
  follow.cancel();
  EXPECT_FALSE(follow.get());
}

TEST_P(InwardStreams, OfASessionThatHasEndedHaveNoEffect) {
  {
    gecos::Lab gone(patient());
    const Dancer dancer = create(gone);
    const auto lease = gecos::actor(dancer);
    auto speed = dancer.speed(gecos::writer);
    ASSERT_TRUE(lease && speed);
    ASSERT_TRUE(speed->send(1.0));
    ASSERT_TRUE(speed->report().get()) << "the sample was sent before";
    gone.close();
    EXPECT_TRUE(speed->lost());
    EXPECT_FALSE(speed->send(1.0));
  }
  // A goodbye ends the status first; a connection that is lost ends the session at once.
  EXPECT_TRUE(settles([&] {
    EXPECT_EQ(other_.speeds().get().value(), std::vector<double>{});
    const auto told = other_.told("speed").get().value_or("");
    return told.starts_with("admitted 0, session_ended 1") ||
           told.starts_with("admitted 0, no_status 1");
  })) << other_.told("speed").get().value_or("");
}

TEST_P(InwardStreams, OfANewerWriterTakeThePlaceOfTheEarlier) {
  const auto lease = gecos::actor(dancer_);
  auto first = dancer_.speed(gecos::writer);
  ASSERT_TRUE(lease && first);
  ASSERT_TRUE(first->send(0.5));
  EXPECT_EQ(speeds(1), std::vector{0.5});
  auto second = dancer_.speed(gecos::writer);
  ASSERT_TRUE(second) << second.error();
  ASSERT_TRUE(second->send(1.5));
  EXPECT_EQ(speeds(1), std::vector{1.5});
}

TEST_P(InwardStreams, OfAWriterThatWasClosedCanStillBeRead) {
  const auto lease = gecos::actor(dancer_);
  ASSERT_TRUE(lease) << lease.error();
  {
    auto speed = dancer_.speed(gecos::writer);
    ASSERT_TRUE(speed) << speed.error();
    ASSERT_TRUE(speed->send(0.5));
  }
  EXPECT_EQ(speeds(1), std::vector{0.5});
}

TEST_P(InwardStreams, AllocateNothingInTheSteadyState) {
  const auto lease = gecos::actor(dancer_);
  auto speed = dancer_.speed(gecos::writer);
  ASSERT_TRUE(lease && speed);
  const auto one_sample = [&] {
    const bool sent = speed->send(1.0).has_value();
    return sent && settles([&] { return servant_.speed().next().has_value(); });
  };
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(one_sample());
  const robcl::CountAllocations counted;
  bool all = true;
  for (int i = 0; i < 50; ++i) all = all && one_sample();
  EXPECT_EQ(counted.so_far(), 0);
  EXPECT_TRUE(all);
}

TEST_P(InwardStreams, OfANilProxyCannotBeOpened) {
  const auto speed = Dancer().speed(gecos::writer);
  ASSERT_FALSE(speed);
  EXPECT_EQ(speed.error().detail, Detail::NoServer);
}

}  // namespace
