#include <algorithm>
#include <chrono>

#include "gecos/binding.hpp"

namespace gecos::session {

CreateWait::CreateWait(const std::vector<std::string>& names, Duration longest, TimePoint now)
    : until_(now) {
  const bool all_nil = std::ranges::all_of(names, &std::string::empty);
  if (!all_nil) until_ = longest < TimePoint::max() - now ? now + longest : TimePoint::max();
}

std::optional<TimePoint> CreateWait::next(const CreateError& why, TimePoint now) {
  const bool may_come = std::ranges::any_of(
      why.attempts, [](const auto& attempt) { return attempt.detail == Detail::NoServer; });
  if (!may_come || now >= until_) return std::nullopt;
  const TimePoint again = std::min(until_, now + pause_);
  pause_ = std::min<Duration>(pause_ * 2, std::chrono::milliseconds(160));
  return again;
}

}  // namespace gecos::session
