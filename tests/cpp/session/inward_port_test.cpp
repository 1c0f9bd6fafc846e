// The port of an inward stream alone, with a clock that the test moves.
#include "gecos/session/server/inward_port.hpp"

#include <gtest/gtest.h>

#include "../inward/in_words.hpp"
#include "../robcl/allocations.hpp"
#include "gecos/media/sealed/inward.hpp"
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
  explicit Sender(std::uint64_t session) : header{SessionId{session}, Epoch{3}, 0} {
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
  std::shared_ptr<media::SampleBuffer> samples = std::make_shared<media::SampleBuffer>(4);
  std::shared_ptr<FeedStanding> standing = std::make_shared<FeedStanding>();
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
  FakeClock clock_;
  InwardPort port_{stream, clock_};
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
  EXPECT_EQ(in_words(port_.report()),
            "admitted 1, too_old 1; it is older than the watchdog of the stream");
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
  port_.feed_command(9, 4);
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
  port_.feed_command(9, 4);
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
  port_.feed_no_command();
  ada_.send({SessionId{9}, Epoch{3}, 4}, 5, now);
  ada_.send(6, now);
  EXPECT_EQ(next(), 6);
  ada_.send(7, now);
  EXPECT_EQ(next(Unfed::Refused), std::nullopt) << "the servant wants samples of commands alone";
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
  EXPECT_EQ(in_words(port_.report()), "admitted 0, other_session 1; it names another session");
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

}  // namespace
}  // namespace gecos::session
