#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "gecos/session/server/inward_port.hpp"
#include "gecos/session/server/object_setup.hpp"

namespace gecos::session {

class ServerSession;

/// The inward streams of one object, each with its own InwardPort. Thread-safe.
class ObjectInward {
 public:
  /// The ports read from these arguments whether a pause of this process still has to be
  /// judged, whether the broker confirms the name of the object, and whether a person is present.
  ObjectInward(const ObjectSetup& setup, const NameClaim& claim,
               const access::ObjectPresence& presence);

  /// Returns the port of the stream with this code; null when the interface has no such stream.
  InwardPort* find(FunctionCode code) const;
  /// Makes `port` read the stream that `session` shares under `id`. Returns false if the
  /// announcement of the stream has not arrived yet. On failure returns the reason.
  tl::expected<bool, std::string> feed(InwardPort& port,
                                       const std::shared_ptr<ServerSession>& session,
                                       std::uint32_t id) const;
  /// Must be called when the session has ended.
  void depart(SessionId session) const;
  /// Returns the counts of the samples of all sessions, for each stream.
  std::vector<InwardStats> stats() const;

 private:
  std::vector<std::unique_ptr<InwardPort>> ports_;  ///< sorted by stream code; constant
};

}  // namespace gecos::session
