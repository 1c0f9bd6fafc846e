#include "gecos/qos/latency_watch.hpp"

#include <utility>

namespace gecos::qos {

LatencyWatch::Change LatencyWatch::answered(Duration round_trip, TimePoint now) {
  const Change change = judge(round_trip, now);
  failed(now);
  return change;
}

void LatencyWatch::failed(TimePoint now) {
  sent_.reset();
  next_ = now + (otherwise_since_ ? short_pause : usual_pause);
}

LatencyWatch::Change LatencyWatch::look(TimePoint now) {
  if (!sent_ || now - *sent_ <= bound_) return Change::None;
  return judge(now - *sent_, now);
}

LatencyWatch::Change LatencyWatch::judge(Duration round_trip, TimePoint now) {
  round_trip_ = round_trip;
  const bool over = round_trip > bound_;
  if (over == degraded_) {
    otherwise_since_.reset();
    return Change::None;
  }
  if (!otherwise_since_) otherwise_since_ = now;
  if (now - *otherwise_since_ < judged_after) return Change::None;
  otherwise_since_.reset();
  degraded_ = over;
  return over ? Change::Degraded : Change::Recovered;
}

}  // namespace gecos::qos
