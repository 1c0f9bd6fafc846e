#pragma once

#include <memory>
#include <optional>

#include "gecos/base/clock.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker/revoked_list.hpp"
#include "gecos/broker_types.hpp"

namespace gecos::broker {

/// The lists that name the visitors of the broker, and the list of the users whom the broker's user
/// has revoked. The other servers get the list of the revoked users from the broker; the broker
/// itself reads this list from the file, once a second while an object may have visitors.
class VisitorLists {
 public:
  static constexpr Duration between_readings = std::chrono::seconds(1);
  /// The list of the revoked users counts for this time after it was read. After that time, no new
  /// visitor is admitted.
  static constexpr Duration known_for = std::chrono::seconds(3);

  VisitorLists();

  /// Begins to read the list of the revoked users. Throws std::system_error when the process has no
  /// thread or descriptor left.
  void start() {
    if (!revoked_) revoked_.emplace();
  }
  /// @pre `start` was called
  RevokedList& revoked() { return *revoked_; }
  /// Reads the list of the revoked users when the time for this has come; waits at most 250 ms for
  /// the file. Must always be called on the same thread. Returns the time of the next call.
  TimePoint refresh_revoked(TimePoint now);

  const std::shared_ptr<session::Visitors>& visitors() const { return visitors_; }
  /// Reads the list of the revoked users if `admitted` is the first list that names somebody,
  /// because no visitor may be admitted before the broker knows the revoked users. Must be called
  /// before `set`, and without a lock, because the call may wait 250 ms for the file.
  void ensure_revoked_known(const std::optional<AdmittedNames>& admitted);
  /// Sets the list of the users and hosts that the program of the server of `what` admits. `user`:
  /// the user who registers `what`; no value for the user of the broker. `revision`: the number of
  /// the broker's last change. Returns whether the lists have changed.
  bool set(const Entry& what, const std::optional<session::ProvedUser>& user,
           const std::optional<AdmittedNames>& admitted, std::uint64_t revision);

 private:
  std::shared_ptr<session::Visitors> visitors_;
  std::optional<RevokedList> revoked_;
  // Only the thread that calls `refresh_revoked` uses these members.
  TimePoint next_{};
  std::optional<TimePoint> read_at_;
  bool reported_ = false;  ///< a warning that the file cannot be read was logged
};

}  // namespace gecos::broker
