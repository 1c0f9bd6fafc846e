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

/// What a session connects to, so that another can be opened in its place.
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
/// object, opens a new session with it, and sends them there. A reading that finds no server within
/// `grace`, or its deadline, ends as it would have without failover. There is one per lab; its
/// thread starts with the first loss. Thread-safe.
class Failover final : public TickTarget, public std::enable_shared_from_this<Failover> {
 public:
  /// Maximum number of sessions in which a command is sent: a command that kills its server must
  /// not do so for ever.
  static constexpr int most_sessions = 4;
  /// Maximum number of commands of one session that wait for a server.
  static constexpr std::size_t most_pending = 256;

  explicit Failover(Context& lab);
  ~Failover() override;

  /// Takes over `commands` of the lost session `from`, to send them again. @pre no other thread or
  /// session has them
  void take(const std::shared_ptr<ClientConnection>& from, std::vector<PendingFailover> commands);
  /// `from` is UNREACHABLE. If another server now serves its object, its idempotent calls are sent
  /// there.
  void look_for_another(const std::shared_ptr<ClientConnection>& from);
  /// Ends the commands whose time is over.
  TimePoint on_tick(TimePoint now) override;
  /// The lab ends: commands that wait for failover end now.
  void end();

 private:
  struct Search {
    std::shared_ptr<ClientConnection> from;
    std::vector<PendingFailover> commands;
    TimePoint next{};
    std::string why;  ///< why no server was found so far
  };
  /// Returns false when no thread can be created. @pre not after the end
  bool started() GECOS_REQUIRES(mutex_);
  Search& search_of(const std::shared_ptr<ClientConnection>& from) GECOS_REQUIRES(mutex_);
  void run();
  /// Releases the mutex while it searches; the entry in `searches_` may be removed meanwhile, so
  /// `from` is a copy.
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
