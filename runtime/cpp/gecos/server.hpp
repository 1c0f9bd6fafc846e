#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "gecos/lab.hpp"
#include "gecos/servant.hpp"

namespace gecos {
namespace session {
struct Visitors;  // gecos/binding.hpp; for the program of the broker
}

struct ObjectOptions {
  bool simulated = false;    ///< the object is a simulation and moves no hardware
  bool thread_safe = false;  ///< handlers may run on several threads at once
  bool blocking = false;     ///< every handler runs on a worker thread of the object
  /// Called at once, on the maintenance thread, when a client stops the object. Must not block.
  std::function<void()> on_stop{};
  /// Media that clients may use; empty: all media that are available on this host.
  std::vector<media::Kind> media{};
  bool well_known = false;  ///< clients find it at the host's well-known address, without a broker
  Duration patience = std::chrono::seconds(10);  ///< how long to wait for a broker that is starting
  /// The users whom the broker admits as visitors, who may only look for the objects that admit
  /// these users. Only the program of the broker sets this member; in every other program it is
  /// null.
  std::shared_ptr<const session::Visitors> visitors{};
};

struct ServeError {
  std::string text;
};
std::ostream& operator<<(std::ostream& out, const ServeError& error);

/// The users and hosts that a server admits.
enum class Admission : std::uint8_t {
  /// Admits the user of the server on its host, and the users and hosts that `Server::allow` and
  /// the lab file name.
  Listed,
  /// Admits every user and host that the kernel or an admitted key proves; `Server::allow` and the
  /// `[allow]` tables of the lab file do not count. A server with this admission serves simulated
  /// objects only, and says so on stderr, in its audit and in the descriptions of its objects.
  /// Keys, encryption, statuses, passwords, administrators and presence stay in force.
  Insecure,
};

/// Runs objects in this process: registers them with the lab's broker (and again when a new broker
/// starts), accepts clients, queues commands and keeps leases. One I/O thread polls the connections
/// and runs short handlers. Cancelable operations run on a worker thread of their object.
///
/// The constructor does not fail. When this process has no thread or descriptor left, `add` and
/// `await_broker` fail with that reason.
class Server {
 public:
  explicit Server(Lab& lab, Admission admission = Admission::Listed);
  ~Server();  ///< withdraws all objects; running commands are interrupted
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Waits until the lab's broker answers. On failure, the error names the addresses at which no
  /// broker was found. `add` also waits for the broker.
  tl::expected<void, ServeError> await_broker(Duration patience);
  /// Serves `servant` under `name` from now on. The servant must outlive the server. Fails when no
  /// other process could reach the object, unless `options.media` limits the object to this
  /// process. Also fails when the server is Admission::Insecure and the object is not simulated.
  /// Logs a warning for each medium that is not available.
  [[nodiscard("check the result: its error says why the object is not served")]] tl::expected<
      void, ServeError>
  add(std::string name, Servant& servant, ObjectOptions options = {});
  void add(std::string, Servant&&, ObjectOptions = {}) = delete;  // must outlive the server
  /// Names the users and hosts that may connect to all objects of this server, in addition to the
  /// user of this process on this host: for example `allow({"anna"})`. "*" admits every name. If
  /// the lab file also has a list for an object, both lists must admit a client. Applies to
  /// connections that are made after the call, and replaces the names of an earlier call. The
  /// server tells the broker these names, except the names that the lab file of this server does
  /// not admit. The broker lets these users find the objects of this server. A user whom the lab
  /// file of the broker does not admit may do nothing else at the broker. Throws
  /// std::invalid_argument if there are more than 256 users or more than 256 hosts, or if a name is
  /// empty, is not UTF-8, or has more than 256 bytes or a control character. Programs of another
  /// user of this host can connect only if an administrator has prepared the host for this
  /// (docs/security.md). Does not lower the status that an operation needs.
  void allow(std::vector<std::string> users, std::vector<std::string> hosts = {});
  /// Waits until any thread of the process gets SIGINT or SIGTERM, or until `shut_down()`. Logs an
  /// error and returns at once when the server could not be made.
  void run();
  /// Ends `run()`. May be called from any thread.
  void shut_down();

 private:
  class Core;
  /// The core of the server, or an error that says why the server could not be made.
  tl::expected<std::unique_ptr<Core>, std::string> core_;
};

}  // namespace gecos
