// A server that gives signs of life and does not answer: whatever a client waits for ends.
#include <atomic>
#include <limits>

#include "gecos/binding.hpp"
#include "gecos/media/layers/layer.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;
using gecos::media::Role;

/// What the server answers is lost on its way, and what it beats arrives.
class MuteConnection final : public gecos::media::ConnectionLayer {
 public:
  MuteConnection(std::unique_ptr<gecos::media::Connection> inner,
                 const gecos::media::Capabilities& capabilities,
                 std::shared_ptr<std::atomic<int>> lost)
      : ConnectionLayer(std::move(inner), capabilities), lost_(std::move(lost)) {}

  std::optional<gecos::ByteView> receive() override {
    for (;;) {
      const auto packet = ConnectionLayer::receive();
      if (!packet || lost_->load() == 0) return packet;
      lost_->fetch_sub(1);
    }
  }

 private:
  const std::shared_ptr<std::atomic<int>> lost_;
};

/// Bounds of .8 s instead of 3 s.
gecos::Lab quick(const std::shared_ptr<std::atomic<int>>& lost) {
  gecos::LabOptions options;
  options.lease_ttl = 200ms;
  options.grace = 200ms;
  options.heartbeat = 40ms;
  const auto wrap = [lost](std::unique_ptr<gecos::media::Medium> inner) {
    const gecos::media::Capabilities layer_capabilities = inner->capabilities();
    return gecos::media::make_layer(std::move(inner), layer_capabilities,
                                    [lost](std::unique_ptr<gecos::media::Connection> connection,
                                           const gecos::media::Capabilities& capabilities, Role) {
                                      return std::make_unique<MuteConnection>(std::move(connection),
                                                                              capabilities, lost);
                                    });
  };
  return gecos::session::LabAccess::with_media(options, wrap);
}

constexpr int all = std::numeric_limits<int>::max();

class MuteServer : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(near_it_);
  }
  void TearDown() override { EXPECT_LT(std::chrono::steady_clock::now() - begin_, 5 * 800ms + 1s); }

  std::shared_ptr<std::atomic<int>> lost_ = std::make_shared<std::atomic<int>>(0);
  gecos::Lab near_it_ = quick(lost_);
  probe::Probe probe_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};
PROBE_OVER_MEDIA(MuteServer);

TEST_P(MuteServer, KeepsNobodyWaitingForAStatus) {
  *lost_ = all;
  const auto lease = gecos::actor(probe_);
  ASSERT_FALSE(lease);
  EXPECT_EQ(lease.error().failure.detail, Detail::OutcomeUnknown);
  EXPECT_NE(lease.error().failure.text.find("still sends heartbeats"), std::string::npos)
      << lease.error();
  probe_ = probe::Probe();
  EXPECT_TRUE(settles([this] { return gecos::holders(connect(second_lab_)).get()->empty(); }))
      << "what it granted ends with the session that did not hear of it";
}

TEST_P(MuteServer, KeepsNobodyWaitingForWhatEveryObjectAnswers) {
  *lost_ = all;
  const auto described = gecos::describe(probe_);
  const auto holders = gecos::holders(probe_);
  const auto stopped = gecos::stop(probe_);
  const auto pinged = gecos::ping(probe_);
  EXPECT_EQ(described.get().error().detail, Detail::OutcomeUnknown);
  EXPECT_EQ(holders.get().error().detail, Detail::OutcomeUnknown);
  EXPECT_EQ(stopped.get().error().detail, Detail::OutcomeUnknown);
  EXPECT_EQ(pinged.get().error().detail, Detail::OutcomeUnknown);
}

TEST_P(MuteServer, KeepsNobodyWaitingForAProxy) {
  *lost_ = all;
  EXPECT_FALSE(near_it_.create<probe::Probe>("PROBE", {.medium = GetParam(), .patience = 300ms}));
}

TEST_P(MuteServer, KeepsNobodyWaitingWhenAStatusIsGivenBack) {
  auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  *lost_ = all;
  lease->release();
  near_it_.close();
}

TEST_P(MuteServer, KeepsNobodyWaitingForAStream) {
  *lost_ = all;
  EXPECT_FALSE(probe_.level(gecos::stream));
}

TEST_P(MuteServer, KeepsNobodyWaitingForAReadingOrACommand) {
  const auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  *lost_ = all;
  const auto read = probe_.read();
  const auto move = probe_.move(1);
  EXPECT_FALSE(read.get());
  const auto moved = move.get();
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().detail, Detail::OutcomeUnknown) << "it runs";
}

TEST_P(MuteServer, IsNotOneThatTakesItsTime) {
  const auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = probe_.move(1);
  EXPECT_EQ(move.wait_for(1200ms), gecos::State::Running);
  servant_.open_gate();
  EXPECT_EQ(move.get().value(), 1);
}

TEST_P(MuteServer, WhoseOneAnswerIsLostKeepsNobodyWaitingForThatOne) {
  *lost_ = 1;
  const auto lost = gecos::describe(probe_);
  while (lost_->load() != 0 && lost.wait_for(1ms) == gecos::State::Running) {
  }
  static_cast<void>(probe_.read().get());
  const auto described = lost.get();
  if (GetParam() != gecos::media::Kind::Lcm) {
    ASSERT_FALSE(described);
    EXPECT_EQ(described.error().detail, Detail::OutcomeUnknown) << described.error();
    EXPECT_TRUE(settles([this] { return !probe_.read().get(); }))
        << "a medium that lost an answer is not believed any more";
  } else {
    EXPECT_TRUE(described) << "it is asked for again";
  }
}

}  // namespace
