#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
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

struct BrokerPlace {
  std::string address;
  IncarnationId incarnation{};  ///< of the broker's process
};
/// The brokers that answer at the addresses where programs of this host may look for a broker.
/// Waits at most `patience` at each address. @pre `lab` holds a value.
std::vector<BrokerPlace> find_brokers(const LabOrWhyNot& lab, Duration patience);

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
