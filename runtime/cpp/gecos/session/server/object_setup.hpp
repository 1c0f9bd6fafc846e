#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "gecos/access/access_policy.hpp"
#include "gecos/servant.hpp"
#include "gecos/server.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/server/object_audit.hpp"

namespace gecos::session {

/// The rights of users that do not depend on a status. The server decides these rights for all its
/// objects.
struct UserRights {
  /// True if every user of every host may connect (Admission::Insecure).
  bool everybody_connects = false;
  /// Returns whether the user may end the status of other clients.
  std::function<bool(const media::Peer&)> administers = [](const auto&) { return false; };
  /// Returns the user and the host of the client. Returns no value if the client is a program of
  /// the server's user or of root.
  std::function<std::optional<access::UserAtHost>(const media::Peer&)> other_user =
      [](const auto&) { return std::nullopt; };
  /// Returns the user of a client that may connect to the object as a visitor only
  /// (access/visitors.hpp); no value if the client is no visitor.
  std::function<std::optional<access::UserAtHost>(const std::string& object, const media::Peer&)>
      visitor = [](const auto&, const auto&) { return std::nullopt; };
  /// Returns why the user may not register an object under `name`; an empty text when the user may.
  std::function<std::string(const std::string& name, const media::Peer&)> refusal_to_register =
      [](const auto&, const auto&) { return std::string(); };
  /// Returns why the user may not report for `source`, for example a door contact of `zone`, that a
  /// person is present. Returns an empty text when the user may.
  std::function<std::string(const std::string& zone, const std::string& source, const media::Peer&)>
      refusal_to_report = [](const auto& zone, const auto& source, const auto&) {
        return "nothing says who may report for " + source + " of " + zone;
      };
};

/// The settings of one object of a server. They do not change while the object is served.
struct ObjectSetup {
  std::shared_ptr<Runtime> runtime;
  std::string name;
  Servant& servant;
  const InterfaceDescription& interface;
  ObjectOptions options;
  std::shared_ptr<ObjectAudit> audit;  ///< guarded by the object's mutex
  UserRights rights;
  std::string zone;  ///< the zone of the object; empty if the object is in no zone

  const Clock& clock() const { return runtime->clock(); }
  PauseWatch& pauses() const { return runtime->maintenance().pauses(); }
  /// Returns true when handlers of `operation` may take long and must run on a worker thread.
  bool runs_long(const OperationDescription& operation) const {
    return operation.cancelable || options.blocking;
  }
};

}  // namespace gecos::session
