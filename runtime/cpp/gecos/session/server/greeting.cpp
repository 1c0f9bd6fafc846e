#include "gecos/session/server/greeting.hpp"

#include <sys/random.h>

#include <utility>

#include "gecos/base/user_and_host.hpp"
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/session/server/handler_waits.hpp"
#include "gecos/session/server/visitor_calls.hpp"

namespace gecos::session {
namespace {

SessionId new_session_id() {
  std::uint64_t id = 0;
  while (id == 0) {
    if (getrandom(&id, sizeof id, 0) != sizeof id) id = 0;
  }
  return SessionId{id};
}

void open(const std::shared_ptr<ServerSession>& session, const Hello& hello,
          const ObjectSetup& setup, OutcomeLog& outcomes, TimePoint now,
          std::optional<access::UserAtHost> visitor) {
  const media::Peer& peer = session->connection().peer();
  const SessionId id = new_session_id();
  Caller caller;
  // If neither the kernel nor a key proves a user, host or process id of the client, the claim in
  // the Hello is used.
  caller.user = peer.uid ? user_name(*peer.uid) : peer.user.empty() ? hello.user : peer.user;
  caller.host = peer.host.empty() ? hello.host : peer.host;
  caller.program = hello.program;
  caller.pid = peer.pid.value_or(hello.pid);
  caller.incarnation = hello.incarnation;
  caller.session = number(id);
  session->visit.open(std::move(visitor));
  session->greet(id, std::move(caller));
  session->intake.accept_within(hello.accept_within);
  session->heartbeats.liveness.heard(now);
  session->greeted_at = setup.clock().now();
  outcomes.opened(id, session);
  note_session(id, session->object());
  if (log_enabled(LogLevel::Info)) log_arrival(setup.name, *session);
  setup.audit->connected(*session);
}

/// Makes the reply to a Hello. `operations`: whether the reply includes the hashes of all
/// operations.
Welcome welcome_to(const ObjectSetup& setup, bool operations) {
  const InterfaceDescription& interface = setup.interface;
  Welcome welcome{setup.name,
                  std::string(interface.name),
                  {},
                  interface.hash,
                  number(process_incarnation()),
                  static_cast<std::uint32_t>(ObjectQueue::most_of_object),
                  {}};
  welcome.bases.assign(interface.bases.begin(), interface.bases.end());
  if (!operations) return welcome;
  for (const OperationDescription* operation : interface.all_operations()) {
    welcome.operations.push_back({operation->code, operation->hash});
  }
  for (const StreamDescription* stream : interface.all_streams()) {
    if (stream->event) welcome.operations.push_back({stream->code, stream->hash});
  }
  for (const InwardDescription* stream : interface.all_inward_streams()) {
    welcome.operations.push_back({stream->code, stream->hash});
  }
  return welcome;
}

void refuse(ServerSession& session, const std::string& why) {
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Refused;
  header.flags = static_cast<std::int8_t>(Detail::Refused);
  const FailureBody body{why, {}, {}};
  session.send(header, wire::to_bytes(body));
}

}  // namespace

void greet(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet,
           const ObjectSetup& setup, OutcomeLog& outcomes, GreetedAt at) {
  if (packet.header.version != wire::packet_version) {
    return refuse(*session, "this server speaks version " + std::to_string(wire::packet_version) +
                                " of the session protocol and the client speaks version " +
                                std::to_string(packet.header.version) +
                                "; update the older program");
  }
  const auto hello = wire::from_bytes<Hello>(packet.body);
  if (!hello) {
    return refuse(*session, "the greeting does not decode: " + hello.error().message());
  }
  if (at.closing) return refuse(*session, "the server is about to end");
  const bool any_object = hello->interface_name == GecosObjectInterface::description.name;
  if (!any_object && !setup.interface.is_a(hello->interface_name)) {
    return refuse(*session, setup.name + " is a " + std::string(setup.interface.name) + ", not a " +
                                hello->interface_name);
  }
  if (!session->greeted()) {
    auto visitor = setup.rights.visitor(setup.name, session->connection().peer());
    const auto why = visitor ? refusal_to_visit(setup, outcomes.all_open(), *visitor) : "";
    if (!why.empty()) return refuse(*session, why);
    open(session, *hello, setup, outcomes, at.now, std::move(visitor));
  }
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Welcome;
  session->send(header,
                wire::to_bytes(welcome_to(setup, hello->interface_hash != setup.interface.hash)));
}

}  // namespace gecos::session
