#include "gecos/qos/failover_plan.hpp"

#include <utility>

namespace gecos::qos {

FailoverPlan::Act FailoverPlan::look(bool degraded, bool must_stay, TimePoint now) {
  if (searching_) return Act::None;
  if (!degraded) {
    moved();
    return Act::None;
  }
  if (must_stay) return std::exchange(reported_, true) ? Act::None : Act::ReportStay;
  if (now < next_) return Act::None;
  searching_ = true;
  return Act::Search;
}

bool FailoverPlan::found_none(TimePoint now) {
  searching_ = false;
  next_ = now + between_searches;
  return !std::exchange(reported_, true);
}

}  // namespace gecos::qos
