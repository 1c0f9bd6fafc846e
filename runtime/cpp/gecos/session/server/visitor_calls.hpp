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

/// The most sessions that one user of one host may have with an object as a visitor, at a time.
inline constexpr std::size_t most_sessions_of_visitor = 8;

/// Returns why no session is opened for the visitor `who`; an empty text if one may be opened.
/// `sessions`: those that are open with the object.
std::string refusal_to_visit(const ObjectSetup& setup,
                             const std::vector<std::shared_ptr<ServerSession>>& sessions,
                             const access::UserAtHost& who);

/// Replies to the call in `packet`, counts it and returns true if its client is a visitor, who may
/// not use this operation. Of the operations that each object has, a visitor may use those that
/// tell what the object is; of the others, those that the object opens to visitors
/// (session::Visitors). Requires the object's mutex.
bool refuse_visitor(const ObjectSetup& setup, CallStatistics& statistics, ServerSession& session,
                    const wire::PacketView& packet);

}  // namespace gecos::session
