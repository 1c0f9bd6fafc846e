// A stop over a line that loses, repeats, damages and reorders packets, both ways.
#include <random>

#include "bench.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/testing/faulty.hpp"

namespace {

using gecos::Detail;
using gecos::media::Kind;

gecos::Lab lossy_lab(std::uint64_t seed) {
  static const gecos::SystemClock clock;
  const gecos::media::Faults faults{
      .seed = seed, .loss = 0.4, .duplication = 0.2, .corruption = 0.02, .reordering = 0.3};
  return gecos::session::LabAccess::with_media(
      probe::patient(), [faults](std::unique_ptr<gecos::media::Medium> inner) {
        return gecos::media::make_faulty(std::move(inner), faults, clock);
      });
}

/// An object over lcm, to and from which four of ten packets are lost.
class StopOverABadLine : public probe::NothingLeftOpen {
 protected:
  void SetUp() override {
    ASSERT_TRUE(broker_.serve(broker_server_, {Kind::Inproc}));
    gecos::ObjectOptions options;
    options.simulated = true;
    options.media = {Kind::Lcm};
    const auto added = server_.add("PROBE", servant_, options);
    ASSERT_TRUE(added) << added.error().text;
  }
  probe::Probe connect(gecos::Lab& lab) {
    const auto made = lab.create<probe::Probe>(
        "PROBE", {.medium = Kind::Lcm, .patience = std::chrono::seconds(20)});
    EXPECT_TRUE(made) << made.error();
    return made.value_or(probe::Probe());
  }

  const std::uint64_t seed_ = std::random_device{}();
  gecos::Lab broker_lab_ = lossy_lab(seed_ + 3);
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  probe::ProbeServant servant_;
  gecos::Lab server_lab_ = lossy_lab(seed_);
  gecos::Server server_{server_lab_};
  gecos::Lab lab_ = lossy_lab(seed_ + 1);
  gecos::Lab other_lab_ = lossy_lab(seed_ + 2);
};

TEST_F(StopOverABadLine, IsRepeatedUntilItIsAcknowledgedAndEndsWhatRunsEachTime) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  const auto robot = connect(lab_);
  const auto other = connect(other_lab_);
  for (int time = 0; time < 5; ++time) {
    const auto lease = gecos::actor(robot);
    ASSERT_TRUE(lease) << lease.error();
    const auto runs = robot.move(time);
    const auto waits = robot.set(time);
    servant_.await_moves(time + 1);
    const auto stopped = gecos::stop(other).get();
    ASSERT_TRUE(stopped) << stopped.error();
    for (const auto& ended : {runs.get(), waits.get()}) {
      ASSERT_FALSE(ended);
      EXPECT_EQ(ended.error().detail, Detail::Stopped) << ended.error();
    }
    EXPECT_TRUE(gecos::holders(other).get().value().empty()) << "the stop ended the status";
  }
}

}  // namespace
