#include "gecos/session/server/presence_reports.hpp"

#include <string>

#include "gecos/presence_calls.hpp"      // generated from idl/gecos/presence.gidl
#include "gecos/presence_interface.hpp"  // generated from idl/gecos/presence.gidl
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

/// Returns the source for which the call reports; nullopt for a call of another operation. If the
/// arguments of the call do not decode, returns the source ""; the servant refuses the call later.
std::optional<std::string> reported_source(FunctionCode code, ByteView arguments) {
  if (code == ZoneInterface::report_door.code) {
    const auto report = layout::from_bytes<Zone_report_door_arguments>(arguments);
    return report ? report->door : std::string();
  }
  if (code == ZoneInterface::report_button.code) {
    const auto report = layout::from_bytes<Zone_report_button_arguments>(arguments);
    return report ? report->button : std::string();
  }
  return std::nullopt;
}

}  // namespace

std::optional<Failure> refusal_to_report(const ObjectSetup& setup, ServerSession& session,
                                         const wire::PacketView& call,
                                         const OperationDescription& operation) {
  const auto source = reported_source(operation.code, call.body);
  if (!source || !setup.interface.is_a(ZoneInterface::description.name)) return std::nullopt;
  const std::string why =
      setup.rights.refusal_to_report(setup.name, *source, session.connection().peer());
  if (why.empty()) return std::nullopt;
  return Failure{Detail::Denied, why + named_request(session.id(), call.header.counter), {}, {}};
}

}  // namespace gecos::session
