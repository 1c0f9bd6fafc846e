#pragma once

#include <memory>
#include <string>

#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/outcome_log.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// The state of the server when a Hello arrives.
struct GreetedAt {
  TimePoint now{};       ///< the current time by the clock that measures the silence of clients
  bool closing = false;  ///< the server is about to end
};

/// Replies to the Hello in `packet`: either opens `session` with the object, or refuses the client
/// with a reason.
void greet(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet,
           const ObjectSetup& setup, OutcomeLog& outcomes, GreetedAt at);

}  // namespace gecos::session
