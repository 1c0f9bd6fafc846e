#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "gecos/lab.hpp"
#include "gecos/servant.hpp"

namespace gecos {

struct ObjectOptions {
  bool simulated = false;    ///< undeclared counts as hardware
  bool thread_safe = false;  ///< handlers may run on several threads at once
  bool blocking =
      false;  ///< every handler runs on the object's worker, none on the thread that polls
  /// Called at once, on a maintenance thread, when somebody stops the object: must not block.
  std::function<void()> on_stop{};
  /// Media that clients may use; empty: all that can be opened here.
  std::vector<media::Kind> media{};
  bool well_known = false;  ///< at the host's well-known place instead of in the broker's list
  Duration patience = std::chrono::seconds(10);  ///< how long to wait for a broker that is starting
};

struct ServeError {
  std::string text;
};

/// Runs objects in this process: registers them with the lab's broker (and again when a new broker
/// comes up), accepts clients, queues commands, keeps leases. One I/O thread polls and runs short
/// handlers; cancelable ones run on a worker of their object.
///
/// Making one does not fail: where this process has no thread or descriptor left for it, `add` and
/// `await_broker` say so.
class Server {
 public:
  explicit Server(Lab& lab);
  ~Server();  ///< withdraws all objects; running commands are interrupted
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Waits until the lab's broker answers; else says where it was looked for. `add` does this too.
  tl::expected<void, ServeError> await_broker(Duration patience);
  /// Serves `servant` under `name` from now on. The servant must outlive the server. Fails when no
  /// other process could reach it, unless `options.media` asks for no more; a medium that cannot be
  /// had is named in a warning.
  tl::expected<void, ServeError> add(std::string name, Servant& servant,
                                     ObjectOptions options = {});
  /// Waits until SIGINT or SIGTERM, whichever thread gets it, or `shut_down()`. Returns at once,
  /// with an error in the log, from a server that could not be made.
  void run();
  /// Ends `run()`. Any thread.
  void shut_down();

 private:
  class Core;
  tl::expected<std::unique_ptr<Core>, std::string> core_;  ///< or why it could not be made
};

}  // namespace gecos
