#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;
using gecos::State;

class Call : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
  }
  probe::Probe probe_;
};
PROBE_OVER_MEDIA(Call);

TEST_P(Call, GivesTheResultOfTheHandler) {
  const auto read = probe_.read();
  EXPECT_EQ(read.wait(), State::Finished);
  EXPECT_EQ(read.get().value(), 7);
  EXPECT_EQ(read.progress().detail, Detail::Done);
}

TEST_P(Call, FinishesWhenItsStateIsOnlyPolled) {
  const auto read = probe_.read();
  while (read.state() == State::Running) {
  }
  EXPECT_EQ(read.state(), State::Finished);
}

TEST_P(Call, ThatMovesTheDeviceIsDeniedWithoutStatusAndSaysHowToGetIt) {
  const auto command = probe_.set(3);
  const auto set = command.get();
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().detail, Detail::Denied);
  EXPECT_EQ(
      set.error().text,
      "'set' of PROBE needs actor status; call actor(object) of gecos to acquire it (request " +
          to_string(command.id()) + ")");
}

TEST_P(Call, IsCarriedOutUnderALease) {
  const auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  EXPECT_EQ(probe_.set(3).get().value(), 3);
}

TEST_P(Call, CarriesADeclaredExceptionTyped) {
  const auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  const auto set = probe_.set(-2).get();
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().detail, Detail::Fault);
  ASSERT_TRUE(set.error().as<probe::Jammed>());
  EXPECT_EQ(set.error().as<probe::Jammed>()->axis, -2);
}

TEST_P(Call, EndsAlsoWhenItsFailureIsLargerThanAPacket) {
  // Static, for ThreadSanitizer, who does not see the order that two mappings of one memory give.
  static const std::string cry = [] {
    std::string text = "a";  // so that the cut falls inside a character
    while (text.size() < 5'000'000) text += "ü";
    return text;
  }();
  servant_.on_read([](gecos::IncomingCall call) {
    call.fail({Detail::Rejected, cry, "probe::Jammed", gecos::Bytes(35'000'000)});
  });
  const auto read = probe_.read().get();
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().detail, Detail::Rejected);
  EXPECT_EQ(read.error().text.rfind("aüü", 0), 0u);
  EXPECT_NE(read.error().text.find("ü… (cut: the whole failure takes 4000"), std::string::npos);
  EXPECT_EQ(read.error().exception, "");
}

TEST_P(Call, OfAnOperationThatTheServerLacksSaysSo) {
  const auto missing = probe_.missing().get();
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().detail, Detail::UnknownOperation);
}

TEST_P(Call, ShowsProgressWhileItRunsAndIsAnsweredBesideIt) {
  const auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = probe_.move(5);
  servant_.await_moves(1);
  while (move.progress().fraction != 0.25) {
  }
  EXPECT_EQ(move.progress().detail, Detail::Executing);
  EXPECT_EQ(move.core()->feedback().size(), 4u);
  EXPECT_EQ(probe_.read().get().value(), 7) << "a sensor call waits for no motion";
  servant_.open_gate();
  EXPECT_EQ(move.get().value(), 5);
  EXPECT_EQ(move.progress().fraction, 1);
}

TEST_P(Call, IsNilOnAProxyThatWasNeverCreated) {
  const probe::Probe nil;
  const auto read = nil.read().get();
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().detail, Detail::NoServer);
  EXPECT_EQ(read.error().state(), State::ConnectionFailed);
}

}  // namespace
