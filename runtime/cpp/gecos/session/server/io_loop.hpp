#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <unordered_map>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/media/parts/waiting.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/process/wakeup.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {

/// Accepts clients and reads their packets; short handlers run here, between two looks.
///
/// Only hot connections are looked at; one silent for 10 ms is armed and costs nothing until it
/// rings. One thread polls at a time. While it is inside a handler it gives polling up, and when
/// the handler takes more than a tick a standby polls in its place, so nobody waits for a slow
/// handler but its own callers.
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
  struct Door {
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
  /// One look at everything hot; sleeps when nothing is.
  void turn() GECOS_REQUIRES(polling_);
  bool look_at_hot() GECOS_REQUIRES(polling_);
  /// Where the clients are that may send next.
  media::Peers peers() const GECOS_REQUIRES(polling_);
  bool arm_all() GECOS_REQUIRES(polling_);
  void cool_down(TimePoint now) GECOS_REQUIRES(polling_);
  void heat(const std::shared_ptr<ServerSession>& session) GECOS_REQUIRES(polling_);
  void take_events(int milliseconds) GECOS_REQUIRES(polling_);
  void open_doors() GECOS_REQUIRES(polling_);
  void accept(Door& door) GECOS_REQUIRES(polling_);
  void accept_all() GECOS_REQUIRES(polling_);
  void watch(const std::shared_ptr<ServerSession>& session) GECOS_REQUIRES(polling_);
  void part_from_suspects() GECOS_REQUIRES(polling_);
  void shut_doors() GECOS_REQUIRES(polling_);
  std::shared_ptr<ServerSession> session_of(std::uint64_t key);
  void part_if_lost(const std::shared_ptr<ServerSession>& session);
  void add_descriptor(int descriptor, std::uint64_t key);

  const std::shared_ptr<Runtime> runtime_;
  const Epoll epoll_;
  Wakeup wakeup_;
  std::atomic<bool> ended_{false};              // publishes nothing but itself
  std::atomic<std::uint64_t> handler_turn_{0};  // main's alone: odd while it is in a handler

  FutexMutex polling_;  ///< held by the thread that polls
  media::SpinPolicy spin_ GECOS_GUARDED_BY(polling_);
  /// Null where an object was withdrawn.
  std::vector<std::unique_ptr<Door>> doors_ GECOS_GUARDED_BY(polling_);
  std::vector<std::shared_ptr<ServerSession>> hot_ GECOS_GUARDED_BY(polling_);
  /// Of arm_all: kept, so that a wake-up needs no memory.
  std::vector<std::shared_ptr<ServerSession>> still_hot_ GECOS_GUARDED_BY(polling_);
  /// By whom the last sleep ended, and when the client rang.
  media::Woken woken_ GECOS_GUARDED_BY(polling_) = media::Woken::Early;
  TimePoint rang_at_ GECOS_GUARDED_BY(polling_){};
  std::uint64_t next_key_ GECOS_GUARDED_BY(polling_) = 1;
  unsigned turns_ GECOS_GUARDED_BY(polling_) = 0;
  std::thread::id main_id_ GECOS_GUARDED_BY(polling_);

  Mutex list_mutex_;  ///< held for moments, also by the thread that polls
  std::unordered_map<std::uint64_t, std::shared_ptr<ServerSession>> sessions_
      GECOS_GUARDED_BY(list_mutex_);  ///< by watch key
  std::vector<std::unique_ptr<Door>> new_doors_ GECOS_GUARDED_BY(list_mutex_);
  std::atomic<bool> somebody_waits_{false};  // at a door, and there was no descriptor for him
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
