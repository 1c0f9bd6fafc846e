// Progress is for whoever asks how a command goes; a caller that sleeps until its end sleeps on.
#include <sys/resource.h>

#include <future>
#include <thread>

#include "over_media.hpp"

namespace {

using gecos::Detail;

/// How often the calling thread has slept.
long sleeps() {
  rusage used{};
  ::getrusage(RUSAGE_THREAD, &used);
  return used.ru_nvcsw;
}

class Progress : public probe::OverMedia {
 protected:
  /// A reading, and the call of it at the server: the test is its handler.
  std::pair<gecos::Command<std::int32_t>, gecos::IncomingCall> issue(const probe::Probe& probe) {
    servant_.on_read([this](gecos::IncomingCall call) { arrives_.set_value(std::move(call)); });
    auto reading = probe.read();
    return {std::move(reading), arrives_.get_future().get()};
  }

 private:
  std::promise<gecos::IncomingCall> arrives_;
};

TEST_P(Progress, IsToldToAThreadThatAsksAndWakesNoThreadThatWaitsForTheEnd) {
  constexpr int reports = 50;
  const auto probe = connect(lab_);
  auto [reading, call] = issue(probe);
  long slept = 0;
  std::thread waiting([&, &command = reading] {
    const long before = sleeps();
    EXPECT_EQ(command.wait(), gecos::State::CommandFailed);
    slept = sleeps() - before;
  });
  for (int i = 1; i <= reports; ++i) {
    const double fraction = i / 100.0;
    call.progress(fraction, {});
    EXPECT_TRUE(settles([&, &command = reading] {
      return command.progress().fraction == fraction;
    })) << fraction;
  }
  EXPECT_EQ(reading.progress().detail, Detail::Executing);
  call.fail(gecos::Fault::rejected("it is over").failure());
  waiting.join();
  if (kind_ == gecos::media::Kind::Lcm) return;  // there the kernel wakes a thread for each packet
  EXPECT_LT(slept, reports / 2);
}

PROBE_OVER_MEDIA(Progress);

}  // namespace
