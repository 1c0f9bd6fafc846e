// A served object and the server's end of a client's session, packet by packet.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <semaphore>
#include <vector>

#include "gecos/object_calls.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/wire/fields.hpp"
#include "gecos/wire/layout.hpp"
#include "probe.hpp"

namespace gecos::session {

/// The server's end of a line that loses what the test says.
class TestConnection final : public media::Connection {
 public:
  explicit TestConnection(bool reliable) { capabilities_.reliable = reliable, carry(64 * 1024); }
  void prove_nobody() { capabilities_.authenticated = false; }
  void carry(std::size_t largest_packet) { capabilities_.largest_packet = largest_packet; }

  const media::Capabilities& capabilities() const override { return capabilities_; }
  const media::Peer& peer() const override { return peer_; }
  tl::expected<std::uint64_t, media::SendProblem> send(ByteView head, ByteView) override {
    if (full) return tl::unexpected(media::SendProblem::Full);
    const std::scoped_lock lock(sending);
    sent.emplace_back(head.begin(), head.end());
    if (on_send) on_send();
    return sent.size();
  }
  std::optional<ByteView> receive() override { return std::nullopt; }
  Duration age() override { return unread_for; }
  std::optional<std::uint64_t> taken_by_peer() override { return std::nullopt; }
  bool prepare_to_sleep() override { return true; }
  void woke() override {}
  std::span<const int> descriptors() const override { return {}; }
  void beat() override {}
  std::uint64_t beats_seen() override { return silent ? beats_ : ++beats_; }
  std::uint64_t beats_read() override { return unread ? 0 : beats_; }
  media::Loss loss() override { return media::Loss::None; }
  std::string loss_text() const override { return {}; }
  std::unique_ptr<media::StreamWriter> make_stream(std::size_t, std::size_t) override {
    return nullptr;
  }
  tl::expected<void, media::SendProblem> share(std::uint32_t, media::StreamWriter&) override {
    return {};
  }
  void unshare(std::uint32_t) override {}
  std::unique_ptr<media::StreamReader> open_stream(std::uint32_t,
                                                   const media::StreamBounds&) override {
    return nullptr;
  }

  bool full = false;
  bool silent = false;  ///< no more signs of life come
  bool unread = false;  ///< a packet that arrived before them all
  Duration unread_for{};
  std::vector<Bytes> sent;
  std::function<void()> on_send;
  /// Guards `sent` where a thread of the object sends; held during `on_send`.
  mutable std::recursive_mutex sending;

 private:
  media::Capabilities capabilities_;
  media::Peer peer_;
  std::uint64_t beats_ = 0;
};

/// The system's clock on a machine that the test suspends, or for which it lets time pass.
class SuspendedMachine final : public Clock {
 public:
  TimePoint now() const override {
    const TimePoint stopped = stopped_at_.load();
    return (stopped == TimePoint{} ? system_.now() : stopped) + passed_.load();
  }
  TimePoint since_boot() const override { return system_.since_boot() + suspended_.load(); }
  Duration unix_time() const override { return system_.unix_time(); }
  void suspend(Duration length) { suspended_ = suspended_.load() + length; }
  void pass(Duration time) { passed_ = passed_.load() + time; }
  /// From now on `now()` advances by `pass` alone.
  void stop() { stopped_at_ = system_.now(); }

 private:
  const SystemClock system_;
  std::atomic<TimePoint> stopped_at_{TimePoint{}};     // publishes nothing but itself
  std::atomic<Duration> suspended_{Duration::zero()};  // publishes nothing but itself
  std::atomic<Duration> passed_{Duration::zero()};     // publishes nothing but itself
};

class Servant final : public probe::ProbeServant {
 public:
  void gecos_dispatch(IncomingCall call) override {
    marked_at = call.marked_at();
    if (keep) {
      kept.push_back(std::move(call));
      ++calls;
    } else {
      ++calls;
      call.finish(result);
    }
  }
  bool gecos_begins_calls() const override { return queues; }
  void gecos_session_ended(std::uint64_t) override { ++sessions_ended; }

  /// That were carried out, begun, or kept; publishes `kept`.
  std::atomic<int> calls = 0;
  bool keep = false;
  bool queues = false;                 ///< calls, and begins them later
  std::optional<TimePoint> marked_at;  ///< the last of them
  Bytes result;
  std::vector<IncomingCall> kept;
  int sessions_ended = 0;
};

class ServedObjects : public ::testing::Test {
 protected:
  explicit ServedObjects(bool reliable = true) : reliable_(reliable) { connect(); }
  ~ServedObjects() override {
    object_->close();
    servant_.kept.clear();
    object_->join();
  }

  std::shared_ptr<ObjectHost> make_object() {
    return std::make_shared<ObjectHost>(runtime_, "PROBE", servant_, ObjectOptions{});
  }
  /// Another session takes the place of the one that the packets below are of. Gives the one
  /// before.
  std::shared_ptr<ServerSession> connect() {
    auto before = session_;
    auto connection = std::make_unique<TestConnection>(reliable_);
    connection_ = connection.get();
    session_ = std::make_shared<ServerSession>(std::move(connection), object_);
    Hello hello;
    hello.user = "ada";
    hello.program = program_;
    hello.incarnation = incarnation_;
    hello.interface_name = "probe::Probe";
    wire::PacketHeader header;
    header.kind = wire::PacketKind::Hello;
    take(header, wire::to_bytes(hello));
    return before;
  }

  void take(wire::PacketHeader header, ByteView body = {}) {
    Bytes packet;
    write_packet(packet, header, body);
    object_->take(session_, packet);
    object_->run_ready(Starter::Poller);
  }
  wire::PacketHeader header_of(wire::PacketKind kind, std::uint64_t counter,
                               FunctionCode code) const {
    wire::PacketHeader header;
    header.kind = kind;
    header.session = session_->id();
    header.counter = counter;
    header.code = code;
    return header;
  }
  void packet(wire::PacketKind kind, std::uint64_t counter, FunctionCode code = {},
              ByteView body = {}, Epoch epoch = {}, std::int8_t flags = 0) {
    auto header = header_of(kind, counter, code);
    header.flags = flags;
    header.epoch = epoch;
    header.acknowledged = acknowledged_;
    take(header, body);
  }
  void call(std::uint64_t counter, FunctionCode code, ByteView body = {}, Epoch epoch = {}) {
    packet(wire::PacketKind::Call, counter, code, body, epoch);
  }
  /// A call that was sent under `before` in the session `lost` already.
  void again(std::uint64_t counter, SessionId lost, std::uint64_t before,
             FunctionCode code = probe::look_code) {
    Bytes body(sent_before_size);
    wire::Encoder to(body);
    to.put(number(lost));
    to.put(before);
    packet(wire::PacketKind::Call, counter, code, body, {}, sent_again);
  }
  void acquire(std::uint64_t counter, double patience = 0) {
    Bytes body(4 + 1 + 8);
    wire::Encoder to(body);
    to.put(static_cast<std::int32_t>(Status::ACTOR));
    to.put(false);
    to.put(patience);
    call(counter, GecosObjectInterface::acquire.code, body);
  }
  void send_password(std::uint64_t counter, const std::string& password, double patience = 0) {
    const GecosObject_acquire_arguments asked{Status::ACTOR, password, patience};
    call(counter, GecosObjectInterface::acquire.code, layout::to_bytes(asked));
  }
  /// Like send_password, but returns when the request has a reply: a thread of the object proves
  /// the password.
  void acquire_with(std::uint64_t counter, const std::string& password) {
    await_reply(counter, [&] { send_password(counter, password); });
  }
  /// Returns when a thread of the object has replied to the request `counter`, which `send` sends.
  template <class Send>
  void await_reply(std::uint64_t counter, Send send) {
    std::counting_semaphore replied(0);
    connection_->on_send = [&] {
      if (reply_to(counter)) replied.release();
    };
    send();
    replied.acquire();
    object_->closed();  // takes the mutex, under which the reply is sent
    connection_->on_send = {};
  }
  void release(std::uint64_t counter, Epoch epoch, bool now = false) {
    Bytes body(8 + 1);
    wire::Encoder to(body);
    to.put(number(epoch));
    to.put(now);
    call(counter, GecosObjectInterface::release.code, body);
  }
  /// Detail of the newest reply to `counter`; nothing while there was none.
  std::optional<Detail> reply_to(std::uint64_t counter) const {
    const std::scoped_lock lock(connection_->sending);
    for (auto at = connection_->sent.rbegin(); at != connection_->sent.rend(); ++at) {
      const auto packet = wire::decode_packet(*at);
      if (packet->header.kind == wire::PacketKind::Reply && packet->header.counter == counter) {
        return detail_from(static_cast<std::uint8_t>(packet->header.flags));
      }
    }
    return std::nullopt;
  }
  /// The text of the newest reply, a failure.
  std::string failure() const {
    const std::scoped_lock lock(connection_->sending);
    const auto packet = wire::decode_packet(connection_->sent.back());
    const auto body = wire::from_bytes<FailureBody>(packet->body);
    EXPECT_TRUE(body);
    return body ? body->text : "";
  }
  Epoch granted() const {
    Grant grant;
    const std::scoped_lock lock(connection_->sending);
    const auto packet = wire::decode_packet(connection_->sent.back());
    wire::Decoder from(packet->body);
    EXPECT_TRUE(wire::get_block(from, grant, "grant"));
    return Epoch{grant.epoch};
  }

  const bool reliable_;
  Servant servant_;
  SuspendedMachine clock_;
  std::shared_ptr<Runtime> runtime_ = Runtime::make({}, clock_).value();
  std::shared_ptr<ObjectHost> object_ = make_object();
  std::shared_ptr<ServerSession> session_;
  TestConnection* connection_ = nullptr;
  std::uint64_t acknowledged_ = 0;
  std::string program_{};          ///< of the client, at the next connect()
  std::uint64_t incarnation_ = 0;  ///< of the client's program, at the next connect()
};

class OverALossyLine : public ServedObjects {
 protected:
  OverALossyLine() : ServedObjects(false) {}
};

}  // namespace gecos::session
