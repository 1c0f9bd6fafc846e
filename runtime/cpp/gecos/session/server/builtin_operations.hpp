#pragma once

#include <cstdint>
#include <memory>

#include "gecos/session/server/inward_port.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_calls.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/session/server/status_grants.hpp"
#include "gecos/session/server/user_callbacks.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Serves the built-in operations of one object (gecos::GecosObject). Every object has these
/// operations in addition to those of its interface. Not thread-safe: the object's mutex guards it.
class BuiltinOperations {
 public:
  BuiltinOperations(const ObjectSetup& setup, const NameClaim& claim,
                    const access::ObjectPresence& presence, ObjectCalls& calls,
                    StatusGrants& statuses, UserCallbacks& user_callbacks)
      : setup_(setup),
        claim_(claim),
        presence_(presence),
        calls_(calls),
        statuses_(statuses),
        user_callbacks_(user_callbacks) {}

  /// Carries out the call in `packet` and replies to it. Must not be called for
  /// GecosObject::outcome: SessionPackets serves that operation, because it changes which calls the
  /// sessions accept.
  void answer(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet);

 private:
  void holders(ServerSession& session, std::uint64_t counter);
  void describe(ServerSession& session, std::uint64_t counter);
  void model(ServerSession& session, std::uint64_t counter);
  void stats(ServerSession& session, std::uint64_t counter);
  void roster(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
              ByteView arguments);
  void acquire(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
               ByteView arguments);
  void release(ServerSession& session, std::uint64_t counter, ByteView arguments);
  void take_over(ServerSession& session, std::uint64_t counter);
  void give_back(ServerSession& session, std::uint64_t counter);
  /// Refuses a call of the operation `asked`, which the client may not use, and records the refusal
  /// in the audit. `why`: the reason.
  void refuse(ServerSession& session, std::uint64_t counter, const OperationDescription& asked,
              const std::string& why);
  void requests(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                ByteView arguments);
  void deny(ServerSession& session, std::uint64_t counter, ByteView arguments);
  void break_status(ServerSession& by, std::uint64_t counter, ByteView arguments);
  void subscribe(ServerSession& session, std::uint64_t counter, ByteView arguments);
  void unsubscribe(ServerSession& session, std::uint64_t counter, ByteView arguments);
  void stop(ServerSession& by, std::uint64_t counter);
  void feed(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
            ByteView arguments);
  void end_feed(ServerSession& session, std::uint64_t counter, ByteView arguments);
  void feed_report(ServerSession& session, std::uint64_t counter, ByteView arguments);
  /// Returns the port of the inward stream with this code. If the object has no such stream,
  /// replies to the call with a failure and returns null.
  InwardPort* inward_port(ServerSession& session, std::uint64_t counter, FunctionCode code);

  const ObjectSetup& setup_;
  const NameClaim& claim_;
  const access::ObjectPresence& presence_;
  ObjectCalls& calls_;
  StatusGrants& statuses_;
  UserCallbacks& user_callbacks_;
};

}  // namespace gecos::session
