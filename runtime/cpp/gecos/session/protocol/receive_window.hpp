#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "gecos/base/bytes.hpp"

namespace gecos::session {

/// Records which counters of a session have arrived, so that no call runs twice.
class ReceiveWindow {
 public:
  enum class Verdict : std::uint8_t {
    New,
    Seen,
    Beyond,  ///< too far ahead of the first missing counter to be recorded; it counts as not
             ///< arrived
  };
  /// Notes that `counter` arrived.
  Verdict arrived(std::uint64_t counter);
  /// Notes that `counter` arrived over a medium that neither loses nor repeats packets: all lower
  /// counters have arrived too.
  void arrived_in_order(std::uint64_t counter) { cumulative_ack_ = counter; }
  /// Notes that the sender has given up the packets up to `counter` that have not arrived; these
  /// packets now count as arrived.
  void abandoned(std::uint64_t counter);
  bool seen(std::uint64_t counter) const;
  /// The highest counter up to which all counters have arrived.
  std::uint64_t cumulative_ack() const { return cumulative_ack_; }

 private:
  void advance();

  static constexpr std::size_t width = 1024;
  std::uint64_t cumulative_ack_ = 0;
  std::bitset<width> later_;  ///< [c % width]: whether c arrived, for cumulative_ack_ < c <=
                              ///< cumulative_ack_ + width
};

/// Keeps the replies that the client may request again, because the medium loses packets or the
/// session was lost.
class ReplyCache {
 public:
  void keep(std::uint64_t counter, Bytes packet);
  /// Notes that the client has received all replies up to `counter`.
  void acknowledged(std::uint64_t counter);
  /// True when the reply to `counter` is not acknowledged: the client may still request it.
  bool awaited(std::uint64_t counter) const { return counter > acknowledged_; }
  /// The reply to `counter`; null when it was acknowledged or dropped to make room.
  const Bytes* find(std::uint64_t counter) const;
  /// Drops the oldest replies when the session was lost, down to a smaller limit. The client may
  /// still request the others in another session.
  void shrink();

 private:
  static constexpr std::size_t most_replies = 512;  ///< more calls than a client may have in flight
  static constexpr std::size_t most_bytes = 16 * 1024 * 1024;  ///< size of two largest packets
  static constexpr std::size_t most_bytes_of_lost = 64 * 1024;
  struct Kept {
    std::uint64_t counter;
    Bytes packet;
  };
  void crowd_out();

  std::deque<Kept> kept_;
  std::size_t bytes_ = 0;
  std::size_t room_ = most_bytes;
  std::uint64_t acknowledged_ = 0;
};

}  // namespace gecos::session
