// By when a server ends the sessions and streams of a client that is not admitted any more. The
// test makes the ticks of the server, and says which time it is.
#include <atomic>
#include <mutex>

#include "../settles.hpp"
#include "gecos/session/server/broker_contact.hpp"
#include "gecos/session/server/io_loop.hpp"
#include "object_host_bench.hpp"

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

/// Promised for a revocation as a whole.
constexpr Duration promised = 5s;
/// Promised for this part of it. A server reads the lab file once a second besides, and takes a
/// file that has not changed for a second.
constexpr Duration judged_within = 1s;

/// What a client has seen of its server. It outlives the connection.
struct Seen {
  bool ended() {
    const std::lock_guard lock(mutex);
    return !why.empty();
  }
  std::atomic<int> beats = 0;            // orders no other memory
  std::atomic<int> judged = 0;           // orders no other memory
  std::atomic<int> read = 0;             // the last reading of its key; orders no other memory
  std::atomic<bool> stream_left{false};  // it is not shared any more; orders no other memory
  std::atomic<bool> key_removed{false};  // orders no other memory
  std::mutex mutex;
  std::string why;  ///< the reason in the Goodbye of the server; guarded by `mutex`
};

/// The server's end of a connection to a program of another user, whose key names the user.
class UserConnection final : public media::Connection {
 public:
  UserConnection(const std::string& user, std::shared_ptr<Seen> seen) : seen_(std::move(seen)) {
    peer_.user = user;
    peer_.host = "desk";
    capabilities_.largest_packet = 64 * 1024;
  }

  const media::Capabilities& capabilities() const override { return capabilities_; }
  const media::Peer& peer() const override { return peer_; }
  tl::expected<std::uint64_t, media::SendProblem> send(ByteView head, ByteView) override {
    const auto packet = wire::decode_packet(head);
    if (packet && packet->header.kind == wire::PacketKind::Goodbye) {
      const std::lock_guard lock(seen_->mutex);
      seen_->why = text_of(packet->body);
    }
    return 1;
  }
  std::optional<ByteView> receive() override { return std::nullopt; }
  std::optional<std::uint64_t> taken_by_peer() override { return std::nullopt; }
  bool prepare_to_sleep() override { return true; }
  void woke() override {}
  std::span<const int> descriptors() const override { return {}; }
  void beat() override { ++seen_->beats; }
  std::uint64_t beats_seen() override { return ++beats_; }
  media::Loss loss() override { return media::Loss::None; }
  std::string loss_text() const override { return {}; }
  std::function<std::string()> later_refusal() override {
    return [seen = seen_, number = ++seen_->judged]() -> std::string {
      const std::string why = seen->key_removed ? "its key is gone" : "";
      seen->read = number;
      return why;
    };
  }
  std::unique_ptr<media::StreamWriter> make_stream(std::size_t, std::size_t) override {
    return nullptr;
  }
  tl::expected<void, media::SendProblem> share(std::uint32_t, media::StreamWriter&) override {
    return {};
  }
  void unshare(std::uint32_t) override { seen_->stream_left = true; }
  std::unique_ptr<media::StreamReader> open_stream(std::uint32_t,
                                                   const media::StreamBounds&) override {
    return nullptr;
  }

 private:
  const std::shared_ptr<Seen> seen_;
  media::Capabilities capabilities_;
  media::Peer peer_;
  std::atomic<std::uint64_t> beats_ = 0;  // orders no other memory
};

/// Counts how often the samples moved away from those with whom the stream is not shared any more.
class CountingWriter final : public media::StreamWriter {
 public:
  explicit CountingWriter(std::atomic<int>& moves) : moves_(moves) {}
  std::size_t largest() const override { return 0; }
  tl::expected<void, media::SendProblem> publish(ByteView, std::int64_t) override { return {}; }
  tl::expected<std::span<std::byte>, media::SendProblem> lend(std::size_t) override {
    return tl::unexpected(media::SendProblem::TooLarge);
  }
  void publish_lent(std::int64_t) override {}
  std::uint64_t newest() const override { return 0; }
  void number_after(std::uint64_t) override {}
  void move_on() override { ++moves_; }

 private:
  std::atomic<int>& moves_;
};

/// Has connections to clients that have connected already.
class WaitingClients final : public media::Acceptor {
 public:
  explicit WaitingClients(std::atomic<int>& moves) : moves_(moves) {}
  void add(std::unique_ptr<media::Connection> client) { clients_.push_back(std::move(client)); }

  const media::Capabilities& capabilities() const override { return capabilities_; }
  const std::string& address() const override { return address_; }
  std::unique_ptr<media::Connection> accept() override {
    if (clients_.empty()) return nullptr;
    auto client = std::move(clients_.back());
    clients_.pop_back();
    return client;
  }
  std::span<const int> descriptors() const override { return {}; }
  std::unique_ptr<media::StreamWriter> make_stream(std::size_t, std::size_t) override {
    return std::make_unique<CountingWriter>(moves_);
  }

 private:
  std::atomic<int>& moves_;
  std::vector<std::unique_ptr<media::Connection>> clients_;
  const media::Capabilities capabilities_;
  const std::string address_ = "test:PROBE";
};

/// PROBE has two clients that read its stream: programs of anna and of ben, from host desk.
class Revocations : public ::testing::Test {
 protected:
  Revocations() {
    access_->allow({"anna", "ben"}, {"desk"});
    const auto clients = std::make_shared<WaitingClients>(moves_);
    object_->streams().offer(clients);
    for (const auto& [user, seen] : {std::pair("anna", annas_), std::pair("ben", bens_)}) {
      auto client = std::make_unique<UserConnection>(user, seen);
      EXPECT_TRUE(object_->streams().share(probe::description().streams[0], *client));
      clients->add(std::move(client));
    }
    loop_.serve(object_, clients);
    EXPECT_TRUE(settles([this] {
      pass(100ms);
      return annas_->beats > 0 && bens_->beats > 0;
    })) << "the I/O loop has accepted both";
    // A revocation that comes now waits longest, because the server has just judged its clients.
    const int before = bens_->judged;
    for (int look = 0; look < 1000 && bens_->judged == before; ++look) pass(Maintenance::tick);
    EXPECT_TRUE(settles([this] { return bens_->read == bens_->judged; }));
  }
  ~Revocations() override {
    object_->close();
    object_->join();
    loop_.end();
    object_->streams().close();
  }
  void pass(Duration time) { loop_.on_tick(now_ += time); }
  /// Lets so much time pass, with ticks as those of the maintenance thread.
  void pass_in_ticks(Duration time) {
    for (const TimePoint end = now_ + time; now_ < end;) {
      pass(std::min<Duration>(Maintenance::calm_tick, end - now_));
    }
  }
  std::string told_to_ben() const {
    const std::lock_guard lock(bens_->mutex);
    return bens_->why;
  }
  void expect_that_anna_goes_on() {
    pass_in_ticks(promised);
    EXPECT_FALSE(annas_->ended());
    EXPECT_FALSE(annas_->stream_left);
  }

  std::atomic<int> moves_ = 0;
  const std::shared_ptr<Seen> annas_ = std::make_shared<Seen>(), bens_ = std::make_shared<Seen>();
  SuspendedMachine clock_;
  Servant servant_;
  const std::shared_ptr<Runtime> runtime_ = Runtime::make({}, clock_).value();
  const std::shared_ptr<ObjectHost> object_ =
      std::make_shared<ObjectHost>(runtime_, "PROBE", servant_, ObjectOptions{});
  const std::shared_ptr<AccessControl> access_ = std::make_shared<AccessControl>(
      "", Admission::Listed, std::make_shared<BrokerContact>(clock_));
  IoLoop loop_{runtime_, access_};
  TimePoint now_ = clock_.now();
};

TEST_F(Revocations, OfAUserWhomNoListNamesAnyMoreEndSessionAndStreamsWithinASecond) {
  access_->allow({"anna"}, {"desk"});
  pass_in_ticks(judged_within);
  EXPECT_EQ(told_to_ben(),
            ": revoked: PROBE refuses user ben of host desk: the list in the program of the server "
            "(`allow`, or `users` and `hosts` of `serve`) does not name user ben; add \"ben\" to "
            "its users");
  EXPECT_TRUE(bens_->stream_left);
  EXPECT_EQ(moves_, 1) << "the samples have left the memory, or the key, that ben has";
  expect_that_anna_goes_on();
}

TEST_F(Revocations, OfAKeyEndSessionAndStreamsWithinASecondAndTheTimeThatReadingTheKeysTakes) {
  bens_->key_removed = true;
  pass_in_ticks(judged_within);
  EXPECT_TRUE(settles([this] {
    pass(0s);
    return bens_->ended();
  })) << "a thread of its own reads the keys";
  EXPECT_EQ(told_to_ben(), ": revoked: its key is gone");
  EXPECT_TRUE(bens_->stream_left);
  EXPECT_EQ(moves_, 1);
  expect_that_anna_goes_on();
}

}  // namespace
}  // namespace gecos::session
