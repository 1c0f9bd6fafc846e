#pragma once

#include <cstdint>
#include <span>

#include "gecos/base/clock.hpp"
#include "gecos/media/core.hpp"

/// The way in which a thread waits: the thread polls as long as polling is cheaper than a wake-up,
/// and then sleeps on descriptors.
namespace gecos::media {

/// Says whether the peers for which a thread waits run on the core of this thread or on other
/// cores.
enum class Peers : std::uint8_t {
  Unknown,    ///< the medium cannot tell
  Here,       ///< on this core: the peers need it to send a packet
  Elsewhere,  ///< on other cores: a yield of this core helps no peer
  Both,
};

/// Returns whether `peer` runs on the core of the calling thread or on another core.
Peers place_of(const Whereabouts& peer);

/// The kind of event that ended a sleep.
enum class Woken : std::uint8_t {
  ByAnswer,  ///< the event that the thread awaits
  Early,     ///< another event, before the awaited event
};

struct SpinOptions {
  Duration shortest = std::chrono::microseconds(50);    ///< assumed minimum cost of a wake-up
  Duration longest = std::chrono::milliseconds(5);      ///< assumed maximum cost; 0: never poll
  Duration least = std::chrono::microseconds(2);        ///< minimum of the polling budget
  Duration long_wait = std::chrono::milliseconds(8);    ///< polling does not pay in longer waits
  Duration lost_core = std::chrono::microseconds(200);  ///< a yield this long has lost a time slice
  Duration crowded_first =
      std::chrono::milliseconds(20);                   ///< time without yields after a lost slice
  Duration crowded_longest = std::chrono::seconds(1);  ///< crowded_first doubles up to this
  Duration between_yields = std::chrono::microseconds(400);  ///< interval of yields if Peers::Both
  int wake_ups_averaged = 8;   ///< length of the moving average of wake-up costs
  unsigned exact_yields = 64;  ///< yields timed one by one after a suspiciously long one
  unsigned vain_in_row = 8;    ///< fruitless spins on a crowded core before waits sleep at once
  unsigned waits_between_probes = 16;  ///< one of this many long spins sleeps, to measure a wake-up
  std::uint32_t looks_alone = 256;     ///< polls between two readings of the clock
};

/// Decides, after each poll that found nothing, whether a thread should poll again or sleep. It is
/// used like this:
///
///     for (;;) {
///       if (auto packet = connection.receive()) return packet;
///       if (spin.again([&] { return place_of(connection.peer_whereabouts()); })) continue;
///       … prepare_to_sleep, sleep_on, woke …
///       spin.woke(connection.peer_whereabouts().rang_at, Woken::ByAnswer);
///       spin.begin();
///     }
///
/// The decision depends on two facts.
///
/// *The cores on which the peers run.* A peer on this core needs the core to answer, so that a
/// yield follows every poll. Peers on other cores do not need this core; a yield could only give
/// the core to an unrelated program for a whole time slice.
///
/// *The present cost of a wake-up.* This is the mean time from the peer's notification to the end
/// of the sleep. A wait polls for this time and then sleeps. Therefore a wait costs at most twice
/// as much as the better choice, polling only or sleeping at once, would have cost. Time in which
/// another program had the core does not count. A long wait halves the polling time of later waits,
/// so that long waits need hardly any CPU time.
///
/// If a yield takes at least the time `lost_core`, it gave the core to an unrelated program. For
/// some time afterwards, waits for a peer on this core sleep at once, because a wake-up takes the
/// core back from that program but a yield does not.
///
/// Only one thread at a time may use a SpinPolicy. Each waiting thread should have its own, because
/// it learns from earlier waits.
class SpinPolicy {
 public:
  explicit SpinPolicy(const Clock& clock, SpinOptions options = {},
                      const Core& core = Core::real());

  /// Begins a new wait. Costs nearly nothing if the first poll is successful.
  void begin() {
    if (state_ == State::Crowded) crowded_.vain = 0;
    state_ = State::Fresh;
    looks_ = 0;
  }
  /// Must be called after a poll that found nothing. Returns true when the thread should poll
  /// again, and false when it should sleep. After false, all further calls return false until
  /// begin(). `ask_peers` is a function that returns Peers; it is called before the second poll of
  /// a wait and occasionally later.
  template <class AskPeers>
  bool again(AskPeers ask_peers) {
    if (looks_ > 0) {
      --looks_;
      return true;
    }
    return state_ != State::Over && go_on(ask_peers());
  }
  /// Must be called after the sleep of a wait and before the next begin(). `rang_at` is the time at
  /// which the peer says that it notified this thread.
  void woke(TimePoint rang_at, Woken woken);

  /// Returns how long a wait polls before it sleeps.
  Duration budget() const { return budget_; }
  /// Returns whether the wait sleeps at once because both its peer and an unrelated program need
  /// this core.
  bool gave_way() const { return gave_way_; }
  /// Returns the time until which waits do not yield the core on which a time slice was lost. The
  /// time is in the past when yields are allowed.
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

  /// The core on which a yield lost a whole time slice to an unrelated program.
  struct CrowdedCore {
    std::int32_t number = unknown_core;
    TimePoint until{};  ///< before this time, waits do not yield this core
    Duration next{};    ///< how long waits will not yield the core after the next lost time slice
    unsigned vain = 0;  ///< consecutive spins on the core that ended with sleep
  };
  CrowdedCore crowded_;
};

enum class Wake : std::uint8_t {
  Ready,        ///< a descriptor is readable
  TimedOut,     ///< the deadline has passed
  Interrupted,  ///< a signal handler ran: check what it requested, then sleep again
};

/// Sleeps until one of `descriptors` is readable or `deadline` has passed. `deadline` is a time of
/// the steady clock; TimePoint::max() means that there is no deadline. Negative descriptors are
/// skipped.
Wake sleep_on(std::span<const int> descriptors, TimePoint deadline);

}  // namespace gecos::media
