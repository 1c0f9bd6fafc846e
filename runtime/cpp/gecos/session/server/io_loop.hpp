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

/// Accepts clients and reads their packets. Short handlers run on its thread, between two polls.
///
/// Only active connections are polled; a connection silent for 10 ms is prepared to sleep and costs
/// nothing until its event arrives. One thread polls at a time. It releases polling while it runs a
/// handler; when the handler takes more than a tick, a standby thread polls in its place, so only
/// the callers of a slow handler wait for it.
class IoLoop {
 public:
  explicit IoLoop(std::shared_ptr<Runtime> runtime);
  ~IoLoop();

  /// Accepts clients of `object` from now on.
  void serve(std::shared_ptr<ObjectHost> object, std::shared_ptr<media::Acceptor> acceptor);
  /// Disconnects the clients of `object` and accepts no more. @pre `object` is closed
  void withdraw(const ObjectHost& object);
  /// Must be called after a pause of this process: the calls of each session then wait for a
  /// heartbeat that arrives from now on. On the maintenance thread.
  void await_signs_of_life();
  /// Sends heartbeats, detects silent clients and lost links, wakes the standby. On the maintenance
  /// thread. Returns when the next tick is due.
  TimePoint on_tick(TimePoint now);
  /// Waits until the threads have ended, a running handler included; then disconnects the clients.
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
  /// Releases `polling_` while the handlers run.
  void run_handlers(ObjectHost& object, std::shared_ptr<ServerCall> started, Starter starter)
      GECOS_REQUIRES(polling_);
  bool main_is_inside() const { return handler_turn_.load() % 2 == 1; }
  /// Polls every active session once; sleeps when none is active any more.
  void turn() GECOS_REQUIRES(polling_);
  bool poll_active() GECOS_REQUIRES(polling_);
  /// Whether the clients that may send next run on this core or on others.
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
  std::atomic<std::uint64_t> handler_turn_{0};  // written by main_: odd while it runs a handler

  FutexMutex polling_;  ///< held by the thread that polls
  media::SpinPolicy spin_ GECOS_GUARDED_BY(polling_);
  /// An element is null after its object was withdrawn.
  std::vector<std::unique_ptr<Endpoint>> endpoints_ GECOS_GUARDED_BY(polling_);
  std::vector<std::shared_ptr<ServerSession>> active_ GECOS_GUARDED_BY(polling_);
  /// Scratch list of prepare_all_to_sleep, kept so that it does not allocate.
  std::vector<std::shared_ptr<ServerSession>> still_active_ GECOS_GUARDED_BY(polling_);
  /// What ended the last sleep, and when the client sent its notification.
  media::Woken woken_ GECOS_GUARDED_BY(polling_) = media::Woken::Early;
  TimePoint rang_at_ GECOS_GUARDED_BY(polling_){};
  std::uint64_t next_key_ GECOS_GUARDED_BY(polling_) = 1;
  unsigned turns_ GECOS_GUARDED_BY(polling_) = 0;
  std::thread::id main_id_ GECOS_GUARDED_BY(polling_);

  Mutex list_mutex_;  ///< held for moments, also by the thread that polls
  std::unordered_map<std::uint64_t, std::shared_ptr<ServerSession>> sessions_
      GECOS_GUARDED_BY(list_mutex_);  ///< by watch key
  std::vector<std::unique_ptr<Endpoint>> new_endpoints_ GECOS_GUARDED_BY(list_mutex_);
  std::atomic<bool> somebody_waits_{false};  // a client waits, but no descriptor was left for it
  std::atomic<bool> suspects_{false};  // tells the polling thread that some sessions may be gone

  Mutex standby_mutex_;
  ConditionVariable standby_called_;
  bool standby_wanted_ GECOS_GUARDED_BY(standby_mutex_) = false;
  std::uint64_t handler_seen_ = 0;  ///< maintenance thread only: `handler_turn_` at the last tick
  TimePoint next_beat_{};
  std::thread main_;
  std::thread standby_;
};

}  // namespace gecos::session
