#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "gecos/base/bytes.hpp"

namespace gecos::session {

/// Records which calls of a session have arrived, by their counters, so that no call is carried out
/// twice.
class ReceiveWindow {
 public:
  enum class Verdict : std::uint8_t {
    New,
    Seen,
    /// The counter is too far ahead of the first missing counter to be recorded, so it counts as
    /// not arrived.
    Beyond,
  };
  /// Notes that the call `counter` has arrived, unless the result is Beyond.
  Verdict arrived(std::uint64_t counter);
  /// Notes that `counter` arrived over a medium that neither loses nor repeats packets: all lower
  /// counters have arrived too.
  void arrived_in_order(std::uint64_t counter) { cumulative_ack_ = counter; }
  /// Notes that the sender has given up the packets up to `counter` that have not arrived; these
  /// packets now count as arrived.
  void abandoned(std::uint64_t counter);
  bool seen(std::uint64_t counter) const;
  /// Returns the highest counter up to which all counters have arrived.
  std::uint64_t cumulative_ack() const { return cumulative_ack_; }

 private:
  void advance();

  static constexpr std::size_t width = 1024;
  std::uint64_t cumulative_ack_ = 0;
  /// For each counter c with cumulative_ack_ < c <= cumulative_ack_ + width, the bit c % width says
  /// whether c has arrived.
  std::bitset<width> later_;
};

/// Keeps replies, because the client may request them again when the medium has lost a packet or
/// the session was lost.
class ReplyCache {
 public:
  void keep(std::uint64_t counter, Bytes packet);
  /// Notes that the client has received all replies up to `counter`.
  void acknowledged(std::uint64_t counter);
  /// Returns true when the reply to `counter` is not acknowledged yet, so that the client may still
  /// request it.
  bool awaited(std::uint64_t counter) const { return counter > acknowledged_; }
  /// Returns the reply to `counter`; null when the reply was acknowledged, or was dropped to make
  /// room.
  const Bytes* find(std::uint64_t counter) const;
  /// Lowers the limit of the size of all kept replies, and drops the oldest replies until the limit
  /// is met. Must be called when the session was lost: the client may still request the remaining
  /// replies in another session.
  void shrink();

 private:
  /// The maximum number of replies that are kept. It is greater than the number of calls that a
  /// client may have without a reply.
  static constexpr std::size_t most_replies = 512;
  /// The maximum size of all kept replies. It is twice the size of the largest packet that can be
  /// sent over a medium that loses packets.
  static constexpr std::size_t most_bytes = 16 * 1024 * 1024;
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
