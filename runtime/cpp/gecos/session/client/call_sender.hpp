#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/client/ending.hpp"
#include "gecos/session/client/failover.hpp"
#include "gecos/session/client/idle_rest.hpp"
#include "gecos/session/client/open_calls.hpp"
#include "gecos/session/client/seen_failures.hpp"
#include "gecos/session/client/server_watch.hpp"
#include "gecos/session/client/withdrawal.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Sends all packets of one session, and keeps each call until its reply arrives. Over a medium
/// that loses packets, sends a call again until its reply arrives.
///
/// Thread-safe. `mutex_` is held during every send on the connection. Once the session is `lost`,
/// no call is sent any more. This class has more methods than other classes, because sending,
/// repeating and ending a call share this mutex and the list of open calls.
class CallSender {
 public:
  /// `welcome`: the packet with which the server opened the session `id`.
  CallSender(Runtime& runtime, media::Connection& connection, SessionId id, const Welcome& welcome,
             const ServerWatch& server);

  /// Returns the maximum number of open calls. The maximum is a quarter higher for urgent calls, so
  /// that a client that has used up its credits can still stop the object and release its status.
  std::size_t most_open(bool urgent) const {
    return welcome_.credits + (urgent ? welcome_.credits / 4 : 0);
  }
  /// Sends `command` as a call with `header` and with the arguments of `size` bytes that `encode`
  /// writes. Sets session, counter and acknowledgement in `header`. With an actor command, also
  /// sends what the program knows of earlier commands (SeenFailures). Fails with Full when `most`
  /// calls are open. `attach_to`: this session, if `command` may later be sent again in another
  /// session; `command` then records that it was sent in this session. Null for every other
  /// command.
  tl::expected<void, media::SendProblem> send(wire::PacketHeader& header, std::size_t most,
                                              std::size_t size,
                                              FunctionRef<void(wire::Encoder&)> encode,
                                              const std::shared_ptr<PendingCommand>& command,
                                              const std::shared_ptr<ClientConnection>& attach_to);
  /// Returns the failure of a command of the operation `name` that `send` did not send because of
  /// `problem`. `size`: the size of the arguments of this command in bytes.
  Failure not_sent(std::string_view name, std::size_t size, media::SendProblem problem);
  /// Asks the server to cancel `command`. Returns false when `command` has ended, and when the open
  /// call of this session with the number `counter` is not `command`.
  bool cancel(PendingCommand& command, std::uint64_t counter);

  /// Returns the record of the failures of this session's commands that the program has seen.
  const std::shared_ptr<SeenFailures>& failures() const { return failures_; }
  /// Returns the number of calls sent so far.
  std::uint64_t issued();
  /// Returns the number of open calls.
  std::size_t open();
  /// Returns true if no call is open and none was sent since the tick before the last one. The
  /// maintenance thread then may not read the connection before the next heartbeat. Always false
  /// over a medium that loses no packets.
  bool rests() const { return idle_rest_.rests(); }
  /// Runs `use` while no other thread sends over the connection.
  void with_connection(FunctionRef<void(media::Connection&)> use);
  bool everything_arrived();
  bool has_repeatable();
  /// Converts a time of the server's CLOCK_BOOTTIME to this host's CLOCK_BOOTTIME. Between hosts
  /// the result is at most one round trip too early, never too late.
  TimePoint by_our_clock(TimePoint theirs);

  // The thread that reads the connection calls the following functions.

  /// Must be called when a reply to the call `counter` arrives. Removes and returns the call; null
  /// when a reply to this call has arrived before.
  std::shared_ptr<PendingCommand> take_replied(std::uint64_t counter);
  /// Must be called when a progress report of the call `counter` arrives. The report proves that
  /// the server has the call. Returns the call; null when the reply to the call has arrived before.
  std::shared_ptr<PendingCommand> arrived(std::uint64_t counter);

  // The maintenance thread calls the following functions.

  /// Over a medium that loses packets, repeats each open call when the time of its next repetition
  /// has come. Over any medium, sends each Cancel packet again for which there was no room before.
  /// Returns the time at which this function must be called again. `next_beat`: the time of the
  /// next heartbeat. If no call is open, the returned time may be `next_beat`; the next `send` then
  /// asks for a tick (`take_tick_request`).
  TimePoint repeat(TimePoint now, TimePoint next_beat);
  /// Returns whether a call was sent after which `repeat` must be called at once, and clears the
  /// request.
  bool take_tick_request() { return idle_rest_.take_tick_request(); }
  /// Asks the server for the state of each call that was already open when this function ran last,
  /// because the reply may have been damaged in shared memory. Does nothing over a medium that
  /// loses packets, because `repeat` sends the calls again there.
  void query_old_calls();

  // Functions for the end of a session.
  bool lost() const { return lost_.load(std::memory_order_acquire); }
  /// Returns how and why the session was lost. @pre the session is lost
  SessionLoss loss();
  /// Tells the server that this program closes the session. Returns false when the connection has
  /// no room for the packet.
  bool say_goodbye();

  /// Says what becomes of the calls that the server has received and not started yet: they still
  /// run, or they are withdrawn.
  enum class Queued : std::uint8_t { Run, Withdrawn };
  /// The calls that were open when their session was lost.
  struct Remains {
    std::vector<PendingFailover> repeatable;  ///< may be sent again in another session
    OpenCalls::List others;
  };
  /// Marks the session as lost because of `text`. Withdraws its calls if `queued` is Withdrawn.
  /// Removes and returns the open calls; nullopt when the session was lost before.
  std::optional<Remains> end(Ending how, const std::string& text, Queued queued);
  /// Returns the failure of `command`, one of the commands that `end` returned.
  Failure failure_of(const PendingCommand& command, Ending how, const std::string& text);
  /// Removes and returns the commands that may be sent again in another session, because this
  /// session is lost or may be lost.
  std::vector<PendingFailover> detach_repeatable(Ending how, const std::string& text);

 private:
  tl::expected<std::uint64_t, media::SendProblem> send_first(ByteView packet)
      GECOS_REQUIRES(mutex_);
  tl::expected<std::uint64_t, media::SendProblem> send_packet(wire::PacketHeader header,
                                                              ByteView body = {})
      GECOS_REQUIRES(mutex_);
  void withdraw_by_packet() GECOS_REQUIRES(mutex_);
  std::vector<PendingFailover> detach(Ending how, const std::string& text) GECOS_REQUIRES(mutex_);

  Runtime& runtime_;
  media::Connection& connection_;
  const SessionId id_;
  const Welcome& welcome_;
  const ServerWatch& server_;
  const bool repeats_;  ///< the medium may lose packets
  const std::shared_ptr<SeenFailures> failures_ = std::make_shared<SeenFailures>();
  std::atomic<bool> lost_{false};  // publishes loss_

  FutexMutex mutex_;
  OpenCalls calls_ GECOS_GUARDED_BY(mutex_);
  Bytes packet_ GECOS_GUARDED_BY(mutex_);  ///< encoding buffer, reused
  SessionLoss loss_ GECOS_GUARDED_BY(mutex_);
  Withdrawal withdrawal_ GECOS_GUARDED_BY(mutex_);
  bool cancels_waiting_ GECOS_GUARDED_BY(mutex_) = false;  ///< a Cancel packet found no room
  /// The shortest time so far between a call and its reply. Measured only over a medium that loses
  /// packets.
  Duration quickest_answer_ GECOS_GUARDED_BY(mutex_) = std::chrono::seconds(1);
  /// The counter of the newest call that had been issued when `query_old_calls` ran last.
  std::uint64_t open_when_asked_ GECOS_GUARDED_BY(mutex_) = 0;
  IdleRest idle_rest_;  ///< used over a medium that loses packets
};

}  // namespace gecos::session
