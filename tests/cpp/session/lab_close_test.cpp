// What a Lab that is closed takes with it, over every medium: all that its clients still hold.
#include <chrono>
#include <future>

#include "../settles.hpp"
#include "gecos/binding.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/context.hpp"
#include "gecos/session/client/failover.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;
using gecos::StreamEnd;
using gecos::session::LabAccess;

class ClosedLab : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
    other_ = connect(second_lab_);
  }
  bool nobody_holds_it() const {
    const auto holders = gecos::holders(other_).get();
    return holders && holders->empty();
  }
  probe::Probe probe_;
  probe::Probe other_;
};
PROBE_OVER_MEDIA(ClosedLab);

TEST_P(ClosedLab, GivesBackLeasesThatSomebodyStillHas) {
  auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  lab_.close();
  EXPECT_TRUE(settles([this] { return nobody_holds_it(); }));
  const auto next = gecos::actor(other_);
  ASSERT_TRUE(next) << next.error();
  lease->release();
  EXPECT_EQ(other_.set(3).get().value(), 3) << "the late release is nobody else's";
}

TEST_P(ClosedLab, EndsCallsThatWaitAndLetsThemFinish) {
  const auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = probe_.move(1);
  servant_.await_moves(1);
  auto waiting = std::async(std::launch::async, [&] { return move.get(); });
  lab_.close();
  const auto moved = waiting.get();
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().detail, Detail::OutcomeUnknown);
  EXPECT_EQ(moved.error().text,
            "this program closed the session; whether the command was carried out is not known");
  servant_.open_gate();
  servant_.await_event("end 1");
  EXPECT_TRUE(settles([this] { return nobody_holds_it(); }));
}

TEST_P(ClosedLab, EndsReadersThatWait) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  auto waiting =
      std::async(std::launch::async, [&] { return level->next(gecos::Duration::max()); });
  lab_.close();
  const auto sample = waiting.get();
  ASSERT_FALSE(sample);
  EXPECT_EQ(sample.error(), StreamEnd::Lost);
}

TEST_P(ClosedLab, GivesNoSampleAnyMoreWhileOthersReadOn) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  auto others = other_.level(gecos::stream);
  ASSERT_TRUE(others) << others.error();
  servant_.publish(1);
  ASSERT_TRUE(level->next(10s));
  ASSERT_TRUE(others->next(10s));
  servant_.publish(2);
  lab_.close();
  servant_.publish(3);
  for (const std::int32_t value : {2, 3}) {
    const auto sample = others->next(10s);
    ASSERT_TRUE(sample) << to_string(sample.error());
    EXPECT_EQ(sample->value, value);
  }
  const auto sample = level->next(gecos::Duration::max());
  ASSERT_FALSE(sample) << "what had come before is not read either";
  EXPECT_EQ(sample.error(), StreamEnd::Lost);
  EXPECT_FALSE(level->latest());
}

TEST_P(ClosedLab, SendsNothingAndCreatesNothing) {
  lab_.close();
  lab_.close();
  for (const auto& call : {probe_.read(), probe_.look()}) {
    const auto answer = call.get();
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().detail, Detail::NoServer) << answer.error();
  }
  EXPECT_FALSE(probe_.level(gecos::stream));
  EXPECT_FALSE(gecos::actor(probe_));
  const auto created = lab_.create<probe::Probe>("PROBE");
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error().to_string(), "PROBE: NO_SERVER: this Lab is closed; make a new one");
}

TEST_P(ClosedLab, KeepsNoSessionThatIsOpenedMeanwhile) {
  const auto late = std::dynamic_pointer_cast<gecos::session::ClientConnection>(other_.session());
  ASSERT_NE(late, nullptr);
  EXPECT_TRUE(LabAccess::context(lab_).value()->keep(late));
  lab_.close();
  EXPECT_TRUE(late->closed());
  EXPECT_FALSE(LabAccess::context(lab_).value()->keep(late));
}

TEST_P(ClosedLab, GoesOnServing) {
  server_lab_.close();
  EXPECT_EQ(probe_.read().get().value(), 7);
  EXPECT_EQ(connect(second_lab_).read().get().value(), 7) << "it is still findable";
}

TEST_P(ClosedLab, EndsReadingsThatLookForAnotherServer) {
  gecos::LabOptions options = probe::patient();
  options.grace = 60s;
  gecos::Lab lab(options);
  const auto robot = connect(lab);
  server_.reset();
  const auto look = robot.look();
  EXPECT_EQ(look.state(), gecos::State::Running);
  lab.close();
  const auto seen = look.get();
  ASSERT_FALSE(seen);
  EXPECT_NE(seen.error().text.find("its Lab is closed or no longer exists; keep the Lab in a "
                                   "variable as long as its proxies are used"),
            std::string::npos)
      << seen.error();
}

TEST(EndedLab, IsNotTouchedByATickOfItsFailoverThatComesLate) {
  std::shared_ptr<gecos::session::Failover> failover;  // as the maintenance thread holds it
  {
    const gecos::Lab lab;
    failover = LabAccess::context(lab).value()->failover();
  }
  EXPECT_EQ(failover->on_tick(std::chrono::steady_clock::now()).due, gecos::TimePoint::max());
}

}  // namespace
