#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/session/protocol/receive_window.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Decides which calls of one session are accepted, and in which order: each once, and none that
/// its client has withdrawn or that lay unread for too long. A medium that loses packets may
/// reorder calls; a call that must keep its place and arrives early is put aside until the calls
/// before it have arrived, or an arm would move to its second goal first. Pure: time is passed in.
class Intake {
 public:
  /// `repeats`: the medium may lose packets, so the client resends its calls.
  explicit Intake(bool repeats) : repeats_(repeats) {}

  /// A call that was put aside.
  struct EarlyCall {
    wire::PacketHeader header;
    Bytes body;
    TimePoint arrived{};
  };
  /// A packet with a call.
  struct Arrival {
    std::uint64_t counter = 0;
    Duration age{};          ///< how long the packet lay unread
    bool unheard = false;    ///< no heartbeat of its client came since this process was suspended
    bool needs_all = false;  ///< it counts as arrived only after all calls issued before it
  };
  enum class Verdict : std::uint8_t {
    Take,     ///< the call arrives for the first time
    Seen,     ///< it has arrived before; its answer was lost or is still pending
    Ignore,   ///< it counts as not arrived: its client sends it again, or has given it up
    TooLate,  ///< it lay unread for too long; it is not started, and its client is notified
  };
  Verdict arrived(const Arrival& packet);
  /// Whether `arrived` checks the age of a packet; otherwise `age` need not be determined.
  bool judges_age(bool unheard) const {
    return (repeats_ || unheard) && accept_within_ > Duration{};
  }
  /// The client has given up the calls up to `counter` that have not arrived; later calls no longer
  /// wait for them. Returns true when `next` may return calls.
  bool abandon_up_to(std::uint64_t counter);
  /// Counts the call `counter` as arrived, so that it never starts if it arrives later.
  ReceiveWindow::Verdict reject_late(std::uint64_t counter) { return window_.arrived(counter); }

  /// True when a call up to `counter` has not arrived.
  bool too_early(std::uint64_t counter) const {
    return repeats_ && counter > window_.cumulative_ack();
  }
  /// Keeps `call` until the calls before it have arrived. Returns false, and does not keep it, when
  /// the arguments of all calls put aside take too many bytes. `now` as for `next`.
  bool put_aside(const wire::PacketView& call, TimePoint now);
  /// Removes and returns the first call put aside, if no earlier call is missing. Its remaining
  /// time until the deadline is reduced by the time that it waited.
  std::optional<EarlyCall> next(TimePoint now);
  bool is_aside(std::uint64_t counter) const { return early_.contains(counter); }
  std::size_t aside() const { return early_.size(); }
  /// The lowest counter above `after` among the calls put aside.
  std::optional<std::uint64_t> first_aside(std::uint64_t after = 0) const;
  /// Forgets the call put aside under `counter`; it is answered without being started.
  void drop(std::uint64_t counter) { early_.erase(counter); }

  bool seen(std::uint64_t counter) const { return window_.seen(counter); }
  const ReceiveWindow& window() const { return window_; }
  /// Sets the client's limit for the age of packets: older ones are not accepted. Zero: no limit.
  void accept_within(Duration longest) { accept_within_ = longest; }
  Duration accepts_within() const { return accept_within_; }
  /// The client issues no more calls, and its calls that have not started must not start.
  void withdraw() { withdrawn_ = true; }
  bool withdrawn() const { return withdrawn_; }

 private:
  const bool repeats_;
  ReceiveWindow window_;
  std::map<std::uint64_t, EarlyCall> early_;  ///< by counter
  Duration accept_within_{0};
  bool withdrawn_ = false;
};

}  // namespace gecos::session
