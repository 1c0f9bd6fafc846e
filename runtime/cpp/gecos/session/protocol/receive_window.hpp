#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "gecos/base/bytes.hpp"

namespace gecos::session {

/// Which counters of a session have arrived, so that no call runs twice.
class ReceiveWindow {
 public:
  enum class Verdict : std::uint8_t {
    New,
    Seen,
    Beyond,  ///< too far ahead of the first missing counter to be recorded: it counts as not
             ///< arrived
  };
  /// Notes that `counter` arrived.
  Verdict arrived(std::uint64_t counter);
  /// Likewise, over a medium that neither loses nor repeats: all before it arrived too.
  void arrived_in_order(std::uint64_t counter) { cumulative_ack_ = counter; }
  /// The sender has given up the packets up to `counter` that have not arrived; they now count as
  /// arrived.
  void abandoned(std::uint64_t counter);
  bool seen(std::uint64_t counter) const;
  /// Highest counter up to which all arrived.
  std::uint64_t cumulative_ack() const { return cumulative_ack_; }

 private:
  void advance();

  static constexpr std::size_t width = 1024;
  std::uint64_t cumulative_ack_ = 0;
  std::bitset<width>
      later_;  ///< later_[c % width]: c arrived, for cumulative_ack_ < c <= cumulative_ack_ + width
};

/// Replies that the client may still ask for, because its medium loses packets.
class ReplyCache {
 public:
  void keep(std::uint64_t counter, Bytes packet);
  /// The client has all replies up to `counter`.
  void acknowledged(std::uint64_t counter);
  /// Not acknowledged: the client may still ask for it.
  bool awaited(std::uint64_t counter) const { return counter > acknowledged_; }
  /// Null when it was acknowledged or crowded out.
  const Bytes* find(std::uint64_t counter) const;
  /// Reduces the cache after its session was lost; its client may still ask for replies in another
  /// session.
  void shrink();

 private:
  static constexpr std::size_t most_replies = 512;  ///< more than a client may have unanswered
  static constexpr std::size_t most_bytes = 16 * 1024 * 1024;  ///< two of the largest packets
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
