#pragma once

#include <memory>
#include <string>

#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/outcome_log.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Replies to the Hello in `packet`: opens `session` with the object, or refuses it with the
/// reason. `now`: the current time of the clock by which the silence of the client is measured.
void greet(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet,
           const ObjectSetup& setup, OutcomeLog& outcomes, TimePoint now);
void refuse_greeting(ServerSession& session, const std::string& why);

}  // namespace gecos::session
