#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/server/builtin_operations.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_calls.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/session/server/status_grants.hpp"
#include "gecos/session/server/user_callbacks.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Processes the packets that clients send to one object: opens sessions, admits calls to the
/// queue in the order in which they were issued, and cancels and withdraws them. Starts no call.
/// Not thread-safe: the object's mutex guards it.
class SessionPackets {
 public:
  SessionPackets(const ObjectSetup& setup, const NameClaim& claim,
                 const access::ObjectPresence& presence, ObjectCalls& calls, StatusGrants& statuses,
                 UserCallbacks& user_callbacks)
      : setup_(setup),
        claim_(claim),
        presence_(presence),
        calls_(calls),
        statuses_(statuses),
        builtin_(setup, claim, presence, calls, statuses, user_callbacks) {}

  void take(const std::shared_ptr<ServerSession>& session, ByteView bytes);
  /// Ends the deferred calls of `session`. Must be called when its connection has ended.
  void depart(ServerSession& session);
  /// Refuses new sessions and calls from now on.
  void close() { closed_ = true; }
  bool closed() const { return closed_; }

 private:
  using Session = std::shared_ptr<ServerSession>;
  void acknowledge(const Session& session, std::uint64_t counter);
  void say_goodbye(ServerSession& session, SessionId to, const std::string& why);
  bool unheard_since_a_pause(const ServerSession& session) const;
  void withdraw(ServerSession& session);
  void cancel(ServerSession& session, std::uint64_t counter, std::uint64_t last);
  void cancel_running(ServerSession& session, ServerCall& call);
  void answer_again(ServerSession& session, std::uint64_t counter);

  // The functions below take a call from its arrival to the queue. `age`: the time since the client
  // sent the call.
  void arrive(const Session& session, const wire::PacketView& packet);
  void refuse_late(ServerSession& session, const wire::PacketView& packet);
  void take_call(const Session& session, const wire::PacketView& packet, Duration age);
  void take_in_turn(const Session& session, const wire::PacketView& packet,
                    const OperationDescription& operation, Duration age);
  void admit(const Session& session, const wire::PacketView& packet,
             const OperationDescription& operation, Duration age);
  std::optional<Failure> refusal(ServerSession& session, const wire::PacketView& packet,
                                 const OperationDescription& operation);

  // The functions below handle calls that arrive before calls that were issued earlier.
  bool too_early(ServerSession& session, const wire::PacketView& packet,
                 const OperationDescription& operation, Duration age);
  void take_early(const Session& session);
  void end_early(ServerSession& session, std::uint64_t counter, Detail how, const std::string& why);
  void cancel_later(ServerSession& session, std::uint64_t counter, std::uint64_t last);

  // The functions below handle calls that were first sent in a session that the client has lost.
  void take_again(const Session& session, const wire::PacketView& packet, Duration age);
  void resume(const Session& session, const wire::PacketView& packet,
              std::shared_ptr<ServerCall> call);
  void reject_late(const Session& before, std::uint64_t counter);
  void answer_outcome(ServerSession& session, const wire::PacketView& packet);
  OutcomeRecord outcome_of(SessionId asked, std::uint64_t counter);

  const ObjectSetup& setup_;
  const NameClaim& claim_;
  const access::ObjectPresence& presence_;
  ObjectCalls& calls_;
  StatusGrants& statuses_;
  BuiltinOperations builtin_;
  bool closed_ = false;
};

}  // namespace gecos::session
