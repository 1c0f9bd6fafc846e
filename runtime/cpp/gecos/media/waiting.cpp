#include "gecos/media/waiting.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>
#include <vector>

namespace gecos::media {

Peers place_of(const Whereabouts& peer) {
  if (peer.core == unknown_core) return Peers::Unknown;
  return peer.core == running_core() ? Peers::Here : Peers::Elsewhere;
}

SpinPolicy::SpinPolicy(const Clock& clock, SpinOptions options, const Core& core)
    : clock_(clock),
      options_(options),
      core_(core),
      budget_(std::min(options.shortest, options.longest)),
      crowded_{.next = options.crowded_first} {}

bool SpinPolicy::go_on(Peers peers) {
  if (state_ == State::Fresh) {
    wait_ = {.limit = budget_};
    gave_way_ = false;
  }
  if (budget_ <= Duration::zero()) return over();
  if (peers == Peers::Elsewhere) return look(State::Looking);
  if (crowded()) {
    gave_way_ = peers == Peers::Here;
    const bool vain = peers == Peers::Unknown && crowded_.vain >= options_.vain_in_row;
    return gave_way_ || vain ? over() : look(State::Crowded);
  }
  if (peers == Peers::Both && clock_.now() - last_yield_ < options_.between_yields) {
    return look(State::Looking);
  }
  return yield();
}

bool SpinPolicy::crowded() const {
  return crowded_.until != TimePoint{} && core_.number() == crowded_.number &&
         clock_.now() < crowded_.until;
}

/// Allows further polls without a yield: returns true and sets after how many polls this function
/// is called again. Returns false when the wait has used its polling time. The first call of a wait
/// does not read the clock, so that a wait for a quick answer costs no reading of the clock.
bool SpinPolicy::look(State as) {
  if (std::exchange(state_, as) == as) {
    const TimePoint now = clock_.now();
    if (wait_.began == TimePoint{}) wait_.began = last_ = now;
    wait_.looked += std::min(now - last_, options_.lost_core);
    last_ = now;
    if (spent()) {
      if (as == State::Crowded) ++crowded_.vain;
      return over();
    }
  }
  // With a small time budget, the clock must be read after fewer polls.
  looks_ = budget_ < options_.shortest ? options_.looks_alone / 4 : options_.looks_alone;
  return true;
}

/// Yields, and measures the duration of the yield by two readings of the clock. The duration is
/// exact when the yield directly follows another yield or a reading of the clock. Otherwise it is
/// only an upper bound; if this bound is long, the following yields are measured exactly. So a wait
/// with a single yield reads the clock only once.
bool SpinPolicy::yield() {
  const bool next_in_row = std::exchange(state_, State::Yielding) == State::Yielding;
  if (next_in_row && spent()) {
    crowded_.next = options_.crowded_first;  // no time slice was lost during this whole spin
    return over();
  }
  const bool exact = next_in_row || doubtful_ > 0;
  if (exact && !next_in_row) last_ = clock_.now();
  core_.yield();
  const TimePoint now = clock_.now();
  const Duration took = now - std::exchange(last_, now);
  last_yield_ = now;
  if (wait_.began == TimePoint{}) wait_.began = exact ? now - took : now;
  if (exact) {
    if (took >= options_.lost_core) return lost_slice();
    wait_.looked += took;
    if (doubtful_ > 0) --doubtful_;
  } else if (took >= options_.lost_core) {
    doubtful_ = options_.exact_yields;
  }
  return true;
}

/// Returns whether the wait has used its polling time. Waits that poll for longer than `shortest`
/// may never sleep, and then measure no wake-up. Therefore one of every `waits_between_probes` of
/// these waits sleeps early, to notice when wake-ups have become cheaper.
bool SpinPolicy::spent() {
  if (wait_.looked >= options_.shortest && !std::exchange(wait_.late, true) &&
      ++late_waits_ % options_.waits_between_probes == 0) {
    wait_.limit = std::min(wait_.limit, options_.shortest);
  }
  return wait_.looked >= wait_.limit;
}

bool SpinPolicy::lost_slice() {
  crowded_.number = core_.number();
  crowded_.until = last_ + crowded_.next;
  crowded_.next = std::min(2 * crowded_.next, options_.crowded_longest);
  crowded_.vain = 0;
  return over();
}

bool SpinPolicy::over() {
  if (wait_.began == TimePoint{}) wait_.began = clock_.now();
  state_ = State::Over;
  return false;
}

void SpinPolicy::woke(TimePoint rang_at, Woken woken) {
  if (state_ != State::Over || budget_ <= Duration::zero()) return;
  const TimePoint now = clock_.now();
  const bool told = rang_at >= wait_.began && rang_at <= now;
  if ((told ? rang_at : now) - wait_.began > options_.long_wait) {
    budget_ = std::max(budget_ / 2, options_.least);
    return;
  }
  if (woken == Woken::Early) return;
  budget_ = std::max(budget_, options_.shortest);
  if (!told) return;
  const Duration cost = std::clamp(now - rang_at, options_.shortest, options_.longest);
  budget_ += (cost - budget_) / options_.wake_ups_averaged;
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
