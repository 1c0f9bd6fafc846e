#pragma once

#include <optional>
#include <string>

#include "gecos/access/password_limit.hpp"
#include "gecos/access/proof.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/crypto/password.hpp"
#include "gecos/session/server/executor.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/session/server/status_line.hpp"

namespace gecos::session {

/// Decides whether the password of a client may be compared now, and counts the wrong passwords of
/// each user. Not thread-safe: the object's mutex guards it.
class PasswordCheck {
 public:
  /// Returns why the password of the client of `session` must not be compared now; an empty text
  /// when it may be compared.
  std::string refusal(ServerSession& session, TimePoint now) const;
  void count_wrong(ServerSession& session, TimePoint now);

 private:
  access::PasswordLimit limit_;
};

/// Derives proofs from passwords, one after the other, on a thread of its own. Thread-safe.
class PasswordProver {
 public:
  explicit PasswordProver(const std::string& object) : executor_("gecos-" + object, 1) {}

  /// Derives the proof of `password` and calls `then` with it, on the thread of the prover. Calls
  /// `then` with nullopt when there is not enough memory to derive the proof. Returns false when
  /// this process cannot create the thread.
  bool prove(access::Proof password, std::function<void(std::optional<access::Proof>)> then);
  /// Waits until the proofs of all earlier calls of `prove` have been derived. Later calls of
  /// `prove` fail.
  void join() { executor_.join(); }

 private:
  const crypto::Salt salt_ = crypto::draw_salt();
  Executor executor_;  ///< last member, so that its thread ends first
};

}  // namespace gecos::session
