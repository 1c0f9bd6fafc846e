#include <algorithm>

#include "gecos/binding.hpp"
#include "gecos/session/client/broker_news.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {

CreateWait::CreateWait(const LabOrWhyNot& lab, const std::vector<std::string>& names,
                       Duration longest)
    : lab_(*lab), until_(system_clock().now()) {
  const bool all_nil = std::ranges::all_of(names, &std::string::empty);
  if (!all_nil) until_ = deadline_after(longest);
}

CreateWait::~CreateWait() = default;

bool CreateWait::helps(const CreateError& why) const {
  const bool may_come = std::ranges::any_of(
      why.attempts, [](const auto& attempt) { return attempt.detail == Detail::NoServer; });
  return may_come && system_clock().now() < until_ && !lab_->closed();
}

bool CreateWait::wait(TimePoint until) {
  if (!news_) news_ = std::make_unique<BrokerNews>(lab_);
  return news_->wait(std::min(until, until_)) || system_clock().now() >= until_ || lab_->closed();
}

}  // namespace gecos::session
