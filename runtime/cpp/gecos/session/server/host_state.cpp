#include "gecos/session/server/host_state.hpp"

#include <utility>

#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

HostState::HostState(ObjectSetup its_setup)
    : setup(std::move(its_setup)),
      user_callbacks(setup.runtime->maintenance(), setup.name),
      presence(setup.zone),
      calls(setup, ready, *this),
      statuses(setup, claim, calls, *this),
      starts(setup, ready, claim, presence, statuses, calls),
      packets(setup, claim, presence, calls, statuses, user_callbacks),
      passwords(setup.name) {}

void HostState::commands_ended(SessionId client) {
  mutex.assert_held();
  statuses.commands_ended(client);
}

void HostState::finished(ServerCall& call) {
  mutex.assert_held();
  statuses.serve_line();
  ServerSession& session = *call.session;
  if (--session.unreturned != 0 || !session.closed) return;
  user_callbacks.post(
      [&servant = setup.servant, id = number(session.id())] { servant.gecos_session_ended(id); });
}

bool HostState::prove(SessionId session, std::uint64_t counter, access::Proof password) {
  mutex.assert_held();
  return passwords.prove(std::move(password), [this, session, counter](auto proof) {
    const MutexLock lock(mutex);
    statuses.proved(session, counter, std::move(proof));
  });
}

}  // namespace gecos::session
