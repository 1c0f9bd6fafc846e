#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "gecos/base/clock.hpp"

namespace gecos::access {

/// Records what an object knows about the presence of a person in its zone. A report of the zone
/// counts for 1 s; without a report, the person counts as absent. After presence was lost, it
/// counts again only when the time `settling` has passed. By then, every command that was issued
/// before the loss has been refused, so the return of presence resumes no command. A further loss
/// during `settling` begins `settling` again.
///
/// Pure: the caller passes the time, CLOCK_BOOTTIME, which also counts while the machine is
/// suspended. Any thread may call present() and present_since(); for all other functions, the
/// caller must hold the object's mutex.
class ObjectPresence {
 public:
  static constexpr Duration report_life = std::chrono::seconds(1);
  /// The time from a loss of presence to the moment at which presence may count again. It must be
  /// longer than 750 ms, the longest time for which a command may stay unread in the transport.
  static constexpr Duration settling = std::chrono::seconds(1);

  /// `zone`: the name of the object's zone; empty for an object in no zone, which never needs a
  /// person.
  explicit ObjectPresence(std::string zone)
      : zone_(std::move(zone)), until_(zone_.empty() ? TimePoint::max() : TimePoint::min()) {}

  bool required() const { return !zone_.empty(); }
  const std::string& zone() const { return zone_; }

  /// A report of the zone.
  struct Report {
    bool present = false;
    /// The number of the current spell, an uninterrupted time of presence; the number of the last
    /// spell if nobody is present.
    std::uint64_t spell = 0;
    /// A text for people. It says who is present; if nobody is present, it says why, and what to
    /// do.
    std::string why;
  };
  // take(), on_tick(), forget() and enter() return true when presence counted before the call and
  // does not count after it. The caller must then end the commands that need presence.

  /// Takes a report that the zone made at `made`. If `made` is later than `now`, the report counts
  /// as made at `now`.
  bool take(Report report, TimePoint made, TimePoint now);
  /// Must be called periodically, so that the object notices when the zone falls silent.
  bool on_tick(TimePoint now);
  /// Forgets the last report, so that nothing is known of the zone. `why` tells people the reason.
  bool forget(std::string why, TimePoint now);
  /// Moves the object into `zone`. No report of this zone is known yet.
  bool enter(std::string zone, TimePoint now);

  /// Returns whether a person is taken to be present, so that commands that need one may run.
  bool present(TimePoint now) const { return now < until_.load(std::memory_order_acquire); }
  /// Returns whether a sample that was sent at `sent` may have an effect: a person is taken to be
  /// present, and has been ever since `sent`.
  bool present_since(TimePoint sent, TimePoint now) const {
    return present(now) && sent >= since_.load(std::memory_order_relaxed);
  }
  /// Returns a text for people that says who is present, or why presence does not count and what to
  /// do.
  std::string text(TimePoint now) const;

 private:
  enum class Told : std::uint8_t { Nothing, Absent, Present };

  static constexpr const char* unheard =
      "the zone has not reported yet; wait a moment, or start its server";

  bool lose(TimePoint now);

  std::string zone_;
  Told told_ = Told::Nothing;  ///< what the last report said; Nothing if it was forgotten
  TimePoint told_until_{};     ///< the time until which the last report counts
  std::uint64_t spell_ = 0;
  std::string why_ = unheard;
  bool counts_ = false;                             ///< presence counts, unless until_ has passed
  TimePoint not_before_ = TimePoint::min();         ///< before this time, presence does not count
  std::atomic<TimePoint> since_{TimePoint::min()};  ///< the time since which presence counts
  std::atomic<TimePoint> until_;  ///< the time until which presence counts; publishes since_
};

}  // namespace gecos::access
