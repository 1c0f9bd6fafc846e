#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "gecos/base/checked_result.hpp"
#include "gecos/media/kinds.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/object.hpp"

namespace gecos {

struct LabOptions {
  /// Address of the broker, "shm:…" or "lcm:…". Empty: `GECOS_BROKER`, else this host's broker.
  std::string broker{};
  /// The name of this program that others see. Empty: the name of its executable.
  std::string program{};
  Duration grace = std::chrono::seconds(1);  ///< how long a lost peer may stay UNREACHABLE
  Duration lease_ttl = std::chrono::milliseconds(500);  ///< silence that ends a session
  Duration heartbeat = std::chrono::milliseconds(100);
  /// What is used in place of a medium when it is opened; null: the medium itself. A double that
  /// loses packets (gecos/media/testing/faulty.hpp), say.
  std::function<std::unique_ptr<media::Medium>(std::unique_ptr<media::Medium>)> wrap_medium{};
};

struct CreateOptions {
  /// The medium to use; `create` fails when this one is impossible although others exist.
  std::optional<media::Kind> medium{};
  /// Longest wait for an answer of the broker and of the server.
  Duration patience = std::chrono::seconds(2);
  /// Life of the server process that is meant, as in an ObjectRef; 0: whichever it has now.
  std::uint64_t incarnation = 0;
};

/// Why `create` gave nothing: a reason per name that was tried.
struct CreateError {
  struct Attempt {
    std::string name;
    Detail detail = Detail::NoServer;  ///< NoServer, Refused, QosUnavailable
    std::string reason;
  };
  std::vector<Attempt> attempts;
  std::string to_string() const;
};
std::ostream& operator<<(std::ostream& out, const CreateError& error);

namespace session {
class Context;
/// An opened session and what had to be passed over to get it.
struct Created {
  std::shared_ptr<ClientSession> session;
  CreateError passed_over;
};
/// Why a Lab stands on nothing.
struct NoLab {
  std::string text;
  /// What this process has no more of; nothing where its environment asks for what there is none
  /// of.
  std::optional<std::system_error> missing{};
};
using LabOrWhyNot = tl::expected<std::shared_ptr<Context>, NoLab>;
/// "this process has nothing left for a Lab: eventfd (see `ulimit -n` …): Too many open files".
std::string nothing_left(std::string_view what_for, const std::system_error& why);
tl::expected<Created, CreateError> create(const LabOrWhyNot& lab,
                                          const InterfaceDescription& wanted,
                                          const std::vector<std::string>& names,
                                          const CreateOptions& options);
}  // namespace session

/// The laboratory as this process sees it: finds objects and connects to them. Thread-safe.
/// A process may have several; each has its own connection to a broker.
///
/// Making one does not fail: where this process has no thread or descriptor left for it, or
/// GECOS_LOG names no level, `create` and a Server's `add` give that as their reason.
class Lab {
 public:
  explicit Lab(LabOptions options = {});
  ~Lab();
  Lab(const Lab&) = delete;
  Lab& operator=(const Lab&) = delete;

  /// Says goodbye to every object, although proxies, leases or streams are still alive: leases are
  /// given back, what has arrived under them still finishes, calls that wait and readers of streams
  /// end, and what is called afterwards is CONNECTION_FAILED. `create` gives nothing any more.
  /// Servers of this lab go on. Takes at most about a second, and .2 s more for each server over
  /// lcm that does not answer; more than once does nothing.
  ///
  /// The destructor does none of this: a proxy keeps what it stands on, and its session ends with
  /// it.
  void close();

  /// The first of `names` that is online and of the right type. A result that is used unchecked
  /// ends the program with the text of its CreateError.
  template <class Proxy>
  Checked<Proxy, CreateError> create(const std::vector<std::string>& names,
                                     CreateOptions options = {}) {
    auto created = session::create(core_, Proxy::gecos_description(), names, options);
    if (!created) return tl::unexpected(std::move(created.error()));
    return Proxy(std::move(created->session));
  }
  /// Names written in place, `create<Manipulator>({"RX90", "SIM"})`: two literals in braces would
  /// also make one std::string.
  template <class Proxy>
  Checked<Proxy, CreateError> create(std::initializer_list<const char*> names,
                                     CreateOptions options = {}) {
    return create<Proxy>(std::vector<std::string>(names.begin(), names.end()), std::move(options));
  }
  template <class Proxy>
  Checked<Proxy, CreateError> create(std::string name, CreateOptions options = {}) {
    return create<Proxy>(std::vector<std::string>{std::move(name)}, options);
  }
  /// The object that is meant, as long as it is served by the process that the reference speaks of:
  /// one that was started since may have another state. A nil reference is refused.
  template <class Proxy>
  Checked<Proxy, CreateError> create(const ObjectRef& reference, CreateOptions options = {}) {
    if (reference.boot != 0) options.incarnation = reference.boot;
    return create<Proxy>(std::vector<std::string>{reference.name}, std::move(options));
  }

  const session::LabOrWhyNot& core() const { return core_; }

 private:
  const session::LabOrWhyNot core_;
};

}  // namespace gecos
