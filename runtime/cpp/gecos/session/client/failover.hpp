#pragma once

#include <sys/types.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/base/result.hpp"
#include "gecos/command.hpp"
#include "gecos/lab.hpp"
#include "gecos/session/process/maintenance.hpp"

namespace gecos::session {

class Context;
class ClientConnection;
class PendingCommand;

/// The object that a session connects to. It is kept so that another session with the object can
/// replace the session.
struct ConnectTarget {
  std::string name;
  const InterfaceDescription& wanted;
  CreateOptions options;
};

/// A command whose session was lost. `failure`: how the command ends if it cannot be sent again.
struct PendingFailover {
  std::shared_ptr<PendingCommand> command;
  Failure failure;
  TimePoint give_up{};
};

/// Sends `@idempotent` readings again when a session was lost before its readings ended: looks up
/// the object of the lost session, opens a new session with the object, and sends the readings in
/// the new session. If no server is found within `grace` or before the deadline of a reading, the
/// reading fails as it would without failover. Each lab has one Failover. The thread of the
/// Failover starts with the first loss. Thread-safe.
class Failover final : public TickTarget, public std::enable_shared_from_this<Failover> {
 public:
  /// Maximum number of sessions in which one command is sent. Without a limit, a command that
  /// crashes its server would crash every later server too.
  static constexpr int most_sessions = 4;
  /// Maximum number of commands of one session that wait for a server.
  static constexpr std::size_t most_pending = 256;

  /// A function that searches for another session. It may block for about a second.
  using Job = std::function<void(Context&)>;

  explicit Failover(Context& lab);
  ~Failover() override;

  /// Takes over `commands` of the lost session `from` and sends them again in another session. @pre
  /// no other thread or session has these commands
  void take(const std::shared_ptr<ClientConnection>& from, std::vector<PendingFailover> commands);
  /// Must be called when the server of the session `from` is UNREACHABLE. If another server now
  /// serves the object of `from`, the idempotent calls of `from` are sent to that server.
  void look_for_another(const std::shared_ptr<ClientConnection>& from);
  /// Runs `job` soon, on the thread of this object. If there is no such thread, returns why.
  tl::expected<void, std::string> run_soon(Job job);
  /// Ends the commands whose `grace` or deadline has passed.
  NextTick on_tick(TimePoint now) override;
  /// Called when the lab is closed: ends the commands that wait for failover.
  void end();

 private:
  struct Search {
    std::shared_ptr<ClientConnection> from;
    std::vector<PendingFailover> commands;
    TimePoint next{};
    std::string why;  ///< why no server was found so far
  };
  /// Starts the failover thread if it does not run yet. Returns false when the thread cannot be
  /// created. @pre `end` was not called
  bool started() GECOS_REQUIRES(mutex_);
  Search& search_of(const std::shared_ptr<ClientConnection>& from) GECOS_REQUIRES(mutex_);
  void run();
  void run_job() GECOS_REQUIRES(mutex_);
  /// Looks for a server for the commands of `from`. Releases the mutex during the search. `from` is
  /// a copy of a pointer in `searches_`, because the entry of this pointer may be removed during
  /// the search.
  void look(std::shared_ptr<ClientConnection> from) GECOS_REQUIRES(mutex_);
  tl::expected<std::shared_ptr<ClientConnection>, std::string> find(ClientConnection& from);
  std::vector<PendingFailover> send_to(ClientConnection& found,
                                       std::vector<PendingFailover> commands);

  /// `lab_` is valid until `end` returns. The maintenance thread may call `on_tick` of this
  /// Failover even later, so `on_tick` uses `clock_` and not `lab_`.
  Context& lab_;
  const Clock& clock_;
  /// Id of the process that created this object. In a forked child the failover thread does not
  /// exist.
  const pid_t owner_;
  Mutex mutex_;
  ConditionVariable changed_;
  std::vector<Search> searches_ GECOS_GUARDED_BY(mutex_);
  std::deque<Job> jobs_ GECOS_GUARDED_BY(mutex_);
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
  std::thread thread_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
