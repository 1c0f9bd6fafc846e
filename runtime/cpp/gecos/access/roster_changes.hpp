#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/access/lease_table.hpp"
#include "gecos/base/clock.hpp"

namespace gecos::access {

/// One change of the holders of an object.
struct RosterChange {
  enum class Kind : std::uint8_t {
    /// A client has acquired a status, or a higher status than before. A client that acquires the
    /// status again while its release is pending counts, too.
    Acquired,
    Releasing,  ///< the status was released, but the last commands under it still run
    TakenOver,
    GivenBack,
    Ended,
  };
  std::uint64_t number = 0;  ///< one more than the number of the previous change
  Kind kind = Kind::Acquired;
  Holder holder;  ///< as it was after the change; if the status ended, as it was before
  TimePoint at{};
  std::string why{};  ///< why the status ended; empty for other kinds
};

/// Numbers the changes of the holders of one object, and keeps the newest changes. A client that
/// asks for the changes after the newest change that it knows gets each change once.
///
/// The caller passes the current time. Reads no clock and does no I/O.
class RosterChanges {
 public:
  /// The maximum number of changes that are kept.
  static constexpr std::size_t kept = 256;

  /// The first change has the number `start + 1`. Two servers of one object must use different
  /// numbers: after a restart, a client may ask the new server for the changes after a number of
  /// the old server. @pre `start` is not 0
  explicit RosterChanges(std::uint64_t start) : start_(start) {}

  /// Must be called after each change of a LeaseTable, with the table's holders. `why_ended` is the
  /// reason for each status that ended by this change.
  void note(std::vector<Holder> roster, TimePoint now, std::string_view why_ended);

  /// Returns the number of the newest change; `start` before the first change.
  std::uint64_t newest() const { return start_ + count_; }
  /// Returns the kept changes with larger numbers than `number`, the oldest first. Returns all kept
  /// changes when this object has never used `number`, for example when `number` is 0 or comes from
  /// another server.
  std::vector<RosterChange> after(std::uint64_t number) const;

 private:
  void add(RosterChange::Kind kind, const Holder& holder, TimePoint now,
           std::string_view why_ended = {});

  const std::uint64_t start_;
  std::uint64_t count_ = 0;
  std::vector<Holder> roster_;  ///< the holders at the last call of note()
  std::deque<RosterChange> changes_;
};

}  // namespace gecos::access
