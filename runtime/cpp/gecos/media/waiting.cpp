#include "gecos/media/waiting.hpp"

#include <poll.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>
#include <vector>

namespace gecos::media {

SpinPolicy::SpinPolicy(const Clock& clock, SpinOptions options)
    : clock_(clock),
      options_(options),
      looks_between_yields_(options.looks_alone),
      quickest_yield_(options.quick_yield),
      next_crowded_(options.crowded_first) {}

bool SpinPolicy::over() {
  state_ = State::Over;
  return false;
}

bool SpinPolicy::go_on() {
  if (state_ == State::Fresh) {
    begin_spinning();
    if (looks_ != 0) return true;
  }
  if (state_ == State::Spinning) return yield();
  if (state_ == State::Over) return false;
  if (clock_.now() - began_ >= options_.longest) {
    ++vain_;
    return over();
  }
  looks_ = options_.looks_alone;
  return true;
}

void SpinPolicy::begin_spinning() {
  state_ = State::Over;
  if (options_.longest <= Duration::zero()) return;
  const TimePoint now = crowded_until_ == TimePoint{} ? TimePoint{} : clock_.now();
  if (now < crowded_until_) {
    if (vain_ >= options_.vain_in_row) return;
    state_ = State::Crowded;
    began_ = now;
    looks_ = options_.looks_alone;
    return;
  }
  state_ = State::Spinning;
  vain_ = 0;
  first_ = true;
  looks_ = looks_between_yields_;
}

/// Else it took at most what passed since the clock was read last.
bool SpinPolicy::timed_by_itself() {
  return !first_ || looks_between_yields_ != 0 || doubtful_ || ++waits_ % waits_between_exact == 0;
}

bool SpinPolicy::yield() {
  const bool exact = timed_by_itself();
  const bool just_read = !first_ && looks_between_yields_ == 0;
  const TimePoint before = exact && !just_read ? clock_.now() : last_;
  ::sched_yield();
  const TimePoint now = last_ = clock_.now();
  const Duration took = now - before;
  if (std::exchange(first_, false)) began_ = exact ? before : now;
  doubtful_ = !exact && took >= options_.lost_core;
  if (exact) {
    if (took >= options_.lost_core) {
      crowded_until_ = now + next_crowded_;
      next_crowded_ = std::min(2 * next_crowded_, options_.crowded_longest);
      vain_ = 0;
      return over();
    }
    // Somebody else ran here, perhaps the peer: every look before the next yield would delay it.
    quickest_yield_ = std::min(quickest_yield_, took);
    looks_between_yields_ = took >= 2 * quickest_yield_ ? 0 : options_.looks_alone;
  }
  if (now - began_ >= options_.longest) {
    next_crowded_ = options_.crowded_first;  // a whole spin in which the core stayed ours
    return over();
  }
  looks_ = looks_between_yields_;
  return true;
}

namespace {

timespec until(TimePoint deadline) {
  const auto left = std::max(Duration::zero(), deadline - std::chrono::steady_clock::now());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  return {static_cast<time_t>(seconds.count()), static_cast<long>((left - seconds).count())};
}

}  // namespace

Wake sleep_on(std::span<const int> descriptors, TimePoint deadline) {
  constexpr std::size_t usual = 16;
  std::array<pollfd, usual> few;
  std::vector<pollfd> many(descriptors.size() > usual ? descriptors.size() : 0);
  pollfd* const watched = many.empty() ? few.data() : many.data();
  for (std::size_t i = 0; i < descriptors.size(); ++i) watched[i] = {descriptors[i], POLLIN, 0};

  const bool forever = deadline == TimePoint::max();
  const timespec left = forever ? timespec{} : until(deadline);
  const int ready = ::ppoll(watched, descriptors.size(), forever ? nullptr : &left, nullptr);
  if (ready > 0) return Wake::Ready;
  if (ready < 0) return Wake::Interrupted;
  return Wake::TimedOut;
}

}  // namespace gecos::media
