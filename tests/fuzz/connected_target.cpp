// The client's side of a session whose server says what it likes.
#include <array>
#include <optional>
#include <vector>

#include "gecos/gecos.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/object_calls.hpp"
#include "gecos/session/client/open_session.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/wire/layout.hpp"
#include "packet_target.hpp"
#include "probe.hpp"
#include "scripted_connection.hpp"

namespace gecos::fuzz {
namespace {

using namespace gecos::session;
using Kind = wire::PacketKind;

constexpr SessionId the_session{0x5e5510};

/// The server: whenever the client looks, the script says what has arrived. When it is over the
/// line is.
class Server {
 public:
  Server(Script& script, ScriptedConnection& connection)
      : script_(script), connection_(connection) {
    connection_.next = [this] { return say(); };
    connection_.heard = [this](const wire::PacketView& packet) { hear(packet); };
    connection_.stream = [this](std::uint32_t) { return watches_.open(stream_, {}); };
  }
  void publish(Script& script) {
    const Bytes sample = script.bytes(16);
    static_cast<void>(writer_.publish(sample, static_cast<std::int64_t>(script.number())));
  }

 private:
  std::optional<Bytes> say() {
    if (script_.over()) {
      connection_.lost = media::Loss::Closed;
      return std::nullopt;
    }
    if (script_.one_in(8)) return std::nullopt;
    if (script_.one_in(16)) return script_.bytes(100);
    if (!welcomed_) return greeting();
    wire::PacketHeader header;
    static constexpr std::array usual = {Kind::Reply,    Kind::Reply,
                                         Kind::Reply,    Kind::Progress,
                                         Kind::Progress, static_cast<Kind>(16)};  // reserved
    header.kind =
        script_.one_in(16) ? static_cast<Kind>(script_.byte()) : usual[script_.below(usual.size())];
    header.flags =
        static_cast<std::int8_t>(script_.one_in(4)   ? script_.byte()
                                 : script_.one_in(2) ? static_cast<std::uint8_t>(Detail::Done)
                                                     : script_.below(5));
    header.session = script_.one_in(16) ? SessionId{script_.number()} : the_session;
    header.counter = script_.one_in(16) ? script_.number() : newest_ - script_.below(4);
    header.code = script_.one_in(2) ? probe::level_code : FunctionCode{script_.byte()};
    header.epoch = script_.one_in(4) ? Epoch{script_.number()} : Epoch{};
    header.deadline = Duration(script_.one_in(16) ? script_.number() >> 1 : 0);
    return bent(script_, header, body());
  }
  Bytes greeting() {
    wire::PacketHeader header;
    header.kind = Kind::Welcome;
    header.session = script_.one_in(16) ? SessionId{} : the_session;
    if (script_.one_in(8)) {
      header.kind = Kind::Refused;
      return bent(script_, header, wire::to_bytes(FailureBody{"no", {}, {}}));
    }
    Welcome welcome{"FUZZED",
                    "probe::Probe",
                    {"probe::Device"},
                    script_.number(),
                    script_.number(),
                    static_cast<std::uint32_t>(script_.one_in(4) ? script_.number() : 8),
                    {}};
    for (std::size_t i = script_.below(4); i > 0; --i) {
      const auto& operations = probe::description().operations;
      welcome.operations.push_back(
          {operations[script_.below(operations.size())].code, script_.below(2)});
    }
    welcomed_ = true;
    return bent(script_, header, wire::to_bytes(welcome));
  }
  Bytes body() {
    switch (script_.below(6)) {
      case 0:
        return layout::to_bytes(GecosObject_acquire_result{{Status::ACTOR, script_.number()}});
      case 1:
        return wire::to_bytes(FailureBody{"why", "probe::Jammed", script_.bytes(8)});
      case 2:
        return layout::to_bytes(GecosObject_outcome_result{{script_.byte(), "then"}});
      case 3: {
        ProgressBody progress{script_.byte(), 0, script_.bytes(8)};
        const std::uint64_t fraction = script_.number();
        std::memcpy(&progress.fraction, &fraction, sizeof fraction);
        return wire::to_bytes(progress);
      }
      case 4:
        return Bytes(4, std::byte{script_.byte()});
      default:
        return script_.bytes(60);
    }
  }

  void hear(const wire::PacketView& packet) {
    switch (packet.header.kind) {
      case Kind::Hello:
      case Kind::Goodbye:
        return;
      case Kind::Call:
        newest_ = std::max(newest_, packet.header.counter);
        break;
      case Kind::Cancel:
      case Kind::Query:
        break;
      default:
        expect(false, "a client says nothing else");
    }
    if (opened_ == SessionId{}) opened_ = packet.header.session;
    expect(packet.header.session == opened_, "a client stays in the session that was opened");
    expect(packet.header.acknowledged < packet.header.counter, "what is open is not acknowledged");
  }

  static constexpr std::size_t largest = 16;
  static constexpr std::size_t depth = 3;
  Script& script_;
  ScriptedConnection& connection_;
  bool welcomed_ = false;
  SessionId opened_{};  // as the first call says
  std::uint64_t newest_ = 0;
  alignas(64) std::array<std::byte, media::StreamMemory::bytes(largest, depth)> memory_{};
  const media::StreamMemory stream_{memory_.data(), largest, depth};
  media::StreamRingWriter writer_{stream_, {}};
  media::StreamWatches watches_;
};

/// A command, and how it was seen to end.
struct Issued {
  Command<std::int32_t> command;
  std::optional<Detail> end{};

  void look() {
    const Progress progress = command.progress();
    expect(progress.fraction >= 0 && progress.fraction <= 1, "progress is between nothing and all");
    if (end) return expect(progress.detail == *end, "an end never changes");
    if (project(progress.detail) != State::Running) end = progress.detail;
  }
};

class Program {
 public:
  Program(Script& script, std::shared_ptr<ClientConnection> session, Server& server,
          ScriptedConnection& connection)
      : script_(script),
        session_(std::move(session)),
        server_(server),
        connection_(connection),
        probe_(session_) {}

  void run() {
    for (int step = 0; step < 200 && !script_.over(); ++step) {
      act();
      if (!issued_.empty()) issued_[script_.byte() % issued_.size()].look();
    }
    static constexpr std::array ends = {media::Loss::Closed, media::Loss::Died,
                                        media::Loss::Broken};
    connection_.lost = ends[script_.below(ends.size())];
    tick(std::chrono::seconds(1));
    expect(session_->lost(), "a loss is seen");
    for (Issued& one : issued_) {
      one.look();
      expect(one.end.has_value(), "every command comes to an end");
    }
    const auto late = probe_.read();
    expect(late.state() == State::ConnectionFailed,
           "what is issued on a lost session was never started");
  }

 private:
  void tick(Duration later) {
    the_clock().advance(later);
    session_->tick_target().on_tick(the_clock().now());
  }
  void issue(Command<std::int32_t> command) {
    if (issued_.size() < 32) issued_.push_back({std::move(command)});
  }
  void act() {
    const CallOptions options{Duration(script_.one_in(4) ? script_.number() >> 1 : 0)};
    const auto probe = with(probe_, options);
    switch (script_.below(20)) {
      case 0:
      case 1:
        return issue(probe.read());
      case 2:
        return issue(probe.move(1));
      case 3:
        return issue(probe.set(1));
      case 4:
        return issue(probe.missing());
      case 5:
        if (!issued_.empty()) issued_[script_.byte() % issued_.size()].command.cancel();
        return;
      case 6:
        if (!issued_.empty())
          static_cast<void>(issued_[script_.byte() % issued_.size()].command.get());
        return;
      case 7:
        static_cast<void>(describe(probe).get());
        return;
      case 8:
        static_cast<void>(holders(probe).get());
        return;
      case 9:
        static_cast<void>(outcome(probe, {1, 2, 3}).get());
        return;
      case 10: {
        auto lease = actor(probe);
        if (lease && leases_.size() < 4) leases_.push_back(std::move(*lease));
        return;
      }
      case 11:
        if (!leases_.empty()) leases_.pop_back();
        return;
      case 12:
        if (auto opened = probe.level(stream)) streams_.push_back(std::move(*opened));
        return;
      case 13:
        if (!streams_.empty() && script_.one_in(4)) streams_.pop_back();
        if (!streams_.empty()) streams_.back().latest();
        return;
      case 14:
        if (!streams_.empty()) static_cast<void>(streams_.front().next(Duration::zero()));
        return;
      case 15:
        return server_.publish(script_);
      case 16:
        connection_.full = !connection_.full;
        return;
      case 17:
        ++connection_.beats;
        return;
      case 18:
        return session_->reader().poll_once();
      case 19:
        return tick(std::chrono::milliseconds(script_.byte() * 8));
    }
  }

  Script& script_;
  const std::shared_ptr<ClientConnection> session_;
  Server& server_;
  ScriptedConnection& connection_;
  const probe::Probe probe_;
  std::vector<Issued> issued_;
  std::vector<Lease> leases_;
  std::vector<Stream<std::int32_t>> streams_;
};

}  // namespace

void try_connected(Script script) {
  auto made = std::make_unique<ScriptedConnection>(script.one_in(2));
  ScriptedConnection& connection = *made;
  Server server(script, connection);
  auto opened = open_session(the_runtime(), std::move(made), probe::description(),
                             deadline_after(std::chrono::seconds(5)));
  if (!opened) return expect(!opened.error().reason.empty(), "who is not let in is told why");
  Program(script, std::move(*opened), server, connection).run();
}

}  // namespace gecos::fuzz
