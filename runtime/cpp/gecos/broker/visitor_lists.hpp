#pragma once

#include <memory>
#include <optional>

#include "gecos/base/clock.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker/revoked_list.hpp"
#include "gecos/broker_types.hpp"

namespace gecos::broker {

/// The lists that name the visitors of the broker, and the list of those whom its user has revoked.
/// The broker has no broker that could tell it about revocations. Therefore it reads the list of
/// the revoked from the file, once a second while an object may have visitors.
class VisitorLists {
 public:
  static constexpr Duration between_readings = std::chrono::seconds(1);
  /// The list counts for so long after it was read. Then no new visitor is admitted.
  static constexpr Duration known_for = std::chrono::seconds(3);

  VisitorLists();

  /// Begins to read the list of the revoked. Throws std::system_error when the process has no
  /// thread or descriptor left.
  void start() {
    if (!revoked_) revoked_.emplace();
  }
  /// @pre `start` was called
  RevokedList& revoked() { return *revoked_; }
  /// Reads the list of the revoked, if it is time; waits at most 250 ms for the file. Must be
  /// called on one thread. Returns when to call this again.
  TimePoint refresh_revoked(TimePoint now);

  const std::shared_ptr<session::Visitors>& visitors() const { return visitors_; }
  /// Reads the list of the revoked if `admitted` is the first list that names somebody: no visitor
  /// is admitted before the broker knows the revoked users. Must be called before `set`, without a
  /// lock, because the call may wait 250 ms for the file.
  void ensure_revoked_known(const std::optional<AdmittedNames>& admitted);
  /// Notes whom the program of the server of `what` admits. `user`: who registers `what`; no value
  /// for the user of the broker. `revision`: the number of the broker's last change. Returns
  /// whether the lists have changed.
  bool set(const Entry& what, const std::optional<session::ProvedUser>& user,
           const std::optional<AdmittedNames>& admitted, std::uint64_t revision);

 private:
  std::shared_ptr<session::Visitors> visitors_;
  std::optional<RevokedList> revoked_;
  // Used by the thread of `refresh_revoked` only.
  TimePoint next_{};
  std::optional<TimePoint> read_at_;
  bool reported_ = false;  ///< that the file cannot be read
};

}  // namespace gecos::broker
