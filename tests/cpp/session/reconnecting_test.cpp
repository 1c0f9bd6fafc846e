#include "gecos/reconnecting.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <thread>

#include "place.hpp"
#include "probe.hpp"

namespace gecos {
namespace {

using namespace std::chrono_literals;

/// A broker, and a server that the test starts and ends.
class ReconnectingTest : public ::testing::Test {
 protected:
  struct Process {
    Lab lab;
    Server server{lab};
  };
  void start() {
    process_ = std::make_unique<Process>();
    ObjectOptions options;
    options.media = {media::Kind::Inproc};
    const auto added = process_->server.add("PROBE", servant_, options);
    ASSERT_TRUE(added) << added.error().text;
  }
  void end() { process_.reset(); }

  static ReconnectOptions at_once() {
    ReconnectOptions options;
    options.between_tries = 0s;
    return options;
  }
  static int read(Reconnecting<probe::Probe>& probe) {
    const auto level = probe.call([](const probe::Probe& there) { return there.read().get(); });
    EXPECT_TRUE(level) << level.error();
    return level.value_or(-1);
  }

  const probe::Place place_;
  const probe::BrokerHere broker_;
  probe::ProbeServant servant_;
  std::unique_ptr<Process> process_;
  Lab lab_;
};

TEST_F(ReconnectingTest, TheObjectNeedNotBeOnlineBeforeItIsNeeded) {
  Reconnecting<probe::Probe> probe(lab_, "PROBE", at_once());
  const auto missing = probe.get();
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().find("no object is called PROBE"), std::string::npos)
      << missing.error();
  start();
  EXPECT_EQ(read(probe), 7);
}

TEST_F(ReconnectingTest, BetweenTwoTriesTheReasonOfTheLastIsGiven) {
  ReconnectOptions options;
  options.between_tries = 1h;
  Reconnecting<probe::Probe> probe(lab_, "PROBE", options);
  const auto missing = probe.get();
  ASSERT_FALSE(missing);
  start();
  const auto still = probe.get();
  ASSERT_FALSE(still);
  EXPECT_EQ(still.error(), missing.error());
}

TEST_F(ReconnectingTest, ACallGoesToTheServerThatCameAfterTheLostOne) {
  start();
  Reconnecting<probe::Probe> probe(lab_, "PROBE", at_once());
  ASSERT_EQ(read(probe), 7);
  end();
  const auto lost = probe.call([](const probe::Probe& there) { return there.read().get(); });
  ASSERT_FALSE(lost);
  EXPECT_EQ(project(lost.error().detail), State::ConnectionFailed) << lost.error();
  start();
  EXPECT_EQ(read(probe), 7);
}

TEST_F(ReconnectingTest, AFailureOfTheCallItselfKeepsTheProxy) {
  start();
  Reconnecting<probe::Probe> probe(lab_, "PROBE", at_once());
  const auto before = session_of(probe.get().value());
  int calls = 0;
  const auto refused = probe.call([&](const probe::Probe& there) {
    ++calls;
    return there.missing().get();
  });
  ASSERT_FALSE(refused);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(session_of(probe.get().value()), before);
}

TEST_F(ReconnectingTest, AProxyThatWasReplacedAlreadyIsNotDroppedAgain) {
  start();
  Reconnecting<probe::Probe> probe(lab_, "PROBE", at_once());
  const probe::Probe first = probe.get().value();
  probe.drop(first);
  const probe::Probe second = probe.get().value();
  EXPECT_NE(session_of(first), session_of(second));
  probe.drop(first);
  EXPECT_EQ(session_of(probe.get().value()), session_of(second));
}

TEST_F(ReconnectingTest, AStreamIsOpenedAgainAfterItsServerWasLost) {
  const auto open = [](const probe::Probe& there) { return there.level(stream); };
  ReconnectingStream<probe::Probe, std::int32_t> level(lab_, "PROBE", open, at_once());
  EXPECT_EQ(level.latest().error(), "'PROBE' sent no sample yet");
  level.tick();
  EXPECT_NE(level.latest().error().find("no object is called PROBE"), std::string::npos);
  EXPECT_FALSE(level.proxy());
  const auto heard = [&](std::int32_t value) {
    for (;;) {
      servant_.publish(value);
      level.tick();
      const auto sample = level.latest();
      if (sample && sample->value == value) return true;
      std::this_thread::yield();
    }
  };
  start();
  EXPECT_TRUE(heard(11));
  EXPECT_TRUE(level.proxy());
  end();
  while (level.latest()) std::this_thread::yield();
  EXPECT_EQ(level.latest().error(), "'PROBE' no longer sends samples");
  start();
  EXPECT_TRUE(heard(12));
}

}  // namespace
}  // namespace gecos
