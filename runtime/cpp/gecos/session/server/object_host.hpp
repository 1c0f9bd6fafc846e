#pragma once

#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "gecos/server.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/server/call_runner.hpp"
#include "gecos/session/server/handler_waits.hpp"
#include "gecos/session/server/host_state.hpp"
#include "gecos/session/server/name_confirmation.hpp"
#include "gecos/session/server/object_inward.hpp"
#include "gecos/session/server/object_streams.hpp"
#include "gecos/session/server/presence_guard.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// One object of a server: admits and queues calls, keeps the leases, runs handlers and sends
/// replies. Every accepted call is answered exactly once, either by its handler or by the event
/// that ended it. Thread-safe. This class has more methods than other classes, because all threads
/// of the server reach the calls, the leases and the streams of the object through it.
class ObjectHost final : public Publisher {
 public:
  /// `audit`: null if nothing is recorded.
  ObjectHost(std::shared_ptr<Runtime> runtime, std::string name, Servant& servant,
             ObjectOptions options, std::shared_ptr<audit::Audit> audit = nullptr,
             UserRights rights = {}, std::string zone = {});
  /// Ends the user callbacks first, so that no callback uses destroyed members.
  ~ObjectHost() override { state_.user_callbacks.end(); }
  ObjectHost(const ObjectHost&) = delete;
  ObjectHost& operator=(const ObjectHost&) = delete;

  const std::string& name() const { return state_.setup.name; }
  const InterfaceDescription& interface() const { return state_.setup.interface; }
  const ObjectSetup& setup() const { return state_.setup; }
  PeerLiveness::Bounds bounds_of_clients() const;
  CallRunner& runner() { return runner_; }
  HandlerWaits& waits() { return waits_; }
  NameConfirmation& name_confirmation() { return name_confirmation_; }
  PresenceGuard& presence() { return presence_; }
  ObjectStreams& streams() { return streams_; }
  const ObjectInward& inward() const { return inward_; }

  // The I/O loop (IoLoop) calls the following functions.

  /// Processes one packet of `session`. Starts no call: `run_ready` must be called afterwards.
  void take(const std::shared_ptr<ServerSession>& session, ByteView packet);
  /// Like `take`, but returns a call that may start now, or null. The caller must then pass the
  /// call to `run_ready`.
  std::shared_ptr<ServerCall> take_and_start(const std::shared_ptr<ServerSession>& session,
                                             ByteView packet, Starter starter);
  /// Runs the handler of `started`, unless `started` is null, and the handlers of all calls that
  /// may start.
  void run_ready(Starter starter, std::shared_ptr<ServerCall> started = nullptr) {
    runner_.run_ready(starter, std::move(started));
  }
  /// Returns false when `run_ready` has nothing to do. The result is only a hint, because the mutex
  /// is not locked.
  bool ready() const { return state_.ready.load(std::memory_order_acquire); }
  /// The way in which the connection of a session ended. After InOrder the commands of the session
  /// continue, and its status ends with its last command.
  enum class Departure : std::uint8_t { InOrder, Lost };
  /// `because`: completes the sentence "the client …", which says why the client's status is lost.
  void depart(const std::shared_ptr<ServerSession>& session, Departure how,
              const std::string& because = "is gone");
  /// Must be called after this process was suspended. Calls of `session` then start only after the
  /// next heartbeat of its client.
  void await_sign_of_life(ServerSession& session);
  /// Checks the heartbeats of `session`. Must be called at every tick. Returns true when the
  /// session must end, because the client was silent for too long or does not read its replies.
  bool check_liveness(const std::shared_ptr<ServerSession>& session);

  // The maintenance thread calls the following functions.

  /// Ends the actor commands that ran during a pause of this process. `stood_still`: the length of
  /// the pause. After a long pause the broker must confirm the object's name again.
  void after_pause(Duration stood_still);
  /// Handles deadlines, leases and pending progress reports, and starts calls that no other thread
  /// starts. Returns the time of the next tick.
  TimePoint on_tick(TimePoint now);

  void publish(const StreamDescription& stream, ByteView sample, std::int64_t stamp_ns) override;
  tl::expected<LentMemory, std::string> lend(const StreamDescription& stream,
                                             std::size_t size) override {
    return streams_.lend(stream, size);
  }
  bool publish_lent(const StreamDescription& stream, const LentMemory& memory,
                    std::int64_t stamp_ns) override;
  void give_back(const StreamDescription& stream, const LentMemory& memory) override {
    streams_.give_back(stream, memory);
  }
  InwardCore* inward(const InwardDescription& stream) override { return inward_.find(stream.code); }

  /// Ends all calls of the object as STOPPED, and refuses later calls.
  void close();
  bool closed();
  std::string served_as() override;  ///< takes no lock: a forked child may ask
  /// Waits until the handlers have returned. After that no other thread calls the servant or the
  /// user's callbacks. @pre the object is closed; the caller is not a handler
  void join();

 private:
  const pid_t owner_ = getpid();
  std::atomic<bool> served_{true};  // protects no other data, so relaxed is enough
  HostState state_;
  HandlerWaits waits_;
  NameConfirmation name_confirmation_;
  PresenceGuard presence_;
  ObjectStreams streams_;
  ObjectInward inward_;
  CallRunner runner_;  ///< last member, so that its threads end first
};

}  // namespace gecos::session
