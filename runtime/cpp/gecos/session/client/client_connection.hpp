#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/object.hpp"
#include "gecos/qos/requested_quality.hpp"
#include "gecos/session/client/call_sender.hpp"
#include "gecos/session/client/connection_maintenance.hpp"
#include "gecos/session/client/connection_reader.hpp"
#include "gecos/session/client/lease_state.hpp"
#include "gecos/session/client/line_probe.hpp"
#include "gecos/session/client/packet_receiver.hpp"
#include "gecos/session/client/refused_operations.hpp"
#include "gecos/session/client/server_watch.hpp"
#include "gecos/session/client/session_end.hpp"
#include "gecos/session/client/session_failover.hpp"
#include "gecos/session/client/subscriptions.hpp"
#include "gecos/session/client/writers.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/handshake.hpp"

namespace gecos::session {

/// Client side of a session over one connection of a medium. Owns the parts of the session and
/// connects them to each other. This class has more methods than other classes, and more members
/// than other classes, because it implements the whole interface of a session and gives each part
/// access to the others.
///
/// A lost session stays lost: every later call ends as CONNECTION_FAILED, and the program must
/// create a new session with `Lab::create`. Only `@idempotent` readings continue, in a successor
/// session (failover.hpp).
class ClientConnection final : public ClientSession,
                               public Closable,
                               public std::enable_shared_from_this<ClientConnection> {
 public:
  /// `differing`: the codes of the operations that server and client define differently, sorted.
  ClientConnection(std::shared_ptr<Runtime> runtime, std::unique_ptr<media::Connection> connection,
                   SessionId id, Welcome welcome, std::vector<FunctionCode> differing);
  ~ClientConnection() override;  ///< closes the session; issued commands still run

  std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t size,
                                    FunctionRef<void(wire::Encoder&)> encode,
                                    const CallOptions& options) override;
  tl::expected<std::shared_ptr<StreamCore>, Failure> subscribe(
      const StreamDescription& stream) override;
  tl::expected<std::shared_ptr<WriterCore>, Failure> open_writer(
      const InwardDescription& stream) override;
  const std::string& interface_name() const override { return welcome_.interface_name; }
  const std::string& object_name() const override { return welcome_.object; }
  const media::Capabilities& capabilities() const override { return connection_->capabilities(); }
  ObjectRef reference() const override;
  std::shared_ptr<CommandCore> refuse(const OperationDescription& operation,
                                      Failure failure) override;
  std::uint64_t lease_acquired(std::uint64_t epoch) override;
  void lease_released(std::uint64_t held) override { leases_.released(held); }
  bool lease_lost(std::uint64_t held) const override {
    return lost() || closed() || leases_.lost(held);
  }
  std::uint64_t issued() override { return calls_.issued() - line_.pings() + writers_.sent(); }
  LineState line() const override { return line_.state(); }
  LineState await_line_change(std::uint64_t changes, TimePoint deadline) const override {
    return line_.await_change(changes, deadline);
  }

  /// See SessionEnd::close.
  void close(Duration patience) override;
  bool lost() const { return calls_.lost(); }
  /// True when this program has closed the session or is closing it.
  bool closed() const { return end_.closed(); }
  bool unreachable() const { return server_.unreachable(); }
  /// Returns true while the server may have ended without the knowledge of the medium: the server
  /// is unreachable, and the medium may lose the packets that would tell its end.
  bool may_have_ended() const {
    return unreachable() && !lost() && !connection_->capabilities().reliable;
  }
  /// See ServerWatch::unheard_for.
  Duration unheard_for() const { return server_.unheard_for(); }

  Runtime& runtime() { return *runtime_; }
  media::Connection& connection() { return *connection_; }
  const Welcome& welcome() const { return welcome_; }
  /// Sets the address at which the session was opened. Must be called before other threads know the
  /// session.
  void found_at(std::string address) { place_ = std::move(address); }
  const std::string& place() const { return place_; }
  /// Sets the quality that the program requested at `create`. Must be called before other threads
  /// know the session.
  void request(const qos::RequestedQuality& quality) { requested_ = quality; }
  /// Returns the quality that an operation or stream of the object has in this session. `declared`:
  /// its quality in the interface.
  qos::Quality terms(const qos::Quality& declared) const {
    return qos::stricter(declared, requested_);
  }
  /// Returns the longest time of a call of `operation`; zero if there is no limit.
  Duration deadline_of(const OperationDescription& operation, const CallOptions& options) const;
  /// Makes the session refuse the operations and streams of `wanted` whose terms() demand more than
  /// `line`, the promises of the medium. `simulated`: whether the object is a simulated device.
  /// Must be called after request(), and before the program receives the session.
  void check_quality(const InterfaceDescription& wanted, const qos::LineCapabilities& line,
                     bool simulated) {
    refused_.check_quality(wanted, line, simulated, requested_);
  }
  /// From now on, the streams and events arrive over `inbound`, another session with the same
  /// object. Must be called before the program receives the session.
  void receive_over(std::shared_ptr<ClientConnection> inbound) { inbound_ = std::move(inbound); }
  /// Returns a failure when this session must not use the operation or stream `name`; nullopt when
  /// it may. `traffic`: see RefusedOperations::why.
  std::optional<Failure> refusal(FunctionCode code, std::string_view name,
                                 qos::Traffic traffic = qos::Traffic::Calls) const {
    return refused_.why(code, name, welcome_, traffic);
  }

  /// Ends the session, as if the server had been silent for too long. `why`: for the user.
  void give_up(const std::string& why) { end_.lose(Ending::Silent, why); }

  CallSender& calls() { return calls_; }
  ConnectionReader& reader() { return reader_; }
  LineProbe& line_probe() { return line_; }
  SessionFailover& failover() { return failover_; }
  Subscriptions& subscriptions() { return subscriptions_; }
  Writers& writers() { return writers_; }
  TickTarget& tick_target() { return maintenance_; }

 private:
  void note_unsent(PendingCommand& command, const Failure& failure);

  const std::shared_ptr<Runtime> runtime_;
  const std::unique_ptr<media::Connection> connection_;
  const Welcome welcome_;
  qos::RequestedQuality requested_;
  RefusedOperations refused_;
  std::string place_;
  std::shared_ptr<ClientConnection> inbound_;  ///< null: this session receives the streams itself

  ServerWatch server_;
  LeaseState leases_;
  CallSender calls_;
  SessionFailover failover_;
  /// `end_` is declared before `receiver_` and `reader_`, because both call it. The constructor of
  /// `end_` must therefore not use `receiver_` or `reader_`.
  SessionEnd end_;
  PacketReceiver receiver_;
  ConnectionReader reader_;
  LineProbe line_;
  ConnectionMaintenance maintenance_;
  Subscriptions subscriptions_;
  Writers writers_;
};

}  // namespace gecos::session
