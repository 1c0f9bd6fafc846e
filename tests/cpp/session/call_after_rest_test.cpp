// An idle client over a medium that loses packets rests from heartbeat to heartbeat. If the first
// call after a rest is lost, the client must repeat it soon, not at the next heartbeat. If the
// server has ended during the rest, the client must not send the call.
#include <atomic>
#include <thread>

#include "bench.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/layers/layer.hpp"

namespace {

using namespace std::chrono_literals;

/// What the test and the connection of its client know of each other.
struct Line {
  std::atomic<bool> loses_next{false};  ///< the next packet that `caller` sends is lost
  std::atomic<int> looks{0};            ///< how often the maintenance thread has looked for packets
  const std::thread::id caller = std::this_thread::get_id();
};

class LosingConnection final : public gecos::media::ConnectionLayer {
 public:
  LosingConnection(std::unique_ptr<gecos::media::Connection> inner,
                   const gecos::media::Capabilities& capabilities, std::shared_ptr<Line> line)
      : ConnectionLayer(std::move(inner), capabilities), line_(std::move(line)) {}

  tl::expected<std::uint64_t, gecos::media::SendProblem> send(gecos::ByteView head,
                                                              gecos::ByteView body) override {
    if (std::this_thread::get_id() == line_->caller && line_->loses_next.exchange(false)) {
      return ++lost_;
    }
    return ConnectionLayer::send(head, body);
  }
  std::uint64_t beats_seen() override {
    ++line_->looks;
    return ConnectionLayer::beats_seen();
  }

 private:
  const std::shared_ptr<Line> line_;
  std::uint64_t lost_ = 0;
};

constexpr gecos::Duration heartbeat = 10s;

/// A lab whose clients send a heartbeat every 10 s.
gecos::Lab resting_lab(const std::shared_ptr<Line>& line) {
  gecos::LabOptions options;
  options.heartbeat = heartbeat;
  options.lease_ttl = 4 * heartbeat;
  const auto wrap = [line](std::unique_ptr<gecos::media::Medium> inner) {
    if (inner->capabilities().reliable) return inner;
    const gecos::media::Capabilities same = inner->capabilities();
    return gecos::media::make_layer(
        std::move(inner), same,
        [line](std::unique_ptr<gecos::media::Connection> connection,
               const gecos::media::Capabilities& capabilities, gecos::media::Role) {
          return std::make_unique<LosingConnection>(std::move(connection), capabilities, line);
        });
  };
  return gecos::session::LabAccess::with_media(options, wrap);
}

class CallAfterARest : public probe::Bench {
 protected:
  CallAfterARest() : Bench(gecos::media::Kind::Lcm) {}

  void SetUp() override {
    Bench::SetUp();
    serve("PROBE", servant_);
  }

  /// Returns when the client of `probe` rests.
  void await_rest(const probe::Probe& probe) {
    const int before = line_->looks.load();
    ASSERT_TRUE(gecos::ping(probe).get());
    // After a call come two ticks at least. The last one finds no open call, and no call that is
    // newer than the tick before: the client rests.
    ASSERT_TRUE(settles([&] { return line_->looks.load() >= before + 2; }));
  }

  const std::shared_ptr<Line> line_ = std::make_shared<Line>();
  gecos::Lab resting_lab_ = resting_lab(line_);
};

TEST_F(CallAfterARest, IsRepeatedLongBeforeTheNextHeartbeat) {
  const auto probe = connect(resting_lab_);
  for (int time = 0; time < 20; ++time) {
    await_rest(probe);
    line_->loses_next.store(true);
    const auto began = std::chrono::steady_clock::now();
    ASSERT_TRUE(gecos::ping(probe).get());
    EXPECT_LT(std::chrono::steady_clock::now() - began, heartbeat / 2);
    EXPECT_FALSE(line_->loses_next.load());
  }
}

TEST_F(CallAfterARest, IsNotSentIfTheServerHasEndedMeanwhile) {
  const auto probe = connect(resting_lab_);
  for (int time = 0; time < 3; ++time) await_rest(probe);
  server_.reset();
  const auto late = probe.set(1).get();
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().detail, gecos::Detail::NoServer) << late.error();
}

}  // namespace
