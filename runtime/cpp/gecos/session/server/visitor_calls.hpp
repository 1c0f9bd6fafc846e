#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "gecos/session/server/call_statistics.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Maximum number of sessions that one visitor (a user of a host) may have with an object at the
/// same time.
inline constexpr std::size_t most_sessions_of_visitor = 8;

/// Returns why no session is opened for the visitor `who`; an empty text if a session may be
/// opened. `sessions`: the open sessions with the object.
std::string refusal_to_visit(const ObjectSetup& setup,
                             const std::vector<std::shared_ptr<ServerSession>>& sessions,
                             const access::UserAtHost& who);

/// If the client is a visitor and may not use the operation, refuses the call in `packet`, counts
/// the refusal and returns true. Otherwise returns false. A visitor may use the built-in operations
/// that tell what the object is, and the operations that the object opens to visitors
/// (session::Visitors). Requires the object's mutex.
bool refuse_visitor(const ObjectSetup& setup, CallStatistics& statistics, ServerSession& session,
                    const wire::PacketView& packet);

}  // namespace gecos::session
