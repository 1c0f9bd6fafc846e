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

/// Decides which calls of one session are accepted, and in which order. Accepts each call only
/// once. Does not accept a call that its client has withdrawn, or that was unread for too long.
///
/// A medium that loses packets may reorder calls. If a call that must keep its order arrives too
/// early, the call is deferred until all earlier calls have arrived; otherwise an arm could move to
/// its second goal first. Reads no clock: the caller passes the current time.
class Intake {
 public:
  /// `repeats`: the medium may lose packets, so the client resends its calls.
  explicit Intake(bool repeats) : repeats_(repeats) {}

  /// A deferred call: a call that arrived before an earlier call of its session.
  struct EarlyCall {
    wire::PacketHeader header;
    Bytes body;
    TimePoint arrived{};
    Duration age{};  ///< time since the client sent the packet
  };
  /// A packet that contains a call.
  struct Arrival {
    std::uint64_t counter = 0;
    Duration age{};  ///< time since the client sent the packet
    /// A pause of this process is not judged yet, or the client sent the packet before the last
    /// pause ended. Used only for a packet that is too_old(). False for a
    /// `stop`.
    bool from_a_pause = false;
    bool needs_all = false;  ///< the call may be accepted only after all earlier calls have arrived
  };
  enum class Verdict : std::uint8_t {
    Take,     ///< the call has arrived for the first time
    Seen,     ///< the call has arrived before: its reply was lost or is not sent yet
    Ignore,   ///< the call counts as not arrived: its client sends it again or has given it up
    TooLate,  ///< the call was unread for too long: do not start it, and notify the client
  };
  Verdict arrived(const Arrival& packet);
  /// Returns whether a packet of the age `age` was unread for too long, if the age counts.
  bool too_old(Duration age) const { return accept_within_ > Duration{} && age > accept_within_; }
  /// Notes that the client has given up those calls up to `counter` that have not arrived. Later
  /// calls no longer wait for these calls. Returns true when `next` may return calls.
  bool abandon_up_to(std::uint64_t counter);
  /// Counts the call `counter` as arrived, so that it never starts if it arrives later.
  ReceiveWindow::Verdict reject_late(std::uint64_t counter) { return window_.arrived(counter); }

  /// Returns true when a call before `counter` has not arrived.
  bool too_early(std::uint64_t counter) const {
    return repeats_ && counter > window_.cumulative_ack();
  }
  /// Defers `call` until the calls before it have arrived. Returns false and does not defer the
  /// call when the arguments of all deferred calls would take too many bytes. `now`: the current
  /// time by the same clock as in `next`. `age`: the time since the client sent the packet.
  bool put_aside(const wire::PacketView& call, TimePoint now, Duration age = {});
  /// Removes and returns the first deferred call, if no earlier call is missing. The time for which
  /// the call was deferred is added to the age of the call and subtracted from its remaining time
  /// until the deadline.
  std::optional<EarlyCall> next(TimePoint now);
  bool is_aside(std::uint64_t counter) const { return early_.contains(counter); }
  /// Returns the function code of the deferred call `counter`. @pre is_aside(counter)
  FunctionCode code_aside(std::uint64_t counter) const { return early_.at(counter).header.code; }
  std::size_t aside() const { return early_.size(); }
  /// Returns the lowest counter above `after` among the deferred calls.
  std::optional<std::uint64_t> first_aside(std::uint64_t after = 0) const;
  /// Forgets the deferred call `counter`; the caller of `drop` answers the call without starting
  /// it.
  void drop(std::uint64_t counter) { early_.erase(counter); }

  bool seen(std::uint64_t counter) const { return window_.seen(counter); }
  const ReceiveWindow& window() const { return window_; }
  /// Sets the maximum age of packets that the client demands; older packets are not accepted. Zero:
  /// no limit.
  void accept_within(Duration longest) { accept_within_ = longest; }
  Duration accepts_within() const { return accept_within_; }
  /// Notes that the client issues no more calls and that its waiting calls must not start.
  void withdraw() { withdrawn_ = true; }
  bool withdrawn() const { return withdrawn_; }

 private:
  const bool repeats_;
  ReceiveWindow window_;
  std::map<std::uint64_t, EarlyCall> early_;  ///< key: counter of the call
  Duration accept_within_{0};
  bool withdrawn_ = false;
};

}  // namespace gecos::session
