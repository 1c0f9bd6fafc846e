#pragma once

#include <atomic>

#include "gecos/access/object_presence.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_calls.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/session_packets.hpp"
#include "gecos/session/server/start_gate.hpp"
#include "gecos/session/server/status_grants.hpp"
#include "gecos/session/server/user_callbacks.hpp"

namespace gecos::session {

/// The parts of one object of a server, and the mutex that guards these parts. ObjectHost,
/// CallRunner, HandlerWaits and NameConfirmation are called from several threads and lock the
/// mutex. The parts themselves do not lock the mutex.
struct HostState final : private ObjectCalls::Observer, private StatusGrants::Prover {
  explicit HostState(ObjectSetup its_setup);

  const ObjectSetup setup;
  UserCallbacks user_callbacks;
  /// A hint that a call may be able to start: true when a call was queued or ended since the last
  /// check.
  std::atomic<bool> ready{false};

  FutexMutex mutex;
  NameClaim claim GECOS_GUARDED_BY(mutex);
  access::ObjectPresence presence GECOS_GUARDED_BY(mutex);
  ObjectCalls calls GECOS_GUARDED_BY(mutex);
  StatusGrants statuses GECOS_GUARDED_BY(mutex);
  StartGate starts GECOS_GUARDED_BY(mutex);
  SessionPackets packets GECOS_GUARDED_BY(mutex);
  PasswordProver passwords;  ///< last member, so that its thread ends first

 private:
  void commands_ended(SessionId client) override;
  void finished(ServerCall& call) override;
  bool prove(SessionId session, std::uint64_t counter, access::Proof password) override;
};

}  // namespace gecos::session
