#include "gecos/session/client/list_view.hpp"

#include <algorithm>
#include <set>

#include "gecos/base/seconds.hpp"

namespace gecos::session {
namespace {

bool is_a(const Entry& entry, const std::string& interface_name) {
  return entry.interface_name == interface_name ||
         std::ranges::find(entry.bases, interface_name) != entry.bases.end();
}

}  // namespace

bool ListView::watched(const Registration& one) const {
  return one.presence != Presence::GONE &&
         (interface_name_.empty() || is_a(one.entry, interface_name_));
}

void ListView::put(const Registration& one, std::vector<Registration>& news) {
  const std::string& name = one.entry.name;
  const auto known = known_.find(name);
  expected_back_by_.erase(name);
  if (!watched(one)) {
    if (known == known_.end()) return;
    news.push_back(std::move(known->second));
    news.back().presence = Presence::GONE;
    news.back().silent_for = 0;
    known_.erase(known);
    return;
  }
  const bool same = known != known_.end() && known->second.presence == one.presence &&
                    known->second.entry == one.entry;
  known_.insert_or_assign(name, one);
  if (!same) news.push_back(one);
}

std::vector<Registration> ListView::take(const ListChanges& answer, TimePoint now) {
  std::vector<Registration> news;
  const bool same_life = answer.revision.life == revision_.life;
  for (const Registration& one : answer.changed) put(one, news);
  if (answer.whole) {
    if (same_life) skipped_ += answer.revision.number - revision_.number;
    std::set<std::string> listed;
    for (const Registration& one : answer.changed) listed.insert(one.entry.name);
    const Duration age = from_seconds(answer.running_for);
    const TimePoint back_by = now + std::max(servers_return_within - age, Duration::zero());
    for (const auto& [name, one] : known_) {
      if (listed.contains(name)) continue;
      if (same_life) {
        expected_back_by_.emplace(name, now);
      } else {
        expected_back_by_.insert_or_assign(name, back_by);
      }
    }
  }
  revision_ = answer.revision;
  for (Registration& gone : missing(now)) news.push_back(std::move(gone));
  return news;
}

std::vector<Registration> ListView::missing(TimePoint now) {
  std::vector<Registration> news;
  std::vector<Registration> gone;
  for (const auto& [name, by] : expected_back_by_) {
    if (now < by) continue;
    gone.push_back(known_.at(name));
    gone.back().presence = Presence::GONE;
  }
  for (const Registration& one : gone) put(one, news);
  return news;
}

std::optional<TimePoint> ListView::next_check() const {
  std::optional<TimePoint> next;
  for (const auto& [name, by] : expected_back_by_) {
    if (!next || by < *next) next = by;
  }
  return next;
}

}  // namespace gecos::session
