#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/function_ref.hpp"

/// The transfer of a large packet in pieces over a medium that may lose, repeat and reorder pieces.
/// Only lost pieces are sent again. The functions of this file do no input or output and read no
/// clock: the caller passes the time and sends the pieces. The section "Large packets" of
/// docs/protocol.md is normative. Only one thread at a time may use an object of these classes.
namespace gecos::media {

inline constexpr std::size_t largest_transfer = 8 * 1024 * 1024;

/// A piece of a large packet.
struct Piece {
  static constexpr std::size_t head_bytes = 24;
  std::uint64_t transfer = 0;  ///< number of the large packet; each sender counts from 1
  std::uint32_t size = 0;      ///< bytes of the whole packet
  std::uint32_t index = 0;
  ByteView content;

  void write_head(std::span<std::byte, head_bytes> to) const;
  /// Reads a piece from `packet`. Returns nullopt for a packet that is not a piece or is
  /// inconsistent. `piece_bytes` is the size of the content of each piece except the last one.
  static std::optional<Piece> read(ByteView packet, std::size_t piece_bytes);
};

/// An acknowledgement, by which the receiver reports the pieces that have arrived.
struct Received {
  static constexpr std::size_t bytes = 24;
  std::uint64_t transfer = 0;
  /// All pieces with an index below this number have arrived. This number equals the number of
  /// pieces when the packet is complete.
  std::uint32_t all_before = 0;
  std::uint32_t beyond = 0;  ///< bit i: piece all_before + 1 + i has arrived

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<Received> read(ByteView packet);
};

/// Sends one large packet.
class OutgoingTransfer {
 public:
  /// The maximum number of pieces in flight. They fit in a usual socket buffer.
  static constexpr std::uint32_t window = 8;
  /// After this time without an acknowledgement, all pieces in flight are sent again.
  static constexpr Duration silence = std::chrono::milliseconds(20);
  /// Each sending of a piece has a number. A missing piece counts as lost when another piece has
  /// arrived and the number of its sending is larger by at least this threshold. If the difference
  /// is smaller, the network may only have reordered the two pieces (RFC 9002, 6.1.1).
  static constexpr std::uint64_t reordering_threshold = 3;

  /// `piece_bytes` is the size of the content of each piece except the last one.
  OutgoingTransfer(std::uint64_t number, Bytes packet, std::size_t piece_bytes);

  /// Calls `send` for each piece that may be sent now.
  void advance(TimePoint now, FunctionRef<void(const Piece&)> send);
  void take(const Received& received, TimePoint now);
  bool complete() const { return all_before_ == pieces_.size(); }
  const Bytes& packet() const { return packet_; }

 private:
  struct State {
    std::uint64_t sent_as = 0;  // number of the latest sending of the piece, from 1; 0: never sent
    bool arrived = false;
  };
  const std::uint64_t number_;
  const Bytes packet_;
  const std::size_t piece_bytes_;
  std::vector<State> pieces_;
  std::uint32_t all_before_ = 0;
  std::uint64_t sendings_ = 0;
  std::uint64_t newest_arrived_ = 0;  // largest sent_as of a piece that arrived
  TimePoint last_word_{};
};

/// Reassembles large packets from their pieces, one packet after the other.
class IncomingTransfers {
 public:
  explicit IncomingTransfers(std::size_t piece_bytes) : piece_bytes_(piece_bytes) {}

  /// Takes a piece that has arrived. Returns the acknowledgement to send for it. If the piece
  /// completes a packet, `whole()` then returns the packet.
  Received take(const Piece& piece);
  /// Returns the packet that the last piece completed, but only once. Returns nullopt otherwise.
  std::optional<Bytes> whole();

 private:
  const std::size_t piece_bytes_;
  std::uint64_t number_ = 0;  // number of the newest transfer seen
  std::uint32_t missing_ = 0;
  std::uint32_t all_before_ = 0;
  std::vector<bool> arrived_;
  Bytes packet_;
  bool ready_ = false;
};

}  // namespace gecos::media
