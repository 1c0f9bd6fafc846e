// GECOS_LOG=info|debug: who called what on which object, and how it ended.
#include <functional>

#include "over_media.hpp"

namespace {

class CallLog : public probe::OverMedia {
 protected:
  void TearDown() override { gecos::set_log_level(gecos::LogLevel::Warning); }

  /// What this process, client and server in one, writes of a command, a reading and a refusal.
  std::string said_at(gecos::LogLevel level) {
    gecos::set_log_level(level);
    testing::internal::CaptureStderr();
    {
      const auto probe = connect(lab_);
      EXPECT_FALSE(probe.set(1).get());
      const auto lease = gecos::actor(probe);
      EXPECT_TRUE(lease) << lease.error();
      EXPECT_TRUE(probe.set(2).get());
      EXPECT_TRUE(probe.read().get());
    }
    gecos::set_log_level(gecos::LogLevel::Warning);
    return testing::internal::GetCapturedStderr();
  }
};
PROBE_OVER_MEDIA(CallLog);

#define EXPECT_SAYS(text, part) EXPECT_NE(text.find(part), std::string::npos) << text
#define EXPECT_SAYS_NOT(text, part) EXPECT_EQ(text.find(part), std::string::npos) << text

TEST_P(CallLog, TellsCommandsLeasesAndSessionsAtInfo) {
  const std::string said = said_at(gecos::LogLevel::Info);
  const std::string me = "(session_test, pid " + std::to_string(getpid()) + ")";
  EXPECT_SAYS(said, me + " connects over " + std::string(to_string(GetParam())) + "\n");
  EXPECT_SAYS(said, me + " ended COMMAND_FAILED/DENIED: 'set' of PROBE needs actor status");
  EXPECT_SAYS(said, me + " has ACTOR status\n");
  EXPECT_SAYS(said, "gecos info server: PROBE.set of ");
  EXPECT_SAYS(said, me + " ended FINISHED/DONE after ");
  EXPECT_SAYS(said, me + " releases its status\n");
  EXPECT_SAYS(said, "gecos info client: PROBE.set ended COMMAND_FAILED/DENIED: ");
  EXPECT_SAYS(said, "gecos info client: PROBE.set ended FINISHED/DONE\n");
  EXPECT_SAYS_NOT(said, "PROBE.read");
  EXPECT_SAYS_NOT(said, "debug");
}

TEST_P(CallLog, TellsReadingsAndConnectionsTooAtDebug) {
  const std::string said = said_at(gecos::LogLevel::Debug);
  EXPECT_SAYS(said, "gecos debug server: PROBE.read of ");
  EXPECT_SAYS(said, "gecos debug client: PROBE.read ended FINISHED/DONE\n");
  EXPECT_SAYS(said, "gecos debug media: PROBE: a connection over ");
  EXPECT_SAYS(said, ": connected\n");
}

TEST_P(CallLog, TellsNothingOtherwise) { EXPECT_EQ(said_at(gecos::LogLevel::Warning), ""); }

}  // namespace
