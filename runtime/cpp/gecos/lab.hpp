#pragma once

#include <cstdint>
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
#include "gecos/explanation.hpp"
#include "gecos/media/kinds.hpp"
#include "gecos/object.hpp"
#include "gecos/qos/requested_quality.hpp"

namespace gecos {

struct LabOptions {
  /// Address of the broker, for example "shm:…" or "lcm:…". If this address is empty, the
  /// environment variable `GECOS_BROKER` gives the address. If that variable is not set either,
  /// `[broker] address` of the lab file gives the address. If the lab file gives no address, the
  /// broker of this host is used. `create` fails if the lab file is needed and cannot be used.
  std::string broker{};
  /// The path of the lab file. The lab file may give the address of the broker, and its lists say
  /// which users may connect to the objects that this program serves. The file must belong to root
  /// or to the user of this program, no other user may write to it, and its size is at most 64 KiB.
  /// If `lab_file` is empty, the environment variable `GECOS_LAB_FILE` gives the path. If that
  /// variable is not set either, the file is /etc/gecos/lab.toml, if it exists.
  std::string lab_file{};
  /// The name of this program that other programs see. Empty: the name of its executable.
  std::string program{};
  Duration grace = std::chrono::seconds(1);  ///< how long a peer may be UNREACHABLE before it is
                                             ///< lost
  Duration lease_ttl = std::chrono::milliseconds(500);  ///< silence after which a client loses its
                                                        ///< leases
  Duration heartbeat = std::chrono::milliseconds(100);
};

struct CreateOptions {
  /// The medium to use. `create` fails when this medium is not available, even if other media are
  /// available. Without a value, `create` uses the best available medium.
  std::optional<media::Kind> medium{};
  /// The medium over which the samples and events of the object must come in. Without a value, the
  /// member `medium` decides. `create` fails when this medium is not available, even if other media
  /// are available. If this medium differs from the medium of the calls, the proxy opens a second
  /// session with the object.
  std::optional<media::Kind> in{};
  /// The medium over which calls and inward samples must go out. The results of the calls come back
  /// over the same medium. Without a value, the member `medium` decides.
  std::optional<media::Kind> out{};
  /// The longest round trip that the program accepts, also from a simulated device. Zero: only the
  /// interface may limit the round trip. If there is a limit, `create` measures each medium by a
  /// few pings before it uses the medium. The measurement takes at most 2 s and at most `patience`.
  Duration latency{};
  /// The quality that the program requests in addition to the `@qos` of the interface. `create`
  /// fails with QosUnavailable when no medium meets the requested class, also for a simulated
  /// device. With `reliability`, a subscription fails over a medium that may lose samples.
  qos::RequestedQuality quality{};
  /// Longest wait for an answer of the broker and of the server.
  Duration patience = std::chrono::seconds(2);
  /// The time for which `create` keeps trying while one of the named objects is not online, or
  /// while no broker answers. Duration::max(): without limit. `create` does not wait when the
  /// object has the wrong type, or when the server of the object refuses this program. `create`
  /// waits while the broker refuses this program, because a server that starts may make the broker
  /// admit this program. If that does not happen in time, `create` fails with the refusal.
  Duration wait{};
  /// Required incarnation of the server process, as in an ObjectRef; 0: any.
  std::uint64_t incarnation = 0;
};

/// The reasons for which `create` failed, one for each name that was tried.
struct CreateError {
  struct Attempt {
    std::string name;
    Detail detail = Detail::NoServer;  ///< NoServer, Refused or QosUnavailable
    std::string reason;
  };
  std::vector<Attempt> attempts;
  std::string to_string() const;
};
std::ostream& operator<<(std::ostream& out, const CreateError& error);

namespace session {
class Context;
struct LabAccess;
/// A session that was opened, and the reasons for which the earlier names in the list were skipped.
struct Created {
  std::shared_ptr<ClientSession> session;
  CreateError passed_over;
};
/// Why a Lab could not be set up.
struct NoLab {
  std::string text;
  /// The system error when this process has no thread or descriptor left; no value when an
  /// environment variable is invalid.
  std::optional<std::system_error> missing{};
};
using LabOrWhyNot = tl::expected<std::shared_ptr<Context>, NoLab>;
/// Returns the error text for a missing resource, for example "this process has no resources left
/// for a Lab: eventfd (see `ulimit -n` …): Too many open files".
std::string nothing_left(std::string_view what_for, const std::system_error& why);
/// Like `create`, but makes only one attempt and ignores `options.wait`.
tl::expected<Created, CreateError> try_create(const LabOrWhyNot& lab,
                                              const InterfaceDescription& wanted,
                                              const std::vector<std::string>& names,
                                              const CreateOptions& options);
tl::expected<Created, CreateError> create(const LabOrWhyNot& lab,
                                          const InterfaceDescription& wanted,
                                          const std::vector<std::string>& names,
                                          const CreateOptions& options);
tl::expected<Explanation, CreateError> explain(const LabOrWhyNot& lab,
                                               const InterfaceDescription& wanted,
                                               const std::string& name,
                                               const CreateOptions& options);
}  // namespace session

/// The class of an interface's proxies, as gidl generates it.
template <class Proxy>
concept ClientClass = requires {
  Proxy::gecos_description();
};

/// The laboratory as this process sees it: finds objects and connects to them. Thread-safe. A
/// process may have several Labs; each has its own connection to a broker.
///
/// The constructor does not fail. When this process has no thread or descriptor left, or when the
/// environment variable GECOS_LOG is not a log level, `create` and `Server::add` fail with that
/// reason.
class Lab {
 public:
  explicit Lab(LabOptions options = {});
  ~Lab();
  Lab(const Lab&) = delete;
  Lab& operator=(const Lab&) = delete;

  /// Ends the sessions with all objects, even while proxies, leases or streams exist. Leases are
  /// released; commands that have arrived at the server still finish. Threads that wait for calls
  /// or samples return, and later calls end as CONNECTION_FAILED. From then on `create` fails.
  /// Servers of this lab continue. Takes at most about a second, plus 0.2 s for each server over
  /// lcm that does not answer. A second call does nothing.
  ///
  /// The destructor ends no session: a proxy keeps the parts of the lab that it needs, and its
  /// session ends with the last copy of the proxy.
  void close();

  /// Returns a proxy for the first object of `names` that is online and has the interface of Proxy.
  /// Using a failed result without a check ends the program with the text of the CreateError.
  template <ClientClass Proxy>
  Checked<Proxy, CreateError> create(const std::vector<std::string>& names,
                                     CreateOptions options = {}) {
    auto created = session::create(core_, Proxy::gecos_description(), names, options);
    if (!created) return tl::unexpected(std::move(created.error()));
    return Proxy(std::move(created->session));
  }
  /// An overload for names in braces, for example `create<Manipulator>({"RX90", "SIM"})`. Without
  /// this overload, two literals in braces could also construct a single std::string.
  template <ClientClass Proxy>
  Checked<Proxy, CreateError> create(std::initializer_list<const char*> names,
                                     CreateOptions options = {}) {
    return create<Proxy>(std::vector<std::string>(names.begin(), names.end()), std::move(options));
  }
  template <ClientClass Proxy>
  Checked<Proxy, CreateError> create(std::string name, CreateOptions options = {}) {
    return create<Proxy>(std::vector<std::string>{std::move(name)}, options);
  }
  /// Returns a proxy for the referenced object. Fails when the server process in the reference no
  /// longer serves the object, because a restarted server may be in another state. Also fails for a
  /// nil reference.
  template <ClientClass Proxy>
  Checked<Proxy, CreateError> create(const ObjectRef& reference, CreateOptions options = {}) {
    if (reference.boot != 0) options.incarnation = reference.boot;
    return create<Proxy>(std::vector<std::string>{reference.name}, std::move(options));
  }
  template <class Proxy, class... Rest>
  requires(!ClientClass<Proxy>) void create(Rest&&...) = delete;  // name a client class of gidl

  /// Returns the media over which `create<Proxy>(name)` would reach the object, and the reasons
  /// against each of the other media. Asks the broker, and opens no session with the object. Fails
  /// as `create` does when the object is not online or has another interface. Uses only `patience`
  /// and `incarnation` of `options`.
  template <ClientClass Proxy>
  Checked<Explanation, CreateError> explain(const std::string& name, CreateOptions options = {}) {
    auto told = session::explain(core_, Proxy::gecos_description(), name, options);
    if (!told) return tl::unexpected(std::move(told.error()));
    return *std::move(told);
  }

 private:
  friend struct session::LabAccess;
  explicit Lab(session::LabOrWhyNot core) : core_(std::move(core)) {}

  const session::LabOrWhyNot core_;
};

}  // namespace gecos
