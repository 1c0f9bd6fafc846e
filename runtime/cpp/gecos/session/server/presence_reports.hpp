#pragma once

#include <optional>

#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Returns why a call must not be queued that reports for a door or a button of a zone (the
/// interface gecos::Zone): the user of the client may not report for this source
/// (UserRights::refusal_to_report). Returns nullopt for all other calls. So every server of a zone
/// checks its reports, whatever its servant does.
std::optional<Failure> refusal_to_report(const ObjectSetup& setup, ServerSession& session,
                                         const wire::PacketView& call,
                                         const OperationDescription& operation);

}  // namespace gecos::session
