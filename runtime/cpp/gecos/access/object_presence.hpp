#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "gecos/base/clock.hpp"

namespace gecos::access {

/// Records what an object knows about the presence of a person in its zone. What is not known
/// counts as absent: a report of the zone counts for 1 s. After presence was lost it counts again
/// only after `settling`: then every command that was issued before the loss has been refused, so
/// the return of presence resumes nothing. The zone may lose it again meanwhile; then `settling`
/// begins anew.
///
/// Pure: the caller passes the time, CLOCK_BOOTTIME, which also counts while the machine is
/// suspended. Any thread may call present() and present_since(); the object's mutex guards the
/// rest.
class ObjectPresence {
 public:
  static constexpr Duration report_life = std::chrono::seconds(1);
  /// Longer than a command may stay unread in the transport, 750 ms.
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
    std::uint64_t spell = 0;  ///< number of the present time of presence, or of the last one
    std::string why;          ///< a text for people
  };
  // These functions return true when presence that counted was lost: then the commands that need it
  // must end.
  /// Takes a report that was made at `made`. A moment in the future stands for `now`.
  bool take(Report report, TimePoint made, TimePoint now);
  /// Must be called now and then, so that the loss by silence is noticed.
  bool on_tick(TimePoint now);
  /// Forgets the last report, because nothing is known any more. `why`: a text for people.
  bool forget(std::string why, TimePoint now);
  /// The object is in `zone` from now on, of which nothing is known yet.
  bool enter(std::string zone, TimePoint now);

  /// Returns whether a command that needs a person may start, and a running one may go on.
  bool present(TimePoint now) const { return now < until_.load(std::memory_order_acquire); }
  /// Returns whether a sample that was sent at `sent` may have an effect: presence counts now, and
  /// has counted since.
  bool present_since(TimePoint sent, TimePoint now) const {
    return present(now) && sent >= since_.load(std::memory_order_relaxed);
  }
  /// Returns why presence does not count, and what to do; or who is present.
  std::string text(TimePoint now) const;

 private:
  enum class Told : std::uint8_t { Nothing, Absent, Present };

  static constexpr const char* unheard =
      "the zone has not reported yet; wait a moment, or start its server";

  bool lose(TimePoint now);

  std::string zone_;
  Told told_ = Told::Nothing;  ///< by the last report, unless it was forgotten
  TimePoint told_until_{};     ///< until when the last report is believed
  std::uint64_t spell_ = 0;
  std::string why_ = unheard;
  bool counts_ = false;                             ///< presence counts, unless until_ has passed
  TimePoint not_before_ = TimePoint::min();         ///< presence does not count before
  std::atomic<TimePoint> since_{TimePoint::min()};  ///< since when presence counts
  std::atomic<TimePoint> until_;  ///< until when presence counts; publishes since_
};

}  // namespace gecos::access
