// What goes wrong although nobody asks is told once.
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <stdexcept>

#include "over_media.hpp"

namespace {

using gecos::Detail;

/// What `act` writes to stderr.
std::string said_by(const std::function<void()>& act) {
  testing::internal::CaptureStderr();
  act();
  return testing::internal::GetCapturedStderr();
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

class Unasked : public probe::Bench, public ::testing::WithParamInterface<gecos::media::Kind> {
 protected:
  Unasked() : Bench(GetParam()) {}
  void SetUp() override {
    Bench::SetUp();
    serve(name_, servant_);
    probe_ = connect(lab_, name_);
  }
  const std::string name_ =
      "PROBE_" + std::string(to_string(GetParam()));  // told once in a process
  probe::Probe probe_;
};
PROBE_OVER_MEDIA(Unasked);

TEST_P(Unasked, ACommandThatFailsIsLoggedOnceWithObjectOperationAndReason) {
  std::string said = said_by([this] {
    static_cast<void>(probe_.set(1));
    gecos::ping(probe_).wait();  // its reply comes after that of `set`, unless one is lost
  });
  ASSERT_TRUE(settles([&] {
    if (said.find('\n') != std::string::npos) return true;
    said += said_by([this] { gecos::ping(probe_).wait(); });
    return false;
  }));
  said += said_by([this] {
    static_cast<void>(probe_.set(2));
    EXPECT_EQ(probe_.set(3).get().error().detail, Detail::Denied);
  });
  EXPECT_EQ(count(said, "\n"), 1u) << said;
  EXPECT_EQ(
      said.find("gecos warning command: " + name_ +
                ".set failed, and nobody observed the failure: COMMAND_FAILED/DENIED: 'set' of " +
                name_ + " needs actor status"),
      0u)
      << said;
  EXPECT_EQ(count(said, ". Keep the command and wait() for it, or detach() it; later failures"), 1u)
      << said;
}

TEST_P(Unasked, ACommandThatWasAskedForFailsInSilence) {
  EXPECT_EQ(said_by([this] {
              EXPECT_EQ(probe_.move(1).wait(), gecos::State::CommandFailed);
              const auto told = probe_.move(1);
              while (told.state() == gecos::State::Running) gecos::ping(probe_).wait();
              probe_.move(1).detach();
              EXPECT_TRUE(gecos::ping(probe_).get());
            }),
            "");
}

TEST_P(Unasked, ALeaseThatIsDroppedAtOnceSaysToKeepIt) {
  const std::string said = said_by([this] { EXPECT_TRUE(gecos::actor(probe_)); });
  EXPECT_EQ(count(said, "gecos warning lease: ACTOR status of " + name_ +
                            " was released at once, before any command was issued under it; keep "
                            "the lease as long as you need the status\n"),
            1u)
      << said;
}

TEST_P(Unasked, ALeaseThatWasUsedOrReleasedSaysNothing) {
  EXPECT_EQ(said_by([this] {
              {
                const auto lease = gecos::actor(probe_);
                EXPECT_TRUE(probe_.set(1).get());
              }
              auto lease = gecos::master(probe_);
              ASSERT_TRUE(lease) << lease.error();
              lease->release();
            }),
            "");
}

TEST_P(Unasked, ALeaseUnderWhichACallWasRefusedBeforeItWasSentSaysNothing) {
  EXPECT_EQ(said_by([this] {
              const auto lease = gecos::actor(probe_);
              const gecos::Command<void> refused = gecos::session::Refused("5 is outside [0, 1]");
              EXPECT_EQ(refused.get().error().detail, Detail::BadParameter);
            }),
            "");
}

TEST(UnaskedDeathTest, ALogLevelThatThereIsNotIsRefusedByTheLab) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";  // where no level was read yet
  ::setenv("GECOS_LOG", "loud", 1);
  const auto make_lab = [] {
    gecos::Lab lab;
    std::fputs(lab.create<probe::Probe>("RX90").error().to_string().c_str(), stderr);
    std::_Exit(3);
  };
  EXPECT_EXIT(make_lab(), testing::ExitedWithCode(3),
              "^RX90: NO_SERVER: GECOS_LOG is \"loud\", which is not a log level; write error, "
              "warning, info or debug$");
  ::unsetenv("GECOS_LOG");
}

TEST(UnaskedDeathTest, AnObjectThatIsUsedThoughCreateGaveNoneEndsWithTheReason) {
  using Created = decltype(std::declval<gecos::Lab&>().create<probe::Probe>("RX90"));
  const Created robot = tl::unexpected(
      gecos::CreateError{{{"RX90", Detail::NoServer, "no broker answers; start `gecos broker`"}}});
  EXPECT_DEATH(static_cast<void>(robot->read()), "RX90: NO_SERVER: no broker answers; start");
  using Held = decltype(gecos::actor(*robot));
  const Held lease =
      tl::unexpected(gecos::LeaseRefusal{{Detail::Fault, "held by eve", {}, {}}, {}});
  EXPECT_DEATH(static_cast<void>(lease->epoch()), "COMMAND_FAILED/FAULT: held by eve");
}

}  // namespace
