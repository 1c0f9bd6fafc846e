// Large bodies through whole programs over a line that loses, repeats and reorders packets, both
// ways.
#include <random>

#include "bench.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/testing/faulty.hpp"

namespace {

using gecos::Detail;
using gecos::media::Kind;

gecos::Lab bad_line(std::uint64_t seed) {
  static const gecos::SystemClock clock;
  const gecos::media::Faults faults{
      .seed = seed, .loss = 0.1, .duplication = 0.1, .corruption = 0.01, .reordering = 0.3};
  gecos::LabOptions options = probe::patient();
  const auto wrap = [faults](std::unique_ptr<gecos::media::Medium> inner) {
    return gecos::media::make_faulty(std::move(inner), faults, clock);
  };
  return gecos::session::LabAccess::with_media(options, wrap);
}

class LargeBodyOverABadLine : public probe::NothingLeftOpen {
 protected:
  std::mutex mutex_;
  std::map<std::uint32_t, int> runs_;  ///< of each call; guarded by mutex_
  const std::uint64_t seed_ = std::random_device{}();
  gecos::Lab broker_lab_ = bad_line(seed_ + 2);
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  probe::ProbeServant servant_;
  gecos::Lab server_lab_ = bad_line(seed_);
  gecos::Server server_{server_lab_};
  gecos::Lab lab_ = bad_line(seed_ + 1);
};

TEST_F(LargeBodyOverABadLine, ArrivesIntactAndIsCarriedOutOnce) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  ASSERT_TRUE(broker_.serve(broker_server_, {Kind::Inproc}));
  servant_.on_read([&](gecos::IncomingCall call) {
    gecos::wire::Decoder from(call.arguments());
    std::uint32_t which = 0;
    ASSERT_TRUE(from.get(which, "which"));
    {
      const std::lock_guard lock(mutex_);
      ++runs_[which];
    }
    call.finish(gecos::Bytes(call.arguments().rbegin(), call.arguments().rend()));
  });
  gecos::ObjectOptions options;
  options.simulated = true;
  options.media = {Kind::Lcm};
  const auto added = server_.add("PROBE", servant_, options);
  ASSERT_TRUE(added) << added.error().text;
  auto robot = lab_.create<probe::Probe>(
      "PROBE", {.medium = Kind::Lcm, .patience = std::chrono::seconds(20)});
  ASSERT_TRUE(robot) << robot.error();

  std::mt19937_64 random(seed_);
  std::vector<gecos::Bytes> bodies;
  std::vector<std::shared_ptr<gecos::session::CommandCore>> commands;
  for (std::uint32_t which = 0; which < 8; ++which) {
    gecos::Bytes body(which % 2 == 0 ? 20'000 + random() % 400'000 : 100);
    for (auto& byte : body) byte = static_cast<std::byte>(random());
    gecos::wire::Encoder to(std::span<std::byte>(body).first(sizeof which));
    to.put(which);
    commands.push_back(
        robot->session()->call(probe::operation(probe::read_code), body.size(),
                               [&](gecos::wire::Encoder& into) { into.put_bytes(body); }, {}));
    bodies.push_back(std::move(body));
  }
  for (std::uint32_t which = 0; which < commands.size(); ++which) {
    commands[which]->wait_until(gecos::TimePoint::max());
    ASSERT_EQ(commands[which]->progress().detail, Detail::Done) << commands[which]->failure();
    EXPECT_TRUE(std::equal(bodies[which].rbegin(), bodies[which].rend(),
                           commands[which]->result().begin(), commands[which]->result().end()))
        << which << ", " << bodies[which].size() << " bytes";
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(runs_[which], 1) << which;
  }
}

}  // namespace
