#include "gecos/session/server/password_check.hpp"

#include <cstdio>
#include <new>
#include <utility>

namespace gecos::session {
namespace {

/// Returns the user whom the kernel or a key proves. If neither proves a user, the client counts as
/// a client of this program's user; what the client claims in its Hello does not count.
std::string proved_user(ServerSession& session) {
  const media::Peer& peer = session.connection().peer();
  const bool proved = peer.uid.has_value() || !peer.user.empty();
  return proved ? session.caller().user : "the user of the server";
}

}  // namespace

std::string PasswordCheck::refusal(ServerSession& session, TimePoint now) const {
  const std::string user = proved_user(session);
  const Duration wait = limit_.wait(user, now);
  if (wait <= Duration::zero()) return {};
  char text[96];
  std::snprintf(text, sizeof text, "%zu wrong passwords within a minute; try again in %.0f s",
                access::PasswordLimit::most_wrong,
                std::chrono::duration<double>(wait).count() + 0.5);
  return user + " has given " + text;
}

void PasswordCheck::count_wrong(ServerSession& session, TimePoint now) {
  limit_.count_wrong(proved_user(session), now);
}

bool PasswordProver::prove(access::Proof password,
                           std::function<void(std::optional<access::Proof>)> then) {
  return executor_.post([this, password = std::move(password), then = std::move(then)] {
    std::optional<access::Proof> proof;
    try {
      proof.emplace(crypto::password_key(password.bytes(), salt_));
    } catch (const std::bad_alloc&) {
    }
    then(std::move(proof));
  });
}

}  // namespace gecos::session
