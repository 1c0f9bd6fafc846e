#pragma once

#include <cstdint>
#include <span>

#include "gecos/base/clock.hpp"
#include "gecos/media/core.hpp"

/// How to wait: poll while that is cheaper than being woken, then sleep on descriptors.
namespace gecos::media {

/// Where the peers run that may send what a thread waits for.
enum class Peers : std::uint8_t {
  Unknown,    ///< the medium cannot tell
  Here,       ///< on this core: they need it to send anything
  Elsewhere,  ///< on other cores: a yield of this core helps none of them
  Both,
};

/// Where one peer runs.
Peers place_of(const Whereabouts& peer);

/// What ended a sleep.
enum class Woken : std::uint8_t {
  ByAnswer,  ///< the event that the thread waits for
  Early,     ///< another event; the awaited one may come late
};

struct SpinOptions {
  Duration shortest = std::chrono::microseconds(50);  ///< a wake-up is taken to cost at least this
  Duration longest = std::chrono::milliseconds(5);    ///< and at most this; 0: never look
  Duration least = std::chrono::microseconds(2);      ///< budget of looks where waits last long
  Duration long_wait = std::chrono::milliseconds(8);  ///< no look pays for such a wait
  Duration lost_core = std::chrono::microseconds(200);     ///< a yield this long lost a time slice
  Duration crowded_first = std::chrono::milliseconds(20);  ///< no yield after a lost slice …
  Duration crowded_longest = std::chrono::seconds(1);  ///< … doubling up to this while it recurs
  Duration between_yields = std::chrono::microseconds(400);  ///< while peers run on both sides
  int wake_ups_averaged = 8;                                 ///< about so many make the cost of one
  unsigned exact_yields = 64;  ///< so many are timed exactly after a doubtful one
  unsigned vain_in_row = 8;    ///< looks in vain on a crowded core before waits sleep at once
  unsigned waits_between_probes = 16;  ///< one of so many late waits sleeps and measures a wake-up
  std::uint32_t looks_alone = 256;     ///< looks between two readings of the clock
};

/// Decides after each fruitless poll whether to poll again or to sleep.
///
///     for (;;) {
///       if (auto packet = link.receive()) return packet;
///       if (spin.again([&] { return place_of(link.peer_whereabouts()); })) continue;
///       … prepare_to_sleep, sleep_on, woke …
///       spin.woke(link.peer_whereabouts().rang_at, Woken::ByAnswer);
///       spin.begin();
///     }
///
/// Two facts decide, and neither is guessed from the time that a yield takes.
///
/// *Where the peers run.* A peer on this core needs the core to answer: every poll is followed by a
/// yield. Peers on other cores gain nothing from a yield; it could only give the core to an
/// unrelated program for a whole time slice.
///
/// *What a wake-up costs here and now*: the mean time from the peer's notification to the end of
/// the sleep. A wait polls for as long as a wake-up costs and then sleeps, so it is never worse
/// than twice the better of the two. Time in which another program had the core does not count. A
/// wait that lasts long halves the budget, so that long waits cost next to nothing.
///
/// A yield that takes `lost_core` gave the core to an unrelated program. For a while afterwards a
/// wait for a peer on this core sleeps at once: a wake-up takes the core back, a yield does not.
///
/// One thread at a time; keep one per waiting thread, for what it has learned.
class SpinPolicy {
 public:
  explicit SpinPolicy(const Clock& clock, SpinOptions options = {},
                      const Core& core = Core::real());

  /// Begins a new wait. Costs nothing until the first poll was in vain.
  void begin() {
    if (state_ == State::Crowded) vain_ = 0;
    state_ = State::Fresh;
    looks_ = 0;
  }
  /// Must be called after a poll in vain. Returns true: poll again. Returns false: sleep; then
  /// false again until begin(). `ask_peers` returns Peers; it is called before the second poll of a
  /// wait and now and then later.
  template <class AskPeers>
  bool again(AskPeers ask_peers) {
    if (looks_ > 0) {
      --looks_;
      return true;
    }
    return state_ != State::Over && go_on(ask_peers());
  }
  /// Must be called after the sleep of a wait and before the next begin(). `rang_at`: when the peer
  /// notified us, by its own statement.
  void woke(TimePoint rang_at, Woken woken);

  /// How long a wait polls before it sleeps.
  Duration budget() const { return budget_; }
  /// True when the wait sleeps at once because its peer and an unrelated program need this core.
  bool gave_way() const { return gave_way_; }
  /// Until when there are no yields on the core that lost a time slice; a past time when yields are
  /// allowed.
  TimePoint crowded_until() const { return crowded_until_; }

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
  // Of one wait.
  Duration limit_{};   ///< its budget
  Duration looked_{};  ///< time in which the thread had its core
  bool late_ = false;  ///< it has looked for longer than `shortest`
  TimePoint began_{};  ///< about; none before the clock is read
  unsigned late_waits_ = 0;

  TimePoint last_{};  ///< when the clock was read last
  TimePoint last_yield_{};
  unsigned doubtful_ = 0;  ///< so many yields are timed by themselves

  std::int32_t crowded_core_ = unknown_core;
  TimePoint crowded_until_{};
  Duration next_crowded_;
  unsigned vain_ = 0;  ///< spins on a crowded core, one after the other, that ended with sleep
};

enum class Wake : std::uint8_t {
  Ready,        ///< a descriptor is readable
  TimedOut,     ///< the deadline has passed
  Interrupted,  ///< a signal was handled: check what it asked for, then sleep again
};

/// Sleeps until one of `descriptors` is readable or `deadline` (steady clock; TimePoint::max() is
/// never). Negative descriptors are skipped.
Wake sleep_on(std::span<const int> descriptors, TimePoint deadline);

}  // namespace gecos::media
