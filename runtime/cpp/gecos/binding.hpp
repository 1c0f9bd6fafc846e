#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/builtin_operations.hpp"
#include "gecos/lab.hpp"

/// Functions for language bindings and the broker program, in addition to the public headers.
namespace gecos::session {

/// The incarnation of this process: a random number, drawn at first use. A forked child draws its
/// own.
IncarnationId process_incarnation();

/// The parts of a Lab that its users do not need.
struct LabAccess {
  static const LabOrWhyNot& context(const Lab& lab) { return lab.core_; }
  /// A Lab that passes each medium through `wrap` when it opens the medium: a test wraps it in one
  /// that loses packets (gecos/media/testing/faulty.hpp).
  static Lab with_media(LabOptions options, media::WrapMedium wrap);
};

/// The session of `lab` with its broker, opened when there is none; on failure, what was tried.
/// @pre `lab` holds a value.
tl::expected<std::shared_ptr<ClientSession>, std::string> broker_session(const LabOrWhyNot& lab,
                                                                         TimePoint deadline);

/// Decides when to try again to create a proxy for an object that is not online. A broker announces
/// no changes, so it is asked again: after 20, 40, 80, then every 160 ms.
class CreateWait {
 public:
  /// `longest`: how long to wait from `now` on; Duration::max() for no limit.
  CreateWait(const std::vector<std::string>& names, Duration longest, TimePoint now);

  /// When to try again, after a try that ended at `now` and failed as `why` says; nullopt when the
  /// wait is over, or when none of the objects can come online.
  std::optional<TimePoint> next(const CreateError& why, TimePoint now);

 private:
  TimePoint until_;
  Duration pause_ = std::chrono::milliseconds(20);
};

struct BrokerPlace {
  std::string address;
  IncarnationId incarnation{};  ///< of the broker's process
};
/// The brokers that answer at the addresses where programs of this host may look for a broker.
/// Waits at most `patience` at each address. @pre `lab` holds a value.
std::vector<BrokerPlace> find_brokers(const LabOrWhyNot& lab, Duration patience);

/// Requests a status; the command is Queued while the request waits in line, for at most `timeout`.
std::shared_ptr<CommandCore> ask_for_status(ClientSession& session, Status wanted,
                                            const std::string& password, Duration timeout);
/// The lease that `asked`, a request for a status, was granted. @pre `asked` is terminal
tl::expected<Lease, LeaseRefusal> lease_from(const std::shared_ptr<ClientSession>& session,
                                             CommandCore& asked);
/// Withdraws `asked`, a request for a status, and releases the status if it is granted
/// nevertheless. Does not wait.
void decline_status(const std::shared_ptr<ClientSession>& session,
                    const std::shared_ptr<CommandCore>& asked);

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
