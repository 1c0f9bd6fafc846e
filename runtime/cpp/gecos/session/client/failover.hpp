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

/// What a session was opened for, so that another can be opened in its place.
struct ConnectTarget {
  std::string name;
  const InterfaceDescription& wanted;
  CreateOptions options;
};

/// A command whose session was lost, and what it ends as when it cannot be sent again.
struct PendingFailover {
  std::shared_ptr<PendingCommand> command;
  Failure failure;
  TimePoint give_up{};
};

/// Sends `@idempotent` readings again whose session was lost before they had ended: looks for their
/// object, opens a new session with it underneath, and sends them there. What finds no server
/// within `grace`, or its deadline, ends as it would have without. One of a lab; its thread starts
/// with the first loss. Thread-safe.
class Failover final : public TickTarget, public std::enable_shared_from_this<Failover> {
 public:
  /// In so many sessions a command is sent: one that kills its server does not do so for ever.
  static constexpr int most_sessions = 4;
  /// So many of one session wait for a server.
  static constexpr std::size_t most_pending = 256;

  explicit Failover(Context& lab);
  ~Failover() override;

  /// Has to be sent again: `from` is lost. They belong to nobody else.
  void take(const std::shared_ptr<ClientConnection>& from, std::vector<PendingFailover> commands);
  /// `from` is UNREACHABLE: when another server has its object, what may go there goes there.
  void look_for_another(const std::shared_ptr<ClientConnection>& from);
  /// Ends those whose time is over.
  TimePoint on_tick(TimePoint now) override;
  /// The lab ends: commands that wait for failover end now.
  void end();

 private:
  struct Search {
    std::shared_ptr<ClientConnection> from;
    std::vector<PendingFailover> commands;
    TimePoint next{};
    std::string why;  ///< nothing was found so far
  };
  /// False when no thread can be had for it. @pre not after the end
  bool started() GECOS_REQUIRES(mutex_);
  Search& search_of(const std::shared_ptr<ClientConnection>& from) GECOS_REQUIRES(mutex_);
  void run();
  /// Gives the mutex up meanwhile, in which the search may end. `from` is a copy therefore.
  void look(std::shared_ptr<ClientConnection> from) GECOS_REQUIRES(mutex_);
  tl::expected<std::shared_ptr<ClientConnection>, std::string> find(ClientConnection& from);
  std::vector<PendingFailover> send_to(ClientConnection& found,
                                       std::vector<PendingFailover> commands);

  Context& lab_;
  const pid_t owner_;  ///< a forked child has none of the threads that end what waits for failover
  Mutex mutex_;
  ConditionVariable changed_;
  std::vector<Search> searches_ GECOS_GUARDED_BY(mutex_);
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
  std::thread thread_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
