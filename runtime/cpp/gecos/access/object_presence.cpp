#include "gecos/access/object_presence.hpp"

namespace gecos::access {
namespace {

constexpr const char* zone_is_silent = "the zone has been silent for 1 s; look after its server";

}  // namespace

bool ObjectPresence::take(Report report, TimePoint made, TimePoint now) {
  const bool silent = on_tick(now);
  const bool present = report.present && now < made + report_life;
  const bool same_spell = report.spell == spell_;
  told_ = present ? Told::Present : Told::Absent;
  spell_ = report.spell;
  why_ =
      report.present && !present ? "the report of the zone came too late" : std::move(report.why);
  const bool lost = counts_ && !(present && same_spell) && lose(now);
  if (present && now >= not_before_) {
    counts_ = true;
    until_.store(made + report_life, std::memory_order_relaxed);
  }
  return silent || lost;
}

bool ObjectPresence::on_tick(TimePoint now) {
  if (!counts_ || present(now)) return false;
  return forget(zone_is_silent, now);
}

bool ObjectPresence::forget(std::string why, TimePoint now) {
  told_ = Told::Nothing;
  why_ = std::move(why);
  return counts_ && lose(now);
}

bool ObjectPresence::lose(TimePoint now) {
  counts_ = false;
  not_before_ = now + settling;
  until_.store(TimePoint::min(), std::memory_order_relaxed);
  return true;
}

std::string ObjectPresence::text(TimePoint now) const {
  if (present(now)) return "a person is present in zone " + zone_ + ": " + why_;
  if (counts_ || told_ != Told::Present) {
    return "nobody is known to be present in zone " + zone_ + ": " +
           (counts_ ? zone_is_silent : why_);
  }
  return "presence has just returned to zone " + zone_ +
         " and counts again 1 s after it was lost; wait and command again";
}

}  // namespace gecos::access
