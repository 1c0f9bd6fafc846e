#include "gecos/access/object_presence.hpp"

#include <algorithm>
#include <utility>

namespace gecos::access {
namespace {

constexpr const char* zone_is_silent =
    "the zone has been silent for 1 s; check that its server runs";

}  // namespace

bool ObjectPresence::take(Report report, TimePoint made, TimePoint now) {
  const bool silent = on_tick(now);
  // The clock of another host may be ahead. Therefore no report counts for more than 1 s from now.
  const TimePoint until = std::min(made, now) + report_life;
  const bool present = report.present && now < until;
  const bool goes_on = present && report.spell == spell_;
  const bool lost = told_ == Told::Present && !goes_on && lose(now);
  told_ = present ? Told::Present : Told::Absent;
  told_until_ = until;
  spell_ = report.spell;
  why_ = report.present && !present
             ? "the report of the zone came too late; wait for its next report"
             : std::move(report.why);
  if (present && now >= not_before_) {
    if (!std::exchange(counts_, true)) since_.store(now, std::memory_order_relaxed);
    until_.store(until, std::memory_order_release);
  }
  return silent || lost;
}

bool ObjectPresence::on_tick(TimePoint now) {
  if (told_ != Told::Present || now < told_until_) return false;
  return forget(zone_is_silent, now);
}

bool ObjectPresence::forget(std::string why, TimePoint now) {
  why_ = std::move(why);
  return std::exchange(told_, Told::Nothing) == Told::Present && lose(now);
}

bool ObjectPresence::enter(std::string zone, TimePoint now) {
  const bool needed_nobody = !required();
  zone_ = std::move(zone);
  told_ = Told::Nothing;
  why_ = unheard;
  return lose(now) || needed_nobody;
}

/// Called when presence ends, and also when a person leaves before the reported presence counts.
/// The time `settling` then begins again, because a command may have been issued since the report.
bool ObjectPresence::lose(TimePoint now) {
  not_before_ = now + settling;
  until_.store(TimePoint::min(), std::memory_order_relaxed);
  return std::exchange(counts_, false);
}

std::string ObjectPresence::text(TimePoint now) const {
  if (present(now)) return "a person is present in zone " + zone_ + ": " + why_;
  const bool silent = told_ == Told::Present && now >= told_until_;
  if (silent || told_ != Told::Present) {
    return "nobody is known to be present in zone " + zone_ + ": " +
           (silent ? zone_is_silent : why_);
  }
  return "a person is present again in zone " + zone_ +
         ", but presence counts only 1 s after it was lost; wait and command again";
}

}  // namespace gecos::access
