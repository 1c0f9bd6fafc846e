#pragma once

#include <optional>

#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// If the call reports for a source of a zone (the interface gecos::Zone), such as a door contact,
/// and the user of the client may not report for this source, returns the failure of the call
/// (UserRights::refusal_to_report). Otherwise returns nullopt. So the reports to a zone are always
/// checked, whatever the servant of the zone does.
std::optional<Failure> refusal_to_report(const ObjectSetup& setup, ServerSession& session,
                                         const wire::PacketView& call,
                                         const OperationDescription& operation);

}  // namespace gecos::session
