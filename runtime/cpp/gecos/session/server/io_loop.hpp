#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/waiting.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/server/access_control.hpp"
#include "gecos/session/server/active_sessions.hpp"
#include "gecos/session/server/epoll.hpp"
#include "gecos/session/server/heartbeat_looks.hpp"
#include "gecos/session/server/key_review.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/session/server/poller_sleep.hpp"
#include "gecos/session/server/session_list.hpp"
#include "gecos/session/server/standby_call.hpp"

namespace gecos::session {

/// The I/O loop of a server: accepts clients, polls their connections for packets, and runs short
/// handlers between two polls.
///
/// Only active connections are polled. A connection that was silent for 10 ms is put to sleep and
/// costs nothing until its descriptor reports a packet. One thread polls at a time. The thread
/// releases `polling_` while it runs a handler. When a handler takes longer than a maintenance
/// tick, a standby thread polls instead, so only the callers of this handler wait for it. This
/// class has more members than other classes, because the members belong to three threads; comments
/// say which thread uses a member.
class IoLoop {
 public:
  /// `access` decides whether the client of each session is still admitted.
  IoLoop(std::shared_ptr<Runtime> runtime, std::shared_ptr<AccessControl> access);
  ~IoLoop();

  /// Accepts clients of `object` from now on.
  void serve(std::shared_ptr<ObjectHost> object, std::shared_ptr<media::Acceptor> acceptor);
  /// Disconnects the clients of `object` and accepts no further clients. Waits until the threads of
  /// this loop run no handler of `object`. @pre `object` is closed; the caller is no handler of it
  void withdraw(ObjectHost& object);
  /// Must be called on the maintenance thread after a pause of this process. Calls of a session
  /// then start only after the next heartbeat of the session's client.
  void await_signs_of_life();
  /// Sends heartbeats, detects silent clients and lost connections, and wakes the standby thread.
  /// Runs on the maintenance thread. Returns the time of the next tick.
  TimePoint on_tick(TimePoint now);
  /// Returns a descriptor that becomes readable when the maintenance thread must call `on_tick`
  /// before the time that the last `on_tick` returned.
  int descriptor() const { return sleep_.descriptor(); }
  /// Waits for running handlers, ends both threads, then disconnects the clients.
  void end();

 private:
  struct Endpoint {
    std::shared_ptr<ObjectHost> object;
    std::shared_ptr<media::Acceptor> acceptor;
  };
  /// What ended the last sleep of the polling thread. `rang_at`: the time at which the client sent
  /// the wake-up that ended the sleep.
  struct Wake {
    media::Woken by = media::Woken::Early;
    TimePoint rang_at{};
  };

  void run();
  void run_standby();
  /// Runs the handlers of `started` and of the calls that may start. Releases `polling_` while the
  /// handlers run.
  void run_handlers(ObjectHost& object, std::shared_ptr<ServerCall> started, Starter starter)
      GECOS_REQUIRES(polling_);
  bool main_is_inside() const { return handler_turn_.load() % 2 == 1; }
  /// Polls every active session once. Sleeps when no session is active any more.
  void turn() GECOS_REQUIRES(polling_);
  bool poll_active() GECOS_REQUIRES(polling_);
  void activate(const std::shared_ptr<ServerSession>& session) GECOS_REQUIRES(polling_);
  void take_events(int milliseconds) GECOS_REQUIRES(polling_);
  /// Waits at most `milliseconds` for events and handles them. Returns whether one of these events
  /// came from an acceptor.
  bool handle_events(int milliseconds) GECOS_REQUIRES(polling_);
  void add_endpoints() GECOS_REQUIRES(polling_);
  void accept(Endpoint& endpoint) GECOS_REQUIRES(polling_);
  void accept_all() GECOS_REQUIRES(polling_);
  void watch(const std::shared_ptr<ServerSession>& session) GECOS_REQUIRES(polling_);
  void part_from_suspects() GECOS_REQUIRES(polling_);
  void drop_closed_endpoints() GECOS_REQUIRES(polling_);
  void part_if_lost(const std::shared_ptr<ServerSession>& session);
  TimePoint next_look_at(ServerSession& session, bool sent, TimePoint now) const;
  /// Ends the sessions whose clients are not admitted any more. Returns whether any session was
  /// ended.
  bool end_revoked(TimePoint now);
  /// Ends the session of a client that is not admitted any more. Returns false if the session has
  /// ended already.
  bool revoke(const std::shared_ptr<ServerSession>& session, const std::string& why);

  const std::shared_ptr<Runtime> runtime_;
  const std::shared_ptr<AccessControl> access_;
  Epoll epoll_;
  EventFd event_;
  std::atomic<bool> ended_{false};              // orders no other memory
  std::atomic<std::uint64_t> handler_turn_{0};  // odd while main_ runs a handler; written by main_
  /// The object whose handlers `main_` runs, or ran last. `handler_turn_` publishes it.
  std::atomic<const ObjectHost*> handled_{nullptr};

  FutexMutex polling_;  ///< held by the thread that polls
  media::SpinPolicy spin_ GECOS_GUARDED_BY(polling_);
  /// The served objects with their acceptors. An element becomes null when its object is withdrawn.
  std::vector<std::unique_ptr<Endpoint>> endpoints_ GECOS_GUARDED_BY(polling_);
  ActiveSessions active_ GECOS_GUARDED_BY(polling_);
  Wake wake_ GECOS_GUARDED_BY(polling_);
  unsigned turns_ GECOS_GUARDED_BY(polling_) = 0;
  std::thread::id main_id_ GECOS_GUARDED_BY(polling_);

  SessionList sessions_;
  Mutex new_endpoints_mutex_;
  std::vector<std::unique_ptr<Endpoint>> new_endpoints_ GECOS_GUARDED_BY(new_endpoints_mutex_);
  std::atomic<bool> somebody_waits_{false};  // a client waits for a free descriptor
  std::atomic<bool> suspects_{false};  // tells the polling thread that some connections may be lost

  StandbyCall standby_call_;
  PollerSleep sleep_;  ///< records whether `main_` sleeps
  /// The value of `handler_turn_` at the last tick. Only the maintenance thread uses this member.
  std::uint64_t handler_seen_ = 0;
  OwnHeartbeats heartbeats_;
  TimePoint next_review_{};
  KeyReview keys_;
  std::thread main_;
  std::thread standby_;
};

}  // namespace gecos::session
