#pragma once

#include <sys/types.h>

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

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
  using Lock = std::unique_lock<std::mutex>;

  bool started();
  Search& search_of(const std::shared_ptr<ClientConnection>& from);
  void run();
  void look(std::shared_ptr<ClientConnection> from, Lock& lock);
  tl::expected<std::shared_ptr<ClientConnection>, std::string> find(ClientConnection& from);
  std::vector<PendingFailover> send_to(ClientConnection& found,
                                       std::vector<PendingFailover> commands);

  Context& lab_;
  const pid_t owner_;  ///< a forked child has none of the threads that end what waits for failover
  std::mutex mutex_;   ///< guards what follows
  std::condition_variable changed_;
  std::vector<Search> searches_;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace gecos::session
