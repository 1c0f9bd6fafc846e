#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/access/access_policy.hpp"
#include "gecos/access/lab_file.hpp"
#include "gecos/access/visitors.hpp"
#include "gecos/base/ids.hpp"
#include "gecos/builtin_operations.hpp"
#include "gecos/lab.hpp"

namespace gecos {
struct Entry;
}

/// Functions for language bindings and the broker program, in addition to the public headers.
namespace gecos::session {

/// The incarnation of this process: a random number, drawn at first use. A forked child draws
/// another number.
IncarnationId process_incarnation();

/// Returns whether this process can use `entry.pid` as the pid of the server that `entry` names. It
/// can if the server runs on this machine, with the same runtime directory and in the same PID
/// namespace as this process. Otherwise an unrelated process here may have this pid.
bool sees_process(const Entry& entry);

/// Gives access to the parts of a Lab that its public functions hide, for language bindings, the
/// broker program and tests.
struct LabAccess {
  static const LabOrWhyNot& context(const Lab& lab) { return lab.core_; }
  /// Returns a Lab that passes each medium through `wrap` when the Lab opens the medium. For
  /// example, a test wraps each medium in a medium that loses packets
  /// (gecos/media/testing/faulty.hpp).
  static Lab with_media(LabOptions options, media::WrapMedium wrap);
};

/// Returns the session of `lab` with its broker. Opens the session when there is none. On failure
/// returns a text that says which addresses were tried. @pre `lab` holds a value.
tl::expected<std::shared_ptr<ClientSession>, std::string> broker_session(const LabOrWhyNot& lab,
                                                                         TimePoint deadline);

/// Opens a session with the object at `address`, such as "shm:…", without a broker. Only the
/// built-in operations can be called in it. On failure returns the reason.
/// @pre `lab` holds a value
tl::expected<std::shared_ptr<ClientSession>, std::string> session_at(const LabOrWhyNot& lab,
                                                                     const std::string& address,
                                                                     TimePoint deadline);

class BrokerNews;

/// Waits between two attempts to create a proxy while the object is not online. A wait ends when
/// the broker's list changes, when another broker answers, or after a second, because a server that
/// did not answer the last attempt may answer the next one.
class CreateWait {
 public:
  /// `longest`: the maximum time to wait from now on; Duration::max() for no limit.
  /// @pre `lab` holds a value
  CreateWait(const LabOrWhyNot& lab, const std::vector<std::string>& names, Duration longest);
  ~CreateWait();

  /// Returns whether to wait after an attempt that failed for the reasons in `why`. Returns false
  /// when the time is over or the Lab is closed. Also returns false when no name in `why` failed as
  /// NO_SERVER, because waiting helps only against NO_SERVER.
  bool helps(const CreateError& why) const;
  /// Waits until the next try may succeed, at most until `until`. Returns whether to try again.
  bool wait(TimePoint until = TimePoint::max());

 private:
  const std::shared_ptr<Context> lab_;
  TimePoint until_;
  std::unique_ptr<BrokerNews> news_;
};

/// Returns the address of the broker in the lab file. Programs use this address if neither
/// LabOptions::broker nor GECOS_BROKER names a broker. The lab file is the file that GECOS_LAB_FILE
/// names, else /etc/gecos/lab.toml if that file exists. On failure returns why programs find no
/// broker, and what to do.
tl::expected<access::LabBroker, std::string> broker_in_lab_file(Duration patience);

struct BrokerPlace {
  std::string address;
  IncarnationId incarnation{};  ///< incarnation of the broker's process
};
/// Returns the brokers that answer at the addresses at which programs of this host may look for a
/// broker. Waits at most `patience` at each address. @pre `lab` holds a value.
std::vector<BrokerPlace> find_brokers(const LabOrWhyNot& lab, Duration patience);

/// Requests the status `wanted`. While other clients hold the status, the request waits at the
/// server for at most `timeout`; the returned command is then Queued.
std::shared_ptr<CommandCore> ask_for_status(ClientSession& session, Status wanted,
                                            const std::string& password, Duration timeout);
/// Returns the reply to `asked`, a request for a status: the granted lease, or the refusal.
/// @pre `asked` is terminal
tl::expected<Lease, LeaseRefusal> lease_from(const std::shared_ptr<ClientSession>& session,
                                             CommandCore& asked);
/// Withdraws `asked`, a request for a status, and releases the status if the server grants the
/// status nevertheless. Does not wait.
void decline_status(const std::shared_ptr<ClientSession>& session,
                    const std::shared_ptr<CommandCore>& asked);

class CallCore;

/// Returns why the client that issued `call` may not register an object under `name`; an empty text
/// when the client may. The broker calls this function. The table [names] of the lab file decides.
/// A refusal is written to the audit.
std::string refusal_to_register(const CallCore& call, const std::string& name);

/// The user of a client. The kernel, or the key that the client has proved, names this user.
struct ProvedUser {
  access::UserAtHost who;
  std::string key{};  ///< 64 hexadecimal digits; empty if the kernel names the user
  /// Pid of the client; no value if the kernel does not name the pid.
  std::optional<std::int32_t> pid;
};
/// Returns the user who issued `call`. Returns no value for the user of the broker and for root on
/// the broker's host, because the broker trusts the registrations of these two users. The broker
/// calls this function.
std::optional<ProvedUser> other_user_of(const CallCore& call);

/// Returns the user of the client that issued `call` if this client is a visitor; otherwise no
/// value. The broker calls this function.
std::optional<access::UserAtHost> visitor_of(const CallCore& call);

/// The users whom the broker admits as visitors (access/visitors.hpp), and the operations and
/// streams that visitors may use.
struct Visitors {
  access::VisitorBook book{};
  std::vector<FunctionCode> open{};  ///< codes of the operations and streams for visitors
};

class HandlerHere;

/// Records, while this object lives, that the handler on this thread waits for `command` without a
/// time-out. Does nothing when no handler runs on this thread.
class WaitsHere {
 public:
  explicit WaitsHere(const CommandCore& command);
  ~WaitsHere();
  WaitsHere(const WaitsHere&) = delete;
  WaitsHere& operator=(const WaitsHere&) = delete;

 private:
  std::shared_ptr<HandlerHere> handler_;
};

}  // namespace gecos::session
