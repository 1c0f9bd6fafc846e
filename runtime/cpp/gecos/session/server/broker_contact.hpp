#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/access/access_policy.hpp"
#include "gecos/access/revocations.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/object.hpp"

namespace gecos::session {

class ClientConnection;

/// Whom the laboratory has revoked, as the broker tells a server once a second, and whether the
/// server knows this list as it is now. A server that had no answer for `known_for` may have missed
/// a revocation: it is out of contact.
///
/// A server that has no broker, as that of the broker itself, is never out of contact. Thread-safe.
class BrokerContact {
 public:
  /// The time for which an answer counts. Shorter than the 5 s within which a revocation acts.
  static constexpr Duration known_for = std::chrono::seconds(3);

  explicit BrokerContact(const Clock& clock) : clock_(clock) {}

  /// Asks `broker`, unless an answer still counts, and waits for the answer until `deadline`. Must
  /// be called before objects are registered with `broker`.
  void renew(ClientConnection& broker, TimePoint deadline);
  /// Asks `broker` once a second; null if there is none at the moment. Never waits.
  void on_tick(const std::shared_ptr<ClientConnection>& broker);

  /// Returns whether the laboratory has revoked a client; see access::revokes.
  bool revokes(std::string_view key, const access::UserAtHost& who) const;
  /// Returns since when the server has been out of contact, in words; an empty text if it is not.
  std::string out_of_contact() const;

  /// Takes an answer to a question that was asked at `asked`, by Clock::since_boot. `list`: the new
  /// list; no value if the broker has the one that this server knows.
  void take(TimePoint asked, std::uint64_t number,
            std::optional<std::vector<access::RevokedUser>> list);
  /// From now on the server needs the answers of a broker.
  void need();

 private:
  struct Question {
    TimePoint asked;
    std::shared_ptr<CommandCore> command;
  };
  Question ask(ClientConnection& broker);
  void take(const Question& question);

  const Clock& clock_;
  mutable Mutex mutex_;
  bool needed_ GECOS_GUARDED_BY(mutex_) = false;
  /// When the last question that was answered was asked; no value before the first answer.
  std::optional<TimePoint> known_at_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t number_ GECOS_GUARDED_BY(mutex_) = 0;
  std::vector<access::RevokedUser> list_ GECOS_GUARDED_BY(mutex_);
  // Used by the maintenance thread only.
  std::optional<Question> open_;
  TimePoint next_{};
};

}  // namespace gecos::session
