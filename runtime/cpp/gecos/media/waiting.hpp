#pragma once

#include <cstdint>
#include <span>

#include "gecos/base/clock.hpp"

/// How to wait: spin with timed yields while that is cheap, then sleep on descriptors.
namespace gecos::media {

struct SpinOptions {
  Duration longest =
      std::chrono::microseconds(50);  ///< of one wait, before sleeping; 0: never spin
  Duration lost_core = std::chrono::microseconds(200);     ///< a yield this long gave the core away
  Duration crowded_first = std::chrono::milliseconds(20);  ///< no yield after a lost core …
  Duration crowded_longest = std::chrono::seconds(1);  ///< … doubling up to this while it recurs
  unsigned vain_in_row = 8;  ///< looks in vain of so many waits in a row: then sleep at once
  Duration quick_yield =
      std::chrono::microseconds(1);  ///< the longest that a yield to nobody takes
  std::uint32_t looks_alone = 256;   ///< looks between yields on a core of our own
};

/// Decides, look by look, whether to look again or to sleep.
///
///     for (;;) {
///       if (auto packet = link.receive()) return packet;
///       if (spin.again()) continue;
///       … arm, sleep_on, disarm …
///       spin.begin();
///     }
///
/// What a yield to nobody takes differs tenfold between machines, so it is learned: one that takes
/// twice as long as the quickest has let somebody run, and then every look is followed by a yield,
/// because it may be the peer who waits for the core. There the clock is read after the yield
/// alone: since it was read last no core was lost for longer than that, and only where it was long
/// a yield is timed by itself.
///
/// Beside a busy program a yield gives the core away for a whole time slice. It is noticed by its
/// time, and then there are no yields for a while: what comes soon comes while we look, and what
/// does not costs a wake-up, not what the neighbour likes. Where the peer needs this very core,
/// looking without yields is always in vain; that is noticed too, and then a wait sleeps at once,
/// until yields are tried again.
///
/// One thread at a time; keep one per waiting thread, for what it has learned.
class SpinPolicy {
 public:
  explicit SpinPolicy(const Clock& clock, SpinOptions options = {});
  /// A new wait begins. Costs nothing until the first look was in vain.
  void begin() {
    if (state_ == State::Crowded) vain_ = 0;
    state_ = State::Fresh;
    looks_ = 0;
  }
  /// After a look in vain. True: look again. False: sleep; false again until begin().
  bool again() {
    if (looks_ > 0) {
      --looks_;
      return true;
    }
    return go_on();
  }
  /// The core is shared, and nothing came while it was ours: whoever sends needs it.
  bool in_vain() const { return vain_ >= options_.vain_in_row; }
  /// Until when there are no yields; in the past when there are.
  TimePoint crowded_until() const { return crowded_until_; }

 private:
  enum class State : std::uint8_t { Fresh, Spinning, Crowded, Over };
  static constexpr unsigned waits_between_exact = 64;

  bool go_on();
  void begin_spinning();
  bool yield();
  bool over();
  bool timed_by_itself();

  const Clock& clock_;
  const SpinOptions options_;
  State state_ = State::Fresh;
  std::uint32_t looks_ = 0;  ///< before the clock is read, or the core given away
  std::uint32_t looks_between_yields_;
  Duration quickest_yield_;
  bool first_ = true;  ///< no yield yet in this wait
  bool doubtful_ =
      true;  ///< it was long since the clock was read last: a yield, or what came before?
  unsigned waits_ = 0;
  TimePoint began_{};
  TimePoint last_{};  ///< when the clock was read last
  TimePoint crowded_until_{};
  Duration next_crowded_;
  unsigned vain_ = 0;  ///< spins without yields, one after the other, that ended with sleep
};

enum class Wake : std::uint8_t {
  Ready,        ///< a descriptor is readable
  TimedOut,     ///< the deadline has passed
  Interrupted,  ///< a signal was handled: look at what it asked for, then sleep on
};

/// Sleeps until one of `descriptors` is readable or `deadline` (steady clock; TimePoint::max() is
/// never). Negative descriptors are skipped.
Wake sleep_on(std::span<const int> descriptors, TimePoint deadline);

}  // namespace gecos::media
