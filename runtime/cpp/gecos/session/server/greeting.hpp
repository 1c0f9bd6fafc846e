#pragma once

#include <memory>
#include <string>

#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/outcome_log.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// When a Hello arrives.
struct GreetedAt {
  TimePoint now{};       ///< by the clock that measures the silence of the client
  bool closing = false;  ///< the server is about to end
};

/// Replies to the Hello in `packet`: opens `session` with the object, or refuses it with the
/// reason.
void greet(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet,
           const ObjectSetup& setup, OutcomeLog& outcomes, GreetedAt at);

}  // namespace gecos::session
