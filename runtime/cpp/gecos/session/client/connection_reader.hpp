#pragma once

#include <poll.h>
#include <sys/types.h>

#include <atomic>
#include <cstddef>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/function_ref.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/media/waiting.hpp"
#include "gecos/session/client/call_sender.hpp"
#include "gecos/session/client/ending.hpp"
#include "gecos/session/client/leader_lock.hpp"
#include "gecos/session/client/packet_receiver.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

/// Reads the connection of one session. A session has no thread of its own that reads. One of the
/// threads that wait in the session, the leader (LeaderLock), reads for all waiting threads. When
/// no thread waits but a watcher is registered (`add_watcher`), the maintenance thread reads.
/// Thread-safe.
class ConnectionReader {
 public:
  /// `end` is notified when the connection is lost.
  ConnectionReader(Runtime& runtime, media::Connection& connection, CallSender& calls,
                   PacketReceiver& receiver, EndListener& end);

  /// Reads the packets that have arrived, unless another thread is reading. Never waits.
  void poll_once();
  /// Reads the packets that have arrived while no thread read the connection (CallSender::rests),
  /// and notices if the connection has ended. Does nothing in a forked child. Never waits.
  void read_after_rest();
  /// Reads packets, or waits for the thread that reads them, until `done()` returns true or
  /// `deadline` has passed. Returns the last result of `done()`. `subject`: the command that the
  /// thread waits for; null to be woken by every packet.
  bool wait(const void* subject, FunctionRef<bool()> done, TimePoint deadline);
  /// Makes all threads in `wait` check `done()`.
  void wake_all();

  /// Registers a watcher. Must be called when the program awaits the end of a command by a
  /// descriptor or a callback. Until `remove_watcher` is called, the maintenance thread reads
  /// packets even when no thread waits in this session.
  void add_watcher();
  void remove_watcher() { watchers_.fetch_sub(1, std::memory_order_relaxed); }

  // The maintenance thread calls the following functions.

  /// Requests that the next thread that reads in `poll_once` also asks the medium whether the
  /// connection is lost.
  void look_for_loss_soon() { loss_look_due_.store(true, std::memory_order_relaxed); }
  /// If a watcher is registered and there is no leader, becomes the leader and adds to `into` the
  /// descriptors on which packets arrive. The maintenance thread then sleeps on these descriptors;
  /// after the sleep, it must call `unwatch` or `abandon_watch`.
  void watch(std::vector<pollfd>& into);
  /// If `watch` made the calling thread the leader, reads the packets that have arrived and gives
  /// up the lead.
  void unwatch();
  /// If `watch` made the calling thread the leader, gives up the lead without reading. Must be
  /// called before the session is destroyed, because the maintenance thread then no longer calls
  /// `unwatch`.
  void abandon_watch();

 private:
  bool has_watchers() const { return watchers_.load(std::memory_order_relaxed) > 0; }

  // Only the thread that reads the connection may call the following functions.
  bool lead(FunctionRef<bool()> done, TimePoint deadline);
  std::size_t read_all();
  bool rest(FunctionRef<bool()> done, TimePoint deadline);
  void sleep(FunctionRef<bool()> done, TimePoint deadline);
  void quiet_leader();
  void look_for_loss();

  const pid_t owner_;
  Runtime& runtime_;
  media::Connection& connection_;
  CallSender& calls_;
  PacketReceiver& receiver_;
  EndListener& end_;
  const bool reliable_;  ///< the medium loses no packets

  LeaderLock leader_lock_;
  media::SpinPolicy spin_;        ///< used by the leader only
  std::vector<int> descriptors_;  ///< used by the leader only, reused
  EventFd leader_event_;
  std::atomic<bool> leader_called_{false};  // leader_event_ may be set; orders no other memory
  std::atomic<int> watchers_{0};            // orders no other memory
  std::atomic<bool> loss_look_due_{false};  // orders no other memory
  bool watching_ = false;                   ///< used by the maintenance thread only
};

}  // namespace gecos::session
