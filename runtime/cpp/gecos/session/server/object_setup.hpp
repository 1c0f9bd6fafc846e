#pragma once

#include <functional>
#include <memory>
#include <string>

#include "gecos/servant.hpp"
#include "gecos/server.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/server/object_audit.hpp"

namespace gecos::session {

/// The settings of one object of a server, constant while it is served.
struct ObjectSetup {
  std::shared_ptr<Runtime> runtime;
  std::string name;
  Servant& servant;
  const InterfaceDescription& interface;
  ObjectOptions options;
  std::shared_ptr<ObjectAudit> audit;  ///< guarded by the object's mutex
  /// Returns whether the user of a client may end the status of others.
  std::function<bool(const media::Peer&)> administers;

  const Clock& clock() const { return runtime->clock(); }
  PauseWatch& pauses() const { return runtime->maintenance().pauses(); }
  /// Returns true when handlers of `operation` may take long and must run on a worker thread.
  bool runs_long(const OperationDescription& operation) const {
    return operation.cancelable || options.blocking;
  }
};

}  // namespace gecos::session
