#include "gecos/access/password_limit.hpp"

#include <algorithm>

namespace gecos::access {

Duration PasswordLimit::wait(const std::string& user, TimePoint now) const {
  const auto found = wrong_.find(user);
  if (found == wrong_.end() || found->second.size() < most_wrong) return Duration::zero();
  return std::max(found->second.front() + within - now, Duration::zero());
}

void PasswordLimit::count_wrong(const std::string& user, TimePoint now) {
  std::erase_if(wrong_, [&](const auto& entry) { return entry.second.back() + within <= now; });
  auto& times = wrong_[user];
  times.push_back(now);
  if (times.size() > most_wrong) times.erase(times.begin());
}

}  // namespace gecos::access
