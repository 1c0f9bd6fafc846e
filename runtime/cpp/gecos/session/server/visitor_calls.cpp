#include "gecos/session/server/visitor_calls.hpp"

#include <algorithm>
#include <string>

#include "gecos/binding.hpp"
#include "gecos/object_calls.hpp"      // generated from idl/gecos/object.gidl
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/object_audit.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

bool opens(const ObjectSetup& setup, FunctionCode code) {
  return setup.options.visitors != nullptr &&
         std::ranges::find(setup.options.visitors->open, code) !=
             setup.options.visitors->open.end();
}

/// Returns whether a visitor may make the call in `packet`. `code`: the code of its operation.
bool may_visit(const ObjectSetup& setup, const wire::PacketView& packet, FunctionCode code) {
  using BuiltIn = GecosObjectInterface;
  if (!is_builtin(code)) return opens(setup, code);
  if (code == BuiltIn::subscribe.code) {
    // The arguments of a call that is sent again follow a SentBefore, so they cannot be decoded
    // here. take_again() removes the SentBefore, and the call is then checked again.
    if (packet.header.flags == sent_again) return true;
    const auto asked = layout::from_bytes<GecosObject_subscribe_arguments>(packet.body);
    return !asked || opens(setup, FunctionCode{asked->code});
  }
  return code == BuiltIn::ping.code || code == BuiltIn::describe.code ||
         code == BuiltIn::model.code || code == BuiltIn::unsubscribe.code;
}

/// Returns the operation of the object, or the built-in operation, that has this code; null if
/// there is none.
const OperationDescription* operation_of(const ObjectSetup& setup, FunctionCode code) {
  return is_builtin(code) ? GecosObjectInterface::description.find(code)
                          : setup.interface.find(code);
}

}  // namespace

std::string refusal_to_visit(const ObjectSetup& setup,
                             const std::vector<std::shared_ptr<ServerSession>>& sessions,
                             const access::UserAtHost& who) {
  const auto open = std::ranges::count_if(sessions, [&](const auto& session) {
    const access::UserAtHost* const other = session->visit.visitor();
    return other != nullptr && *other == who;
  });
  if (static_cast<std::size_t>(open) < most_sessions_of_visitor) return {};
  return setup.name + " opens no session: user " + who.user + " of host " + who.host +
         " is a visitor here and already has " + std::to_string(most_sessions_of_visitor) +
         " sessions, which is the maximum; end a program of this user";
}

bool refuse_visitor(const ObjectSetup& setup, CallStatistics& statistics, ServerSession& session,
                    const wire::PacketView& packet) {
  const access::UserAtHost* const who = session.visit.visitor();
  const FunctionCode code = packet.header.code;
  if (who == nullptr || may_visit(setup, packet, code)) return false;
  const std::uint64_t counter = packet.header.counter;
  const OperationDescription* const operation = operation_of(setup, code);
  const std::string name(operation == nullptr ? "unknown operation" : operation->name);
  const std::string because =
      "user " + who->user + " of host " + who->host +
      " is a visitor here and may only look for the objects whose "
      "programs admit this user; name the user in [objects." +
      setup.name + ".allow] of the lab file, together with all other users of " + setup.name;
  Failure refused{
      Detail::Denied, "'" + name + "' of " + setup.name + " was not started: " + because, {}, {}};
  refused.text += setup.audit->visitor_refused(session, counter, name, refused, because);
  statistics.refused(session, is_builtin(code) ? nullptr : operation, refused.detail);
  session.reply(counter, refused);
  return true;
}

}  // namespace gecos::session
