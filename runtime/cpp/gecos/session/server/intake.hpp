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

/// Which calls of one session are taken up, and in which order: each once, and none that its client
/// has withdrawn or that lay unread for too long. Over a medium that loses packets a call may
/// arrive before one that was issued before it; a call that has to keep its place is put aside
/// until then, or an arm would move to its second goal first. Pure: time is passed in.
class Intake {
 public:
  /// `repeats`: the medium may lose packets, so its client sends them again.
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
    Duration age{};          ///< it lay unread for so long
    bool unheard = false;    ///< no heartbeat of its client came since this process stood still
    bool needs_all = false;  ///< it arrives only after all that was issued before it
  };
  enum class Verdict : std::uint8_t {
    Take,     ///< it is here for the first time
    Seen,     ///< it has arrived before: its answer was lost, or is not given yet
    Ignore,   ///< it counts as not arrived: its client sends it again, or has given it up
    TooLate,  ///< it lay unread for too long: it is not started, and its client is told
  };
  Verdict arrived(const Arrival& packet);
  /// Whether the age of a packet counts: only then it has to be asked for.
  bool judges_age(bool unheard) const {
    return (repeats_ || unheard) && accept_within_ > Duration{};
  }
  /// Its client has given up what has not arrived up to `counter`: nothing waits for that any more.
  /// True when `next` may have calls.
  bool abandon_up_to(std::uint64_t counter);
  /// What has not arrived under this counter counts as arrived from now on: it never starts.
  ReceiveWindow::Verdict reject_late(std::uint64_t counter) { return window_.arrived(counter); }

  /// Calls that were issued before it are missing.
  bool too_early(std::uint64_t counter) const {
    return repeats_ && counter > window_.cumulative_ack();
  }
  /// False, and it is not kept, when its arguments and those of the others put aside take too much.
  /// `now` as for `next`.
  bool put_aside(const wire::PacketView& call, TimePoint now);
  /// The first call that was put aside and waits for nothing any more. What is left until its
  /// deadline is less by the time that it waited.
  std::optional<EarlyCall> next(TimePoint now);
  bool is_aside(std::uint64_t counter) const { return early_.contains(counter); }
  std::size_t aside() const { return early_.size(); }
  /// The first of them after `counter`.
  std::optional<std::uint64_t> first_aside(std::uint64_t after = 0) const;
  /// It is answered without being taken up.
  void drop(std::uint64_t counter) { early_.erase(counter); }

  bool seen(std::uint64_t counter) const { return window_.seen(counter); }
  const ReceiveWindow& window() const { return window_; }
  /// As its client asked: what is older is not taken up. Zero: however old it is.
  void accept_within(Duration longest) { accept_within_ = longest; }
  Duration accepts_within() const { return accept_within_; }
  /// Its client starts nothing more, and what has not started does not start.
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
