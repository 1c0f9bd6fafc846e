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

/// Keeps the list of the users whom the laboratory has revoked. The server asks the broker for this
/// list once a second. If the broker has not answered for the time `known_for`, the server may have
/// missed a revocation: the server is then out of contact.
///
/// A server without a broker, such as the server of the broker itself, is never out of contact.
/// Thread-safe.
class BrokerContact {
 public:
  /// The time for which an answer of the broker counts. This time is shorter than the 5 s within
  /// which a revocation must take effect.
  static constexpr Duration known_for = std::chrono::seconds(3);

  explicit BrokerContact(const Clock& clock) : clock_(clock) {}

  /// Asks `broker` which users are revoked, and waits for the answer until `deadline`. Does nothing
  /// while an earlier answer still counts. Must be called before objects are registered with
  /// `broker`.
  void renew(ClientConnection& broker, TimePoint deadline);
  /// Asks `broker` once a second which users are revoked. `broker`: null while no broker is known.
  /// Never waits.
  void on_tick(const std::shared_ptr<ClientConnection>& broker);

  /// Returns whether the laboratory has revoked a client; see access::revokes.
  bool revokes(std::string_view key, const access::UserAtHost& who) const;
  /// Returns a text that says since when the server has been out of contact; an empty text if the
  /// server is in contact.
  std::string out_of_contact() const;

  /// Takes the broker's answer to a question that was asked at `asked`, a time of
  /// Clock::since_boot. `list`: the new list; no value if the list that this server knows is still
  /// the list of the broker.
  void take(TimePoint asked, std::uint64_t number,
            std::optional<std::vector<access::RevokedUser>> list);
  /// From now on, the server is out of contact when no broker answers.
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
  /// The time at which the newest answered question was asked; no value before the first answer.
  std::optional<TimePoint> known_at_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t number_ GECOS_GUARDED_BY(mutex_) = 0;
  std::vector<access::RevokedUser> list_ GECOS_GUARDED_BY(mutex_);
  // Only the maintenance thread uses the following members.
  std::optional<Question> open_;
  TimePoint next_{};
};

}  // namespace gecos::session
