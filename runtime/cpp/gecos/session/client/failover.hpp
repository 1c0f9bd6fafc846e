#pragma once

#include <sys/types.h>

#include <cstdint>
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

/// The object that a session connects to, kept so that another session can be opened in its place.
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

/// Sends `@idempotent` readings again when their session was lost before they ended: looks up their
/// object, opens a new session with it, and sends the readings there. If no server is found within
/// `grace` or before the deadline of a reading, the reading ends as it would have without failover.
/// Each lab has one Failover; its thread starts with the first loss. Thread-safe.
class Failover final : public TickTarget, public std::enable_shared_from_this<Failover> {
 public:
  /// Maximum number of sessions in which one command is sent. Without a limit, a command that
  /// crashes its server would crash every later server too.
  static constexpr int most_sessions = 4;
  /// Maximum number of commands of one session that wait for a server.
  static constexpr std::size_t most_pending = 256;

  explicit Failover(Context& lab);
  ~Failover() override;

  /// Takes over `commands` of the lost session `from`, to send them again. @pre no other thread or
  /// session has these commands
  void take(const std::shared_ptr<ClientConnection>& from, std::vector<PendingFailover> commands);
  /// Must be called when `from` is UNREACHABLE. If another server now serves the object of `from`,
  /// the idempotent calls of `from` are sent to that server.
  void look_for_another(const std::shared_ptr<ClientConnection>& from);
  /// Ends the commands whose `grace` or deadline has passed.
  TimePoint on_tick(TimePoint now) override;
  /// Called when the lab is closed: ends the commands that wait for failover.
  void end();

 private:
  struct Search {
    std::shared_ptr<ClientConnection> from;
    std::vector<PendingFailover> commands;
    TimePoint next{};
    std::string why;  ///< why no server was found so far
  };
  /// Starts the thread unless it runs. Returns false when no thread can be created. @pre `end` was
  /// not called
  bool started() GECOS_REQUIRES(mutex_);
  Search& search_of(const std::shared_ptr<ClientConnection>& from) GECOS_REQUIRES(mutex_);
  void run();
  /// Looks for a server for the commands of `from`. Releases the mutex during the search; the entry
  /// in `searches_` may be removed meanwhile, so `from` is a copy.
  void look(std::shared_ptr<ClientConnection> from) GECOS_REQUIRES(mutex_);
  tl::expected<std::shared_ptr<ClientConnection>, std::string> find(ClientConnection& from);
  std::vector<PendingFailover> send_to(ClientConnection& found,
                                       std::vector<PendingFailover> commands);

  /// Valid until `end` returns. A tick may come later, because the maintenance thread shares this
  /// object: it uses `clock_` alone.
  Context& lab_;
  const Clock& clock_;
  /// id of the creating process: a forked child has no thread to end waiting commands
  const pid_t owner_;
  Mutex mutex_;
  ConditionVariable changed_;
  std::vector<Search> searches_ GECOS_GUARDED_BY(mutex_);
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
  std::thread thread_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
