#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/media/parts/waiting.hpp"
#include "gecos/object.hpp"
#include "gecos/session/client/answer_watch.hpp"
#include "gecos/session/client/failover.hpp"
#include "gecos/session/client/leader_lock.hpp"
#include "gecos/session/client/pending_command.hpp"
#include "gecos/session/process/maintenance.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/call_table.hpp"
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/session/protocol/peer_liveness.hpp"
#include "gecos/session/protocol/suspend_aware_clock.hpp"
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
  std::uint64_t lease_acquired(std::uint64_t epoch) override;
  void lease_released(std::uint64_t held) override;
  std::uint64_t issued() override;

  Runtime& runtime() { return *runtime_; }
  /// Sets the address at which the session was opened; must be called before the session is shared.
  void found_at(std::string address) { place_ = std::move(address); }
  const std::string& place() const { return place_; }
  const Welcome& welcome() const { return welcome_; }
  bool lost() const { return lost_.load(std::memory_order_acquire); }
  /// True when this program has closed the session or is closing it.
  bool closed() const { return closed_.load(std::memory_order_relaxed); }
  bool unreachable() const { return unreachable_.load(std::memory_order_relaxed); }

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
  /// Converts a time of the server's CLOCK_BOOTTIME to this host's CLOCK_BOOTTIME. Between hosts
  /// the result is at most one round trip too early, never too late.
  TimePoint by_our_clock(TimePoint theirs);
  /// Reads the packets that have arrived, unless another thread is reading. Never waits.
  void poll_once();
  /// Reads packets, or waits for the thread that reads them, until `done()` or `deadline`. Returns
  /// `done()`.
  bool wait(const void* subject, FunctionRef<bool()> done, TimePoint deadline);
  /// Cancels `command`. Returns false when this session has no open command `command` with this
  /// counter.
  bool cancel(PendingCommand& command, std::uint64_t counter);
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
  /// Maximum number of open calls. It is a quarter higher for urgent calls, so that a client
  /// without credits can still stop what it started and release its status.
  std::size_t most_open(bool urgent) const {
    return welcome_.credits + (urgent ? welcome_.credits / 4 : 0);
  }
  tl::expected<void, media::SendProblem> send_call(wire::PacketHeader& header, std::size_t most,
                                                   std::size_t size,
                                                   FunctionRef<void(wire::Encoder&)> encode,
                                                   const std::shared_ptr<PendingCommand>& command);
  tl::expected<std::uint64_t, media::SendProblem> send_first(ByteView packet)
      GECOS_REQUIRES(mutex_);
  std::optional<Failure> differs(FunctionCode code, std::string_view name) const;
  Failure not_sent(std::string_view name, std::size_t size, media::SendProblem problem);
  std::unique_ptr<media::StreamReader> open_stream(std::uint32_t id);
  tl::expected<std::shared_ptr<StreamCore>, Failure> open_subscribed(
      const StreamDescription& stream, CommandCore& subscribed);
  void unsubscribe(FunctionCode stream);

  tl::expected<std::uint64_t, media::SendProblem> send(wire::PacketHeader header, ByteView body)
      GECOS_REQUIRES(mutex_);
  std::uint64_t finished_up_to() const GECOS_REQUIRES(mutex_);

  enum class Ending : std::uint8_t { Died, Closed, Silent, Broken, ByUs };
  static constexpr const char* closed_by_us = "this program closed the session";
  void lose(Ending how, const std::string& text);
  void withdraw_by_packet() GECOS_REQUIRES(mutex_);
  bool may_have_started(const PendingCommand& command, Ending how) const GECOS_REQUIRES(mutex_);
  Failure failure_of(const PendingCommand& command, Ending how, const std::string& text) const
      GECOS_REQUIRES(mutex_);
  std::vector<PendingFailover> detach(Ending how, const std::string& text) GECOS_REQUIRES(mutex_);
  bool has_repeatable();
  void check_liveness(TimePoint now);
  void judge_answers(TimePoint now);
  void ask_after_calls();
  /// Sends unanswered calls again. Returns when the next tick is due.
  TimePoint repeat(TimePoint now);
  void wake_maintenance();
  bool everything_arrived();

  const std::shared_ptr<Runtime> runtime_;
  const std::unique_ptr<media::Connection> connection_;
  const SessionId id_;
  const Welcome welcome_;
  std::string place_;
  const std::vector<FunctionCode> differing_;
  const bool repeats_;                                   ///< the medium may lose packets
  std::shared_ptr<Failover> failover_;                   ///< null: no call is sent again
  std::unique_ptr<const ConnectTarget> connect_target_;  ///< set together with failover_

  LeaderLock leader_lock_;
  media::SpinPolicy spin_;        ///< used by the leader only
  std::vector<int> descriptors_;  ///< used by the leader only, reused
  EventFd leader_event_;
  std::atomic<bool> leader_called_{false};  // leader_event_ may be notified; orders no other memory
  std::atomic<bool> lost_{false};           // publishes loss_text_
  std::atomic<bool> closed_{false};         // orders no other memory
  std::atomic<bool> unreachable_{false};    // orders no other memory
  std::atomic<TimePoint> silent_since_{};   // valid while unreachable_; orders no other memory
  std::atomic<int> watchers_{0};            // orders no other memory
  std::atomic<bool> loss_look_due_{false};  // next leader checks for loss; orders no other memory
  std::atomic<bool> goodbye_heard_{false};  // orders no other memory
  std::atomic<bool> answer_lost_{false};    // orders no other memory
  std::atomic<std::uint64_t> heard_{0};     // packets received; orders no other memory
  std::atomic<std::uint64_t> epoch_{0};     // orders no other memory

  /// Held while a subscription is requested or ended, so that the end of one subscription does not
  /// end another one to the same stream. Must be locked before mutex_.
  Mutex subscribing_;
  /// The number of subscriptions of each stream.
  std::map<FunctionCode, std::size_t> subscriptions_ GECOS_GUARDED_BY(subscribing_);

  FutexMutex mutex_;
  std::uint64_t next_counter_ GECOS_GUARDED_BY(mutex_) = 1;
  CallTable<PendingCommand> calls_ GECOS_GUARDED_BY(mutex_);
  Bytes packet_ GECOS_GUARDED_BY(mutex_);  ///< encoding buffer, reused
  std::string loss_text_ GECOS_GUARDED_BY(mutex_);
  /// This program is closing the session and waits for the server's goodbye.
  bool awaits_goodbye_ GECOS_GUARDED_BY(mutex_) = false;
  /// The withdrawal is written: the server starts no more calls of this session.
  bool withdrawn_ GECOS_GUARDED_BY(mutex_) = false;
  std::shared_ptr<ClientConnection> successor_ GECOS_GUARDED_BY(mutex_);
  bool cancels_waiting_ GECOS_GUARDED_BY(mutex_) = false;  ///< a Cancel packet found no room
  /// The shortest time to a reply so far, over a medium that loses packets.
  Duration quickest_answer_ GECOS_GUARDED_BY(mutex_) = std::chrono::seconds(1);
  /// The number of statuses acquired so far; `leases_` counts the leases of the newest status.
  std::uint64_t statuses_ GECOS_GUARDED_BY(mutex_) = 0;
  /// leases of the newest status that are not released
  std::uint64_t leases_ GECOS_GUARDED_BY(mutex_) = 0;

  // Used by the maintenance thread only.
  bool watching_ = false;
  SuspendAwareClock liveness_clock_;  ///< measures how long the server is silent
  PeerLiveness liveness_;
  TimePoint next_beat_{};
  AnswerWatch answers_;
  std::uint64_t open_when_asked_ = 0;  ///< the highest call counter when calls were last queried
};

}  // namespace gecos::session
