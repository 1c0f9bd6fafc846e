#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/media/parts/waiting.hpp"
#include "gecos/object.hpp"
#include "gecos/session/client/call_sender.hpp"
#include "gecos/session/client/ending.hpp"
#include "gecos/session/client/failover.hpp"
#include "gecos/session/client/leader_lock.hpp"
#include "gecos/session/client/lease_state.hpp"
#include "gecos/session/client/pending_command.hpp"
#include "gecos/session/client/server_watch.hpp"
#include "gecos/session/process/maintenance.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

class ClientStream;

/// Client side of a session over one connection of a medium.
///
/// Sending takes the mutex; only the leader (LeaderLock) receives. A lost session stays lost: every
/// later call ends as CONNECTION_FAILED, and the program must create a new session with
/// `Lab::create`. Only `@idempotent` readings continue, in a successor session (failover.hpp).
class ClientConnection final : public ClientSession,
                               public Closable,
                               public TickTarget,
                               public std::enable_shared_from_this<ClientConnection> {
 public:
  /// Why no session was opened.
  struct NotOpened {
    Detail detail = Detail::NoServer;
    std::string reason;
  };
  /// Sends a Hello to the server and waits for its answer until `deadline`.
  static tl::expected<std::shared_ptr<ClientConnection>, NotOpened> open(
      std::shared_ptr<Runtime> runtime, std::unique_ptr<media::Connection> connection,
      const InterfaceDescription& wanted, TimePoint deadline);

  /// `differing`: operations that server and client define differently, sorted.
  ClientConnection(std::shared_ptr<Runtime> runtime, std::unique_ptr<media::Connection> connection,
                   SessionId id, Welcome welcome, std::vector<FunctionCode> differing);
  ~ClientConnection() override;  ///< says goodbye: issued commands still run

  std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t size,
                                    FunctionRef<void(wire::Encoder&)> encode,
                                    const CallOptions& options) override;
  tl::expected<std::shared_ptr<StreamCore>, Failure> subscribe(
      const StreamDescription& stream) override;
  const std::string& interface_name() const override { return welcome_.interface_name; }
  const std::string& object_name() const override { return welcome_.object; }
  const media::Capabilities& capabilities() const override { return connection_->capabilities(); }
  ObjectRef reference() const override;
  std::uint64_t lease_acquired(std::uint64_t epoch) override { return leases_.acquired(epoch); }
  void lease_released(std::uint64_t held) override { leases_.released(held); }
  std::uint64_t issued() override { return calls_.issued(); }

  Runtime& runtime() { return *runtime_; }
  /// Sets the address at which the session was opened; must be called before the session is shared.
  void found_at(std::string address) { place_ = std::move(address); }
  const std::string& place() const { return place_; }
  const Welcome& welcome() const { return welcome_; }
  bool lost() const { return calls_.lost(); }
  /// True when this program has closed the session or is closing it.
  bool closed() const { return closed_.load(std::memory_order_relaxed); }
  bool unreachable() const { return server_.unreachable(); }
  CallSender& calls() { return calls_; }

  // Failover: how calls are sent again in another session.
  /// Sets how another session with the object can be opened. Must be called before this session is
  /// shared.
  void set_failover(std::shared_ptr<Failover> failover, ConnectTarget target);
  const ConnectTarget& connect_target() const { return *connect_target_; }
  /// The session that was opened in place of this one, if that session still lives.
  std::shared_ptr<ClientConnection> successor();
  void set_successor(std::shared_ptr<ClientConnection> successor);
  /// Sends `command` in this session; returns false when the session has no room or is lost. @pre
  /// no other thread or session has `command`
  tl::expected<bool, Failure> send_again(const std::shared_ptr<PendingCommand>& command);
  /// Detaches all commands that may be sent again in another session.
  std::vector<PendingFailover> detach_repeatable();

  /// Ends the session in order. Waits at most `patience` for the server's acknowledgement. If it
  /// arrives, the commands that were sent still run. If not, commands that have not started never
  /// start, as far as the medium can tell the server.
  void close(Duration patience) override;

  // For commands and streams.
  /// Reads the packets that have arrived, unless another thread is reading. Never waits.
  void poll_once();
  /// Reads packets, or waits for the thread that reads them, until `done()` or `deadline`. Returns
  /// `done()`.
  bool wait(const void* subject, FunctionRef<bool()> done, TimePoint deadline);
  /// Must be called when the end of a command is awaited on its descriptor or by a callback. Until
  /// `remove_watcher`, the maintenance thread reads packets even when no thread waits in this
  /// session.
  void add_watcher() {
    watchers_.fetch_add(1, std::memory_order_relaxed);
    wake_maintenance();
  }
  void remove_watcher() { watchers_.fetch_sub(1, std::memory_order_relaxed); }

  TimePoint on_tick(TimePoint now) override;
  void watch(std::vector<pollfd>& into) override;
  void unwatch() override;

 private:
  friend class ClientStream;

  // Called only by the thread that reads the medium's connection.
  bool lead(FunctionRef<bool()> done, TimePoint deadline);
  std::size_t read_all();
  bool rest(FunctionRef<bool()> done, TimePoint deadline);
  void sleep(FunctionRef<bool()> done, TimePoint deadline);
  void quiet_leader();
  void take_packet(ByteView bytes);
  void take_reply(const wire::PacketView& packet);
  void take_progress(const wire::PacketView& packet);
  void look_for_loss();
  bool has_watchers() const { return watchers_.load(std::memory_order_relaxed) > 0; }

  void wake_leader();
  std::shared_ptr<ClientConnection> next();
  std::shared_ptr<CommandCore> call_repeatable(const OperationDescription& operation,
                                               std::size_t size,
                                               FunctionRef<void(wire::Encoder&)> encode,
                                               const CallOptions& options);
  tl::expected<void, media::SendProblem> send_repeatable(
      const std::shared_ptr<PendingCommand>& command);
  std::optional<Failure> differs(FunctionCode code, std::string_view name) const;
  std::unique_ptr<media::StreamReader> open_stream(std::uint32_t id);
  tl::expected<std::shared_ptr<StreamCore>, Failure> open_subscribed(
      const StreamDescription& stream, CommandCore& subscribed);
  void unsubscribe(FunctionCode stream);

  static constexpr const char* closed_by_us = "this program closed the session";
  void lose(Ending how, const std::string& text);
  void check_liveness(TimePoint now);
  void judge_answers();
  void wake_maintenance();

  const std::shared_ptr<Runtime> runtime_;
  const std::unique_ptr<media::Connection> connection_;
  const SessionId id_;
  const Welcome welcome_;
  std::string place_;
  const std::vector<FunctionCode> differing_;
  const bool repeats_;                                   ///< the medium may lose packets
  std::shared_ptr<Failover> failover_;                   ///< null: no call is sent again
  std::unique_ptr<const ConnectTarget> connect_target_;  ///< set together with failover_

  ServerWatch server_;
  LeaseState leases_;
  CallSender calls_;

  LeaderLock leader_lock_;
  media::SpinPolicy spin_;        ///< used by the leader only
  std::vector<int> descriptors_;  ///< used by the leader only, reused
  EventFd leader_event_;
  std::atomic<bool> leader_called_{false};  // leader_event_ may be notified; orders no other memory
  std::atomic<bool> closed_{false};         // orders no other memory
  std::atomic<int> watchers_{0};            // orders no other memory
  std::atomic<bool> loss_look_due_{false};  // next leader checks for loss; orders no other memory
  std::atomic<bool> goodbye_heard_{false};  // orders no other memory
  /// This program is closing the session and waits for the server's goodbye. Orders no other
  /// memory.
  std::atomic<bool> awaits_goodbye_{false};
  std::atomic<bool> answer_lost_{false};  // orders no other memory
  std::atomic<std::uint64_t> heard_{0};   // packets received; orders no other memory

  /// Held while a subscription is requested or ended, so that the end of one subscription does not
  /// end another one to the same stream. Must be locked before mutex_.
  Mutex subscribing_;
  /// The number of subscriptions of each stream.
  std::map<FunctionCode, std::size_t> subscriptions_ GECOS_GUARDED_BY(subscribing_);

  FutexMutex mutex_;
  std::shared_ptr<ClientConnection> successor_ GECOS_GUARDED_BY(mutex_);

  // Used by the maintenance thread only.
  bool watching_ = false;
  TimePoint next_beat_{};
};

}  // namespace gecos::session
