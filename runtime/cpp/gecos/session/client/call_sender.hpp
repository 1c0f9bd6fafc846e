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
#include "gecos/session/client/open_calls.hpp"
#include "gecos/session/client/server_watch.hpp"
#include "gecos/session/client/withdrawal.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Sends the calls of one session and everything else that the session sends, and keeps each call
/// until its reply arrives. Over a medium that loses packets, sends calls again until then.
///
/// Thread-safe. Its mutex is held during every send on the connection. Once the session is `lost`,
/// no call is sent any more.
class CallSender {
 public:
  /// `welcome`: the answer of the server that opened the session `id`.
  CallSender(Runtime& runtime, media::Connection& connection, SessionId id, const Welcome& welcome,
             const ServerWatch& server);

  /// Maximum number of open calls. It is a quarter higher for urgent calls, so that a client
  /// without credits can still stop what it started and release its status.
  std::size_t most_open(bool urgent) const {
    return welcome_.credits + (urgent ? welcome_.credits / 4 : 0);
  }
  /// Sends `command` as a call with `header`, whose session, counter and acknowledgement this
  /// function sets, and with the arguments of `size` bytes that `encode` writes. Fails with Full
  /// when `most` calls are open. `attach_to`: the session, for a command that may be sent in
  /// several sessions; null for other commands.
  tl::expected<void, media::SendProblem> send(wire::PacketHeader& header, std::size_t most,
                                              std::size_t size,
                                              FunctionRef<void(wire::Encoder&)> encode,
                                              const std::shared_ptr<PendingCommand>& command,
                                              const std::shared_ptr<ClientConnection>& attach_to);
  /// The failure of a command of operation `name` that `send` refused with `problem`.
  Failure not_sent(std::string_view name, std::size_t size, media::SendProblem problem);
  /// Cancels `command`. Returns false when this session has no open command `command` with this
  /// counter.
  bool cancel(PendingCommand& command, std::uint64_t counter);

  /// Number of calls sent so far.
  std::uint64_t issued();
  /// Number of open calls.
  std::size_t open();
  bool everything_arrived();
  bool has_repeatable();
  /// Converts a time of the server's CLOCK_BOOTTIME to this host's CLOCK_BOOTTIME. Between hosts
  /// the result is at most one round trip too early, never too late.
  TimePoint by_our_clock(TimePoint theirs);

  // Called by the thread that reads the connection.
  /// Removes and returns the call whose reply arrived; null when it has arrived before.
  std::shared_ptr<PendingCommand> take_replied(std::uint64_t counter);
  /// The call whose progress arrived; null when its reply has arrived before.
  std::shared_ptr<PendingCommand> arrived(std::uint64_t counter);

  // Called by the maintenance thread.
  /// Sends again the calls that are due, over a medium that loses packets, and over any medium each
  /// Cancel that found no room. Returns when the next tick is due, `next_beat` at the latest.
  TimePoint repeat(TimePoint now, TimePoint next_beat);
  /// Queries calls that are open for long, because a reply may have been damaged in shared memory.
  /// Does nothing over a medium that loses packets: there the calls are sent again anyway.
  void query_old_calls();

  // How a session ends.
  bool lost() const { return lost_.load(std::memory_order_acquire); }
  /// Tells the server that this program closes the session. Returns false when there is no room.
  bool say_goodbye();

  /// What becomes of the calls that the server has received but not started.
  enum class Queued : std::uint8_t { Run, Withdrawn };
  /// The calls that a lost session had.
  struct Remains {
    std::vector<PendingFailover> repeatable;  ///< may be sent again in another session
    OpenCalls::List others;
  };
  /// Makes the session lost because of `text`, withdraws its calls unless they may still run, and
  /// takes them. Returns nullopt when the session was lost before.
  std::optional<Remains> end(Ending how, const std::string& text, Queued queued);
  /// The failure of `command`, which `end` returned.
  Failure failure_of(const PendingCommand& command, Ending how, const std::string& text);
  /// Detaches all commands that may be sent again in another session because this session is lost
  /// or may be lost.
  std::vector<PendingFailover> detach_repeatable(Ending how, const std::string& text);

 private:
  tl::expected<std::uint64_t, media::SendProblem> send_first(ByteView packet)
      GECOS_REQUIRES(mutex_);
  tl::expected<std::uint64_t, media::SendProblem> send_packet(wire::PacketHeader header)
      GECOS_REQUIRES(mutex_);
  void withdraw_by_packet() GECOS_REQUIRES(mutex_);
  std::vector<PendingFailover> detach(Ending how, const std::string& text) GECOS_REQUIRES(mutex_);

  Runtime& runtime_;
  media::Connection& connection_;
  const SessionId id_;
  const Welcome& welcome_;
  const ServerWatch& server_;
  const bool repeats_;             ///< the medium may lose packets
  std::atomic<bool> lost_{false};  // publishes loss_text_

  FutexMutex mutex_;
  OpenCalls calls_ GECOS_GUARDED_BY(mutex_);
  Bytes packet_ GECOS_GUARDED_BY(mutex_);  ///< encoding buffer, reused
  std::string loss_text_ GECOS_GUARDED_BY(mutex_);
  Withdrawal withdrawal_ GECOS_GUARDED_BY(mutex_);
  bool cancels_waiting_ GECOS_GUARDED_BY(mutex_) = false;  ///< a Cancel packet found no room
  /// The shortest time to a reply so far, over a medium that loses packets.
  Duration quickest_answer_ GECOS_GUARDED_BY(mutex_) = std::chrono::seconds(1);
  /// the highest call counter when calls were last queried
  std::uint64_t open_when_asked_ GECOS_GUARDED_BY(mutex_) = 0;
};

}  // namespace gecos::session
