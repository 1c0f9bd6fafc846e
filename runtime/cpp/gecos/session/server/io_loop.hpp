#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <unordered_map>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/parts/waiting.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {

/// Accepts clients and reads their packets; short handlers run here, between two looks.
///
/// Only active connections are polled; one silent for 10 ms is prepared to sleep and costs nothing
/// until its event arrives. One thread polls at a time. While it is inside a handler it gives
/// polling up, and when the handler takes more than a tick a standby polls in its place, so nobody
/// waits for a slow handler but its own callers.
class IoLoop {
 public:
  explicit IoLoop(std::shared_ptr<Runtime> runtime);
  ~IoLoop();

  /// Accepts clients of `object` from now on.
  void serve(std::shared_ptr<ObjectHost> object, std::shared_ptr<media::Acceptor> acceptor);
  /// Parts from the clients of `object` and lets no more in. @pre it is closed
  void withdraw(const ObjectHost& object);
  /// After a pause of this process: each session's calls wait for a heartbeat that comes from now
  /// on. On the maintenance thread.
  void await_signs_of_life();
  /// Heartbeats, silence and lost links; wakes the standby. On the maintenance thread. Gives when
  /// the next look is due.
  TimePoint on_tick(TimePoint now);
  /// Waits until the threads have ended, a running handler included; then parts from the clients.
  void end();

 private:
  struct Endpoint {
    std::shared_ptr<ObjectHost> object;
    std::shared_ptr<media::Acceptor> acceptor;
  };
  struct Epoll {
    Epoll();
    ~Epoll();
    const int descriptor;
  };

  void run();
  void run_standby();
  /// Gives polling up meanwhile.
  void run_handlers(ObjectHost& object, std::shared_ptr<ServerCall> started, Starter starter)
      GECOS_REQUIRES(polling_);
  bool main_is_inside() const { return handler_turn_.load() % 2 == 1; }
  /// One look at every active session; sleeps when nothing is.
  void turn() GECOS_REQUIRES(polling_);
  bool poll_active() GECOS_REQUIRES(polling_);
  /// Where the clients are that may send next.
  media::Peers peers() const GECOS_REQUIRES(polling_);
  bool prepare_all_to_sleep() GECOS_REQUIRES(polling_);
  void retire_idle(TimePoint now) GECOS_REQUIRES(polling_);
  void activate(const std::shared_ptr<ServerSession>& session) GECOS_REQUIRES(polling_);
  void take_events(int milliseconds) GECOS_REQUIRES(polling_);
  void add_endpoints() GECOS_REQUIRES(polling_);
  void accept(Endpoint& endpoint) GECOS_REQUIRES(polling_);
  void accept_all() GECOS_REQUIRES(polling_);
  void watch(const std::shared_ptr<ServerSession>& session) GECOS_REQUIRES(polling_);
  void part_from_suspects() GECOS_REQUIRES(polling_);
  void drop_closed_endpoints() GECOS_REQUIRES(polling_);
  std::shared_ptr<ServerSession> session_of(std::uint64_t key);
  void part_if_lost(const std::shared_ptr<ServerSession>& session);
  void add_descriptor(int descriptor, std::uint64_t key);

  const std::shared_ptr<Runtime> runtime_;
  const Epoll epoll_;
  EventFd event_;
  std::atomic<bool> ended_{false};              // publishes nothing but itself
  std::atomic<std::uint64_t> handler_turn_{0};  // main's alone: odd while it is in a handler

  FutexMutex polling_;  ///< held by the thread that polls
  media::SpinPolicy spin_ GECOS_GUARDED_BY(polling_);
  /// Null where an object was withdrawn.
  std::vector<std::unique_ptr<Endpoint>> endpoints_ GECOS_GUARDED_BY(polling_);
  std::vector<std::shared_ptr<ServerSession>> active_ GECOS_GUARDED_BY(polling_);
  /// Of prepare_all_to_sleep: kept, so that a wake-up needs no memory.
  std::vector<std::shared_ptr<ServerSession>> still_active_ GECOS_GUARDED_BY(polling_);
  /// By whom the last sleep ended, and when the client rang.
  media::Woken woken_ GECOS_GUARDED_BY(polling_) = media::Woken::Early;
  TimePoint rang_at_ GECOS_GUARDED_BY(polling_){};
  std::uint64_t next_key_ GECOS_GUARDED_BY(polling_) = 1;
  unsigned turns_ GECOS_GUARDED_BY(polling_) = 0;
  std::thread::id main_id_ GECOS_GUARDED_BY(polling_);

  Mutex list_mutex_;  ///< held for moments, also by the thread that polls
  std::unordered_map<std::uint64_t, std::shared_ptr<ServerSession>> sessions_
      GECOS_GUARDED_BY(list_mutex_);  ///< by watch key
  std::vector<std::unique_ptr<Endpoint>> new_endpoints_ GECOS_GUARDED_BY(list_mutex_);
  std::atomic<bool> somebody_waits_{false};  // at an endpoint, and no descriptor was left for it
  std::atomic<bool> suspects_{false};        // tells who polls that some sessions may be gone

  Mutex standby_mutex_;
  ConditionVariable standby_called_;
  bool standby_wanted_ GECOS_GUARDED_BY(standby_mutex_) = false;
  std::uint64_t handler_seen_ = 0;  ///< maintenance: which handler ran at the last tick
  TimePoint next_beat_{};
  std::thread main_;
  std::thread standby_;
};

}  // namespace gecos::session
