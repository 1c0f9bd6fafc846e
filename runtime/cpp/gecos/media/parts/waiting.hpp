#pragma once

#include <cstdint>
#include <span>

#include "gecos/base/clock.hpp"
#include "gecos/media/core.hpp"

/// How a thread waits: it polls while polling is cheaper than a wake-up, then sleeps on
/// descriptors.
namespace gecos::media {

/// Whether the peers that a thread waits for run on the thread's core or on other cores.
enum class Peers : std::uint8_t {
  Unknown,    ///< the medium cannot tell
  Here,       ///< on this core: the peers need it to send a packet
  Elsewhere,  ///< on other cores: a yield of this core helps no peer
  Both,
};

/// Where one peer runs, relative to the core of the calling thread.
Peers place_of(const Whereabouts& peer);

/// What ended a sleep.
enum class Woken : std::uint8_t {
  ByAnswer,  ///< the event that the thread awaits
  Early,     ///< another event, before the awaited event
};

struct SpinOptions {
  Duration shortest = std::chrono::microseconds(50);    ///< assumed minimum cost of a wake-up
  Duration longest = std::chrono::milliseconds(5);      ///< assumed maximum cost; 0: never poll
  Duration least = std::chrono::microseconds(2);        ///< minimum of the polling budget
  Duration long_wait = std::chrono::milliseconds(8);    ///< longer waits are not worth polling
  Duration lost_core = std::chrono::microseconds(200);  ///< a yield this long has lost a time slice
  Duration crowded_first = std::chrono::milliseconds(20);    ///< no yields after a lost time slice
  Duration crowded_longest = std::chrono::seconds(1);        ///< crowded_first doubles up to this
  Duration between_yields = std::chrono::microseconds(400);  ///< interval of yields if Peers::Both
  int wake_ups_averaged = 8;   ///< length of the moving average of wake-up costs
  unsigned exact_yields = 64;  ///< yields timed one by one after a suspiciously long one
  unsigned vain_in_row = 8;    ///< fruitless spins on a crowded core before waits sleep at once
  unsigned waits_between_probes = 16;  ///< one of this many long spins sleeps, to measure a wake-up
  std::uint32_t looks_alone = 256;     ///< polls between two readings of the clock
};

/// Decides after each fruitless poll whether to poll again or to sleep.
///
///     for (;;) {
///       if (auto packet = connection.receive()) return packet;
///       if (spin.again([&] { return place_of(connection.peer_whereabouts()); })) continue;
///       … prepare_to_sleep, sleep_on, woke …
///       spin.woke(connection.peer_whereabouts().rang_at, Woken::ByAnswer);
///       spin.begin();
///     }
///
/// Two facts decide whether to poll again. Neither is derived from the duration of a yield.
///
/// *Where the peers run.* A peer on this core needs the core to answer: every poll is followed by a
/// yield. Peers on other cores gain nothing from a yield; a yield could only give the core to an
/// unrelated program for a whole time slice.
///
/// *What a wake-up costs here and now*: the mean time from the peer's notification to the end of
/// the sleep. A wait polls for as long as a wake-up costs and then sleeps, so it never costs more
/// than twice the cheaper of polling and sleeping. Time in which another program had the core does
/// not count. A long wait halves the polling time of later waits, so that long waits cost next to
/// nothing.
///
/// A yield that takes at least `lost_core` gave the core to an unrelated program. For a while
/// afterwards a wait for a peer on this core sleeps at once: a wake-up takes the core back, a yield
/// does not.
///
/// One thread at a time. Keep one policy per waiting thread, because it learns from earlier waits.
class SpinPolicy {
 public:
  explicit SpinPolicy(const Clock& clock, SpinOptions options = {},
                      const Core& core = Core::real());

  /// Begins a new wait. Costs nothing until the first poll has found nothing.
  void begin() {
    if (state_ == State::Crowded) crowded_.vain = 0;
    state_ = State::Fresh;
    looks_ = 0;
  }
  /// Must be called after a poll that found nothing. Returns true: poll again. Returns false:
  /// sleep; further calls return false until begin(). `ask_peers` returns Peers; it is called
  /// before the second poll of a wait and occasionally later.
  template <class AskPeers>
  bool again(AskPeers ask_peers) {
    if (looks_ > 0) {
      --looks_;
      return true;
    }
    return state_ != State::Over && go_on(ask_peers());
  }
  /// Must be called after the sleep of a wait and before the next begin(). `rang_at`: when the peer
  /// notified this thread, as the peer states it.
  void woke(TimePoint rang_at, Woken woken);

  /// How long a wait polls before it sleeps.
  Duration budget() const { return budget_; }
  /// Whether the wait sleeps at once because its peer and an unrelated program need this core.
  bool gave_way() const { return gave_way_; }
  /// The moment until which waits do not yield the core that lost a time slice. It is in the past
  /// when yields are allowed.
  TimePoint crowded_until() const { return crowded_.until; }

 private:
  enum class State : std::uint8_t { Fresh, Looking, Crowded, Yielding, Over };

  bool go_on(Peers peers);
  bool crowded() const;
  bool look(State as);
  bool yield();
  bool spent();
  bool lost_slice();
  bool over();

  const Clock& clock_;
  const SpinOptions options_;
  const Core& core_;
  State state_ = State::Fresh;
  std::uint32_t looks_ = 0;  ///< polls left before the clock is read or the core is yielded
  bool gave_way_ = false;

  Duration budget_;
  struct CurrentWait {
    Duration limit{};   ///< how long this wait may poll
    Duration looked{};  ///< time spent polling while the thread had its core
    bool late = false;  ///< this wait has polled for longer than `shortest`
    TimePoint began{};  ///< approximate start; unset before the clock is read
  };
  CurrentWait wait_;
  unsigned late_waits_ = 0;

  TimePoint last_{};  ///< when the clock was read last
  TimePoint last_yield_{};
  unsigned doubtful_ = 0;  ///< number of yields still to be timed one by one

  /// The core on which a yield lost a time slice.
  struct CrowdedCore {
    std::int32_t number = unknown_core;
    TimePoint until{};  ///< waits do not yield this core before
    Duration next{};    ///< for how long they do not yield it when it loses the next time slice
    unsigned vain = 0;  ///< consecutive spins on it that ended with sleep
  };
  CrowdedCore crowded_;
};

enum class Wake : std::uint8_t {
  Ready,        ///< a descriptor is readable
  TimedOut,     ///< the deadline has passed
  Interrupted,  ///< a signal handler ran: check what it requested, then sleep again
};

/// Sleeps until one of `descriptors` is readable or `deadline` has passed (steady clock;
/// TimePoint::max(): no deadline). Negative descriptors are skipped.
Wake sleep_on(std::span<const int> descriptors, TimePoint deadline);

}  // namespace gecos::media
