#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/lab.hpp"

/// What bindings of other languages and the broker's own program need beside the headers that users
/// include.
namespace gecos::session {

/// This life of this process: drawn at random at first use. A forked child has one of its own.
IncarnationId process_incarnation();

/// The lab's session with its broker, opened when there is none; else what was tried. `lab` holds
/// a core.
tl::expected<std::shared_ptr<ClientSession>, std::string> broker_session(const LabOrWhyNot& lab,
                                                                         TimePoint deadline);

struct BrokerPlace {
  std::string address;
  IncarnationId incarnation{};  ///< of the process that answers there
};
/// The brokers that answer at the places where programs of this host may look for one. Waits at
/// most `patience` at each. `lab` holds a core.
std::vector<BrokerPlace> find_brokers(const LabOrWhyNot& lab, Duration patience);

class HandlerHere;

/// While it lives, the handler that runs on this thread, if one does, waits for `command` without a
/// bound.
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
