#include "gecos/session/client/broker_news.hpp"

#include <algorithm>

#include "gecos/broker_interface.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/client_connection.hpp"

namespace gecos::session {
namespace {

constexpr Duration longest_pause = std::chrono::milliseconds(160);
constexpr Duration longest_pause_when_refused = std::chrono::seconds(1);
/// A closed Lab is noticed within this time.
constexpr Duration slice = std::chrono::milliseconds(100);
constexpr Duration ask_anyway_after = std::chrono::seconds(1);
constexpr Duration patience = std::chrono::seconds(2);

}  // namespace

BrokerNews::Heard BrokerNews::subscribe(TimePoint deadline) {
  const auto now = [this] { return lab_->runtime()->clock().now(); };
  const auto found = lab_->broker(now() + patience);
  if (!found) {
    lab_->closed_by(std::min(deadline, now() + pause_));
    const bool refused = found.error().answer == BrokerAnswer::Refused;
    pause_ = std::min(pause_ * 2, refused ? longest_pause_when_refused : longest_pause);
    return Heard::Nothing;
  }
  broker_ = *found;
  pause_ = shortest_pause;
  sample_ = {};
  auto opened = broker_->subscribe(BrokerInterface::revision_stream);
  revisions_ = opened.value_or(nullptr);
  return Heard::News;
}

bool BrokerNews::wait(TimePoint deadline) {
  const auto now = [this] { return lab_->runtime()->clock().now(); };
  const TimePoint ask_anyway = now() + ask_anyway_after;
  while (!lab_->closed()) {
    if (!broker_ || broker_->lost()) {
      revisions_.reset();
      broker_.reset();
      if (subscribe(deadline) == Heard::News) return true;
    } else if (now() >= ask_anyway) {
      return true;
    } else {
      const TimePoint until = std::min({deadline, ask_anyway, now() + slice});
      if (!revisions_) {
        lab_->closed_by(until);
      } else if (revisions_->next(sample_, until)) {
        return true;
      }
    }
    if (now() >= deadline) return false;
  }
  return false;
}

}  // namespace gecos::session
