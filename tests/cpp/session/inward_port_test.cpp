// The port of an inward stream alone, with a clock that the test moves.
#include "gecos/session/server/inward_port.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "../inward/in_words.hpp"
#include "../robcl/allocations.hpp"
#include "gecos/media/sealed/inward.hpp"
#include "gecos/servant.hpp"
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos::session {
namespace {

using namespace std::chrono_literals;
using feeding::in_words;

constexpr InwardDescription stream{.code = FunctionCode{300},
                                   .name = "alter",
                                   .watchdog = 48ms,
                                   .largest = 8,
                                   .quality = {.depth = 4}};

/// A session with a stream in memory. What it sends names it rightly unless told otherwise.
struct Sender {
  explicit Sender(std::uint64_t session, std::size_t depth = 4)
      : header{SessionId{session}, Epoch{3}, 0},
        samples(std::make_shared<media::SampleBuffer>(depth)) {
    standing->set(access::Status::Actor, Epoch{3});
  }
  Feeder feeder(std::uint32_t id = 1) const {
    return {header.session, id, std::make_unique<media::InwardReader>(samples), standing,
            [difference = difference] { return difference; }};
  }
  void send(double value, TimePoint measured) { send(header, value, measured); }
  void send(const InwardHeader& named, double value, TimePoint measured) {
    Bytes bytes(inward_header_size + 8);
    write_inward_header(std::span(bytes).first<inward_header_size>(), named);
    wire::Encoder(std::span(bytes).subspan(inward_header_size)).put(value);
    append_measured(bytes, measured);
    samples->put(++sequence, 0, bytes);
  }

  InwardHeader header;
  Duration difference{};
  std::uint64_t sequence = 0;
  std::shared_ptr<media::SampleBuffer> samples;
  std::shared_ptr<FeedStanding> standing = std::make_shared<FeedStanding>();
};

/// A command of session 9 whose handler runs.
struct Running final : CallCore {
  explicit Running(std::uint64_t its_counter) : counter(its_counter) { client.session = 9; }
  const OperationDescription& operation() const override { return described; }
  ByteView arguments() const override { return {}; }
  const Caller& caller() const override { return client; }
  std::uint64_t counter_in_session() const override { return counter; }
  bool interrupted() const override { return told_to_stop; }
  bool wait_interrupted_until(TimePoint) override { return told_to_stop; }
  void progress(double, ByteView) override {}
  void finish(ByteView) override {}
  void fail(Failure) override {}

  const OperationDescription described{};
  Caller client;
  const std::uint64_t counter;
  bool told_to_stop = false;
};

class Port : public ::testing::Test {
 protected:
  std::optional<double> next(Unfed unfed = Unfed::Taken) {
    if (!port_.next(raw_, unfed)) return std::nullopt;
    double value = 0;
    wire::Decoder from(raw_.value);
    EXPECT_TRUE(from.get(value, "value"));
    return value;
  }
  std::uint64_t feed(std::uint64_t counter) {
    return port_.begin_feeding(std::make_shared<Running>(counter));
  }
  /// Sends a sample of `ada_` that feeds her command `counter`.
  void send_for(std::uint64_t counter, double value) {
    ada_.send({SessionId{9}, Epoch{3}, counter}, value, clock_.since_boot());
  }

  FakeClock clock_;
  PauseWatch pauses_;
  NameClaim claim_;
  access::ObjectPresence presence_{"CELL"};
  access::ObjectPresence no_zone_{""};
  InwardPort port_{stream, clock_, pauses_, claim_, no_zone_};
  Sender ada_{9};
  RawInward raw_;
};

TEST_F(Port, TheWatchdogExpiresExactlyAfterItsTimeWithoutASample) {
  port_.add(ada_.feeder());
  EXPECT_TRUE(port_.expired()) << "no sample has come";
  ada_.send(1, clock_.since_boot());
  EXPECT_TRUE(port_.expired()) << "the servant has not read it";
  ASSERT_EQ(next(), 1);
  EXPECT_FALSE(port_.expired());
  clock_.advance(48ms);
  EXPECT_FALSE(port_.expired());
  clock_.advance(1ns);
  EXPECT_TRUE(port_.expired());
  EXPECT_TRUE(port_.report().expired);
  ada_.send(2, clock_.since_boot());
  ASSERT_EQ(next(), 2);
  EXPECT_FALSE(port_.expired()) << "samples come again";
}

TEST_F(Port, TheWatchdogRunsFromTheMeasurement) {
  port_.add(ada_.feeder());
  ada_.send(1, clock_.since_boot());
  clock_.advance(40ms);
  ASSERT_EQ(next(), 1);
  EXPECT_EQ(raw_.age, 40ms);
  clock_.advance(8ms);
  EXPECT_FALSE(port_.expired());
  clock_.advance(1ns);
  EXPECT_TRUE(port_.expired());
}

TEST_F(Port, ASampleThatIsOlderThanTheWatchdogIsRefused) {
  port_.add(ada_.feeder());
  ada_.send(1, clock_.since_boot());
  clock_.advance(48ms);
  ada_.send(2, clock_.since_boot());
  clock_.advance(1ns);
  EXPECT_EQ(next(), 2);
  EXPECT_EQ(
      in_words(port_.report()),
      "admitted 1, too_old 1; the sample is older than the watchdog or the lifespan of the stream");
}

TEST_F(Port, ASampleIsRefusedWhileNobodyIsPresentInTheZone) {
  InwardPort port(stream, clock_, pauses_, claim_, presence_);
  InwardDescription anyway = stream;
  anyway.presence = false;
  InwardPort unguarded(anyway, clock_, pauses_, claim_, presence_);
  port.add(ada_.feeder());
  unguarded.add(ada_.feeder());
  const auto send_and_take = [&](double value) {
    ada_.send(value, clock_.since_boot());
    EXPECT_TRUE(unguarded.next(raw_, Unfed::Taken)) << "@presence(FALSE)";
    return port.next(raw_, Unfed::Taken);
  };
  EXPECT_FALSE(send_and_take(1));
  presence_.take({true, 1, "anna has checked in"}, clock_.since_boot(), clock_.since_boot());
  EXPECT_TRUE(send_and_take(2));
  clock_.advance(1s);
  EXPECT_FALSE(send_and_take(3));
  EXPECT_EQ(in_words(port.report()),
            "admitted 1, no_status 2; nobody is known to be present in the zone of the object");
}

TEST_F(Port, ASampleThatWasSentBeforePresenceWasLostIsRefusedAfterItsReturn) {
  InwardDescription patient = stream;
  patient.watchdog = {};
  InwardPort port(patient, clock_, pauses_, claim_, presence_);
  port.add(ada_.feeder());
  const auto report = [&](bool present, std::uint64_t spell) {
    presence_.take({present, spell, "DOOR"}, clock_.since_boot(), clock_.since_boot());
  };
  report(true, 1);
  ada_.send(1, clock_.since_boot());
  clock_.advance(10ms);
  report(false, 1);
  ada_.send(2, clock_.since_boot());
  clock_.advance(1s);
  report(true, 2);
  EXPECT_FALSE(port.next(raw_, Unfed::Taken)) << "the servant has read nothing meanwhile";
  ada_.send(3, clock_.since_boot());
  EXPECT_TRUE(port.next(raw_, Unfed::Taken));
}

TEST_F(Port, ASampleThatIsOlderThanItsLifespanIsRefusedAlsoWithoutAWatchdog) {
  InwardDescription brief = stream;
  brief.watchdog = {};
  brief.quality.lifespan = 20ms;
  InwardPort port(brief, clock_, pauses_, claim_, no_zone_);
  port.add(ada_.feeder());
  ada_.send(1, clock_.since_boot());
  ada_.send(2, clock_.since_boot() + 1ns);
  clock_.advance(20ms + 1ns);
  ASSERT_TRUE(port.next(raw_, Unfed::Taken));
  EXPECT_EQ(raw_.age, 20ms);
  EXPECT_FALSE(port.next(raw_, Unfed::Taken));
  EXPECT_EQ(
      in_words(port.report()),
      "admitted 1, too_old 1; the sample is older than the watchdog or the lifespan of the stream");
}

TEST_F(Port, AgesAreJudgedByTheDifferenceOfTheClocks) {
  ada_.difference = 100s;
  port_.add(ada_.feeder());
  clock_.advance(200s);
  ada_.send(1, clock_.since_boot() - 100s - 10ms);
  ASSERT_EQ(next(), 1);
  EXPECT_EQ(raw_.age, 10ms);
  ada_.send(2, clock_.since_boot());  // measured in 100 s
  ASSERT_EQ(next(), 2);
  EXPECT_EQ(raw_.age, 0s);
  clock_.advance(49ms);
  EXPECT_TRUE(port_.expired()) << "a stamp in the future holds off no watchdog";
}

TEST_F(Port, ABeginningCommandHasOneWatchdogForItsFirstSample) {
  port_.add(ada_.feeder());
  clock_.advance(1s);
  feed(4);
  clock_.advance(48ms);
  EXPECT_FALSE(port_.expired());
  clock_.advance(1ns);
  EXPECT_TRUE(port_.expired());
}

TEST_F(Port, OnlyTheCommandThatTakesSamplesIsFed) {
  Sender bob(10);
  port_.add(ada_.feeder());
  port_.add(bob.feeder());
  const auto now = clock_.since_boot();
  const auto feeding = feed(4);
  ada_.send(1, now);
  ada_.send({SessionId{9}, Epoch{3}, 3}, 2, now);
  bob.send({SessionId{10}, Epoch{3}, 4}, 3, now);
  ada_.send({SessionId{9}, Epoch{3}, 4}, 4, now);
  EXPECT_EQ(next(), 4);
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(in_words(port_.report()),
            "admitted 1, command_not_running 3; its command does not run");
  EXPECT_EQ(in_words(port_.report_of(SessionId{10})),
            "admitted 0, command_not_running 1; its command does not run");
  port_.end_feeding(feeding);
  ada_.send({SessionId{9}, Epoch{3}, 4}, 5, now);
  ada_.send(6, now);
  EXPECT_EQ(next(), 6);
  ada_.send(7, now);
  EXPECT_EQ(next(Unfed::Refused), std::nullopt) << "the servant wants samples of commands alone";
}

TEST_F(Port, ACommandThatIsToldToStopTakesNoMoreSamples) {
  port_.add(ada_.feeder());
  const auto follow = std::make_shared<Running>(4);
  const auto feeding = port_.begin_feeding(follow);
  send_for(4, 1);
  send_for(4, 2);
  EXPECT_EQ(next(), 1);
  follow->told_to_stop = true;
  EXPECT_EQ(next(), std::nullopt);
  send_for(0, 3);
  EXPECT_EQ(next(), std::nullopt) << "its handler still reads";
  port_.end_feeding(feeding);
  send_for(0, 4);
  EXPECT_EQ(next(), 4);
}

TEST_F(Port, TheEndOfAnEarlierFeedingLeavesTheLaterOne) {
  port_.add(ada_.feeder());
  const auto first = feed(4);
  const auto second = feed(5);
  send_for(4, 1);
  send_for(5, 2);
  EXPECT_EQ(next(), 2);
  port_.end_feeding(first);
  send_for(0, 3);
  send_for(5, 4);
  EXPECT_EQ(next(), 4);
  const auto third = feed(6);
  port_.end_feeding(third);
  send_for(5, 5);
  EXPECT_EQ(next(), 5) << "the command before takes samples again";
  port_.end_feeding(second);
  send_for(0, 6);
  EXPECT_EQ(next(), 6);
}

TEST_F(Port, SamplesWaitUntilAPauseIsJudged) {
  port_.add(ada_.feeder());
  ASSERT_TRUE(pauses_.due(clock_.since_boot(), clock_.since_boot()));
  clock_.advance(PauseWatch::longest_gap + 1ms);
  ada_.send(1, clock_.since_boot());
  EXPECT_EQ(next(), std::nullopt) << "the maintenance thread has not seen the pause";
  ASSERT_TRUE(pauses_.tick(clock_.since_boot()));
  EXPECT_EQ(next(), std::nullopt) << "the pause is not judged";
  pauses_.judged(clock_.since_boot());
  EXPECT_EQ(next(), 1);
  EXPECT_EQ(in_words(port_.report()), "admitted 1");
}

TEST_F(Port, SamplesOfASilentClientWaitForItsHeartbeatAndThoseOfOthersDoNot) {
  Sender bob(10);
  port_.add(ada_.feeder());
  port_.add(bob.feeder());
  ada_.standing->set_unheard(true);
  ada_.send(1, clock_.since_boot());
  bob.send(2, clock_.since_boot());
  EXPECT_EQ(next(), 2);
  EXPECT_EQ(next(), std::nullopt);
  ada_.standing->set_unheard(false);
  EXPECT_EQ(next(), 1);
}

TEST_F(Port, SamplesWaitWhileTheBrokerIsAskedForTheNameAndAreRefusedWhenItDoesNotAnswer) {
  port_.add(ada_.feeder());
  claim_.ask();
  ada_.send(1, clock_.since_boot());
  EXPECT_EQ(next(), std::nullopt);
  ASSERT_TRUE(claim_.held(claim_.question()));
  EXPECT_EQ(next(), 1);
  claim_.ask();
  ada_.send(2, clock_.since_boot());
  ASSERT_TRUE(claim_.unanswered(claim_.question(), "no broker answers"));
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(in_words(port_.report()),
            "admitted 1, no_status 1; the broker does not confirm the name of the object");
  constexpr InwardDescription remarks{
      .code = FunctionCode{301}, .name = "remark", .status = access::Status::Sensor};
  InwardPort harmless(remarks, clock_, pauses_, claim_, presence_);
  ada_.standing->set(access::Status::Sensor, Epoch{3});
  harmless.add(ada_.feeder());
  ada_.send(3, clock_.since_boot());
  EXPECT_TRUE(harmless.next(raw_, Unfed::Taken)) << "moves nothing";
}

TEST_F(Port, EachSampleNeedsTheStatusOfItsEpochWhenItIsRead) {
  port_.add(ada_.feeder());
  const auto now = clock_.since_boot();
  ada_.send(1, now);
  ada_.standing->set(access::Status::Actor, Epoch{4});  // a stop has renewed it
  EXPECT_EQ(next(), std::nullopt);
  ada_.header.epoch = Epoch{4};
  ada_.send(2, now);
  EXPECT_EQ(next(), 2);
  ada_.send(3, now);
  ada_.standing->set(access::Status::Actor, std::nullopt);
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(port_.report().no_status, 2u);
  ada_.send({SessionId{9}, Epoch{0}, 0}, 4, now);
  EXPECT_EQ(next(), std::nullopt) << "no status is not epoch 0";
}

TEST_F(Port, ASampleThatNamesAnotherSessionIsRefused) {
  port_.add(ada_.feeder());
  ada_.send({SessionId{8}, Epoch{3}, 0}, 1, clock_.since_boot());
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(in_words(port_.report()),
            "admitted 0, other_session 1; the sample names another session");
}

TEST_F(Port, WhatASessionLeavesUnreadIsRefusedAndCounted) {
  port_.add(ada_.feeder());
  ada_.send(1, clock_.since_boot());
  ada_.send(2, clock_.since_boot());
  port_.depart(SessionId{9});
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(in_words(port_.report()), "admitted 0, session_ended 2; its session has ended");
}

TEST_F(Port, WhatDoesNotDecodeCountsAsRefusedAndDelaysNoWatchdog) {
  port_.add(ada_.feeder());
  ada_.send(1, clock_.since_boot());
  ASSERT_EQ(next(), 1);
  clock_.advance(40ms);
  ada_.send(99, clock_.since_boot());
  ASSERT_EQ(next(), 99);
  port_.unreadable(raw_, "'alter' is 99, outside [0, 2]");
  EXPECT_EQ(in_words(port_.report()), "admitted 1, unreadable 1; 'alter' is 99, outside [0, 2]");
  clock_.advance(9ms);
  EXPECT_TRUE(port_.expired());
}

TEST_F(Port, WhatWasSentBeforeItsStreamEndedCanBeRead) {
  port_.add(ada_.feeder(1));
  ada_.send(1, clock_.since_boot());
  port_.end(SessionId{9}, 1);
  EXPECT_EQ(next(), 1);
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(in_words(port_.report_of(SessionId{9})), "admitted 1");
}

TEST_F(Port, WhatIsUnreadWhenANewerStreamTakesThePlaceIsLostAndCounted) {
  port_.add(ada_.feeder(1));
  ada_.send(1, clock_.since_boot());
  ASSERT_EQ(next(), 1);
  ada_.send(2, clock_.since_boot());
  ada_.send(3, clock_.since_boot());
  ada_.samples = std::make_shared<media::SampleBuffer>(4);
  ada_.sequence = 0;
  port_.add(ada_.feeder(2));
  EXPECT_FALSE(port_.has(SessionId{9}, 1));
  port_.end(SessionId{9}, 1);  // arrives late
  ada_.send(4, clock_.since_boot());
  EXPECT_EQ(next(), 4);
  EXPECT_EQ(in_words(port_.report_of(SessionId{9})), "admitted 2, lost 2");
}

TEST_F(Port, SendersTakeTurns) {
  Sender bob(10);
  port_.add(ada_.feeder());
  port_.add(bob.feeder());
  const auto now = clock_.since_boot();
  for (const double value : {1, 2, 3}) ada_.send(value, now);
  for (const double value : {11, 12}) bob.send(value, now);
  std::vector<double> values;
  while (const auto value = next()) values.push_back(*value);
  EXPECT_EQ(values, (std::vector<double>{1, 11, 2, 12, 3}));
}

TEST_F(Port, AHostileSenderDelaysOneReadForABoundedTime) {
  port_.add(ada_.feeder());
  ada_.standing->set(access::Status::Actor, std::nullopt);
  struct Endless final : media::CopyingReader {
    bool latest(std::uint64_t, media::StreamSample&) override { return false; }
    bool next(std::uint64_t after, media::StreamSample& into) override {
      into.sequence = after + 1;
      into.bytes.assign(inward_header_size + measured_bytes, std::byte{});
      return true;
    }
    std::vector<media::StreamSample> stored() override { return {}; }
  };
  Feeder mallory = Sender(66).feeder();
  mallory.reader = std::make_unique<Endless>();
  port_.add(std::move(mallory));
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(port_.report().other_session, 8u);
}

TEST_F(Port, ReadingAndRefusingAllocateNothing) {
  port_.add(ada_.feeder());
  const auto now = clock_.since_boot();
  const auto round = [&] {
    for (int i = 0; i < 3; ++i) {
      const bool read = port_.next(raw_, Unfed::Taken);
      EXPECT_EQ(read, i < 2);
    }
  };
  for (int i = 0; i < 2; ++i) ada_.send(i, now);
  round();
  for (int i = 0; i < 2; ++i) ada_.send(i, now);
  ada_.send({SessionId{8}, Epoch{3}, 0}, 1, now);
  const robcl::CountAllocations counted;
  round();
  EXPECT_FALSE(port_.expired());
  EXPECT_EQ(counted.so_far(), 0);
}

// A random schedule beside a model that is not incremental: it keeps every sample that was sent and
// when it was read, and derives each answer and each count from the definitions.

class InwardWorld {
 public:
  InwardWorld(std::uint32_t seed, const InwardDescription& described)
      : random_(seed), stream_(described) {
    port_.add(sender_.feeder(writer_));
  }

  void step() {
    clock_.advance(Duration(pick(0, 9) == 0 ? pick(0, 60'000) : pick(0, 4'000)));
    switch (pick(0, 19)) {
      case 0:
        return replace_writer();
      case 1:
        return;  // nothing happens for a while
      default:
        return pick(0, 1) == 0 ? send() : next();
    }
  }

 private:
  struct Sent {
    std::uint32_t writer;
    std::uint64_t sequence;
    double value;
    TimePoint measured;
    std::optional<TimePoint> read{};
  };

  std::int64_t pick(std::int64_t least, std::int64_t most) {
    return std::uniform_int_distribution<std::int64_t>(least, most)(random_);
  }

  void send() {
    // A negative delay is that of a sender whose clock is ahead.
    const Duration late(pick(0, 3) == 0 ? pick(-2'000, 30'000) : 0);
    const TimePoint measured = clock_.since_boot() - late;
    const auto value = static_cast<double>(sent_.size());
    sender_.send(value, measured);
    sent_.push_back({writer_, sender_.sequence, value, measured});
  }

  void replace_writer() {
    sender_.samples = std::make_shared<media::SampleBuffer>(stream_.quality.depth);
    sender_.sequence = 0;
    port_.add(sender_.feeder(++writer_));
  }

  void next() {
    std::optional<double> expected;
    for (Sent* const each : stored()) {
      each->read = clock_.since_boot();
      if (too_old(*each)) continue;
      expected = each->value;
      break;
    }
    std::optional<double> got;
    if (port_.next(raw_, Unfed::Taken)) {
      wire::Decoder from(raw_.value);
      EXPECT_TRUE(from.get(got.emplace(), "value"));
    }
    EXPECT_EQ(got, expected);
    const FeedReport report = port_.report();
    EXPECT_EQ(report.admitted,
              count([&](const Sent& each) { return each.read && !too_old(each); }));
    EXPECT_EQ(report.too_old, count([&](const Sent& each) { return each.read && too_old(each); }));
    EXPECT_EQ(report.lost, lost());
    EXPECT_EQ(report.expired, watchdog_expired());
    EXPECT_EQ(port_.expired(), watchdog_expired());
  }

  // What the definitions say.
  bool of_this_writer(const Sent& sample) const { return sample.writer == writer_; }
  /// What the buffer still has for the servant, the oldest first.
  std::vector<Sent*> stored() {
    std::vector<Sent*> there;
    for (Sent& each : sent_) {
      const bool kept = each.sequence + stream_.quality.depth > sender_.sequence;
      if (of_this_writer(each) && kept && !each.read) there.push_back(&each);
    }
    return there;
  }
  static Duration age(const Sent& sample) {
    return std::max(*sample.read - sample.measured, Duration::zero());
  }
  bool too_old(const Sent& sample) const {
    const auto beyond = [&](Duration limit) { return limit > Duration{} && age(sample) > limit; };
    return beyond(stream_.watchdog) || beyond(stream_.quality.lifespan);
  }
  /// Counts the unread samples of earlier writers, and those before a sample that was read.
  std::uint64_t lost() const {
    std::uint64_t newest_read = 0;
    for (const Sent& each : sent_) {
      if (of_this_writer(each) && each.read) newest_read = std::max(newest_read, each.sequence);
    }
    return count([&](const Sent& each) {
      return !each.read && (!of_this_writer(each) || each.sequence < newest_read);
    });
  }
  bool watchdog_expired() const {
    if (stream_.watchdog == Duration{}) return false;
    return std::ranges::none_of(sent_, [&](const Sent& each) {
      if (!each.read || too_old(each)) return false;
      return clock_.since_boot() - std::min(each.measured, *each.read) <= stream_.watchdog;
    });
  }
  template <class Which>
  std::uint64_t count(const Which& which) const {
    return static_cast<std::uint64_t>(std::ranges::count_if(sent_, which));
  }

  std::mt19937 random_;
  const InwardDescription stream_;
  FakeClock clock_;
  PauseWatch pauses_;
  NameClaim claim_;
  access::ObjectPresence presence_{""};
  InwardPort port_{stream_, clock_, pauses_, claim_, presence_};
  Sender sender_{9, stream_.quality.depth};
  RawInward raw_;
  std::uint32_t writer_ = 1;
  std::vector<Sent> sent_;
};

TEST(InwardPort, AdmitsAndCountsExactlyWhatAModelPredictsOnRandomSchedules) {
  constexpr int steps = 300;  // each derives its answers from all that came before
  for (std::uint32_t seed = 0; seed < 210; ++seed) {
    InwardDescription described = stream;
    described.quality.depth = 1 + seed % 7;
    described.watchdog = seed % 3 == 0 ? Duration{} : Duration(1'500 + 5'003 * (seed % 4));
    if (seed % 2 != 0) described.quality.lifespan = Duration(1'000 + 7'919 * (seed % 5));
    InwardWorld world(seed, described);
    for (int step = 0; step < steps; ++step) world.step();
    if (::testing::Test::HasFailure()) FAIL() << "seed " << seed;
  }
}

}  // namespace
}  // namespace gecos::session
