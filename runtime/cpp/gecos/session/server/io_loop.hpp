#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
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
  using Polling = std::unique_lock<Mutex>;
  struct Epoll {
    Epoll();
    ~Epoll();
    const int descriptor;
  };

  void run();
  void run_standby();
  /// Gives polling up meanwhile.
  void run_handlers(ObjectHost& object, std::shared_ptr<ServerCall> started, Starter starter,
                    Polling& polling);
  bool main_is_inside() const { return handler_turn_.load() % 2 == 1; }
  /// One look at everything hot; sleeps when nothing is.
  void turn(Polling& polling);
  bool look_at_hot(Polling& polling);
  /// Where the clients are that may send next.
  media::Peers peers() const;
  bool arm_all();
  void cool_down(TimePoint now);
  void heat(const std::shared_ptr<ServerSession>& session);
  void take_events(int milliseconds, Polling& polling);
  void open_doors();
  void accept(Door& door);
  void accept_all();
  void watch(const std::shared_ptr<ServerSession>& session);
  void part_from_suspects();
  void shut_doors();
  void part_if_lost(const std::shared_ptr<ServerSession>& session);
  void add_descriptor(int descriptor, std::uint64_t key);

  const std::shared_ptr<Runtime> runtime_;
  const Epoll epoll_;
  Wakeup wakeup_;
  std::atomic<bool> ended_{false};              // publishes nothing but itself
  std::atomic<std::uint64_t> handler_turn_{0};  // main's alone: odd while it is in a handler

  Mutex polling_;  ///< held by who polls; guards what follows
  media::SpinPolicy spin_;
  std::vector<std::unique_ptr<Door>> doors_;  ///< null where an object was withdrawn
  std::vector<std::shared_ptr<ServerSession>> hot_;
  std::vector<std::shared_ptr<ServerSession>>
      still_hot_;  ///< of arm_all: kept, so that a wake-up needs no memory
  media::Woken woken_ = media::Woken::Early;  ///< by whom the last sleep ended …
  TimePoint rang_at_{};                       ///< … and when the client rang
  std::uint64_t next_key_ = 1;
  unsigned turns_ = 0;
  std::thread::id main_id_;

  std::mutex list_mutex_;  ///< held for moments; the map is written by who polls
  std::unordered_map<std::uint64_t, std::shared_ptr<ServerSession>> sessions_;  ///< by watch key
  std::vector<std::unique_ptr<Door>> new_doors_;
  std::atomic<bool> somebody_waits_{false};  // at a door, and there was no descriptor for him
  std::atomic<bool> suspects_{false};        // tells who polls that some sessions may be gone

  std::mutex standby_mutex_;
  std::condition_variable standby_called_;
  bool standby_wanted_ = false;
  std::uint64_t handler_seen_ = 0;  ///< maintenance: which handler ran at the last tick
  TimePoint next_beat_{};
  std::thread main_;
  std::thread standby_;
};

}  // namespace gecos::session
