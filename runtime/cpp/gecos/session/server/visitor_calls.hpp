#pragma once

#include "gecos/session/server/call_statistics.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Replies to the call in `packet`, counts it and returns true if its client is a visitor, who may
/// not use this operation. Of the operations that each object has, a visitor may use those that tell what
/// the object is; of the others, those that the object opens to visitors (session::Visitors).
/// Requires the object's mutex.
bool refuse_visitor(const ObjectSetup& setup, CallStatistics& statistics, ServerSession& session,
                    const wire::PacketView& packet);

}  // namespace gecos::session
