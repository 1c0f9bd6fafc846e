#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/function_ref.hpp"

/// Transfers a large packet in pieces over a medium that may lose, repeat and reorder pieces. Only
/// lost pieces are sent again. The functions do no input or output and read no clock: the caller
/// passes the time and sends the pieces. docs/protocol.md, "Large packets", is normative. One
/// thread at a time.
namespace gecos::media {

inline constexpr std::size_t largest_transfer = 8 * 1024 * 1024;

/// A fragment of a large packet.
struct Piece {
  static constexpr std::size_t head_bytes = 24;
  std::uint64_t transfer = 0;  ///< number of the large packet; each sender counts from 1
  std::uint32_t size = 0;      ///< bytes of the whole packet
  std::uint32_t index = 0;
  ByteView content;

  void write_head(std::span<std::byte, head_bytes> to) const;
  /// Returns nullopt for a packet that is not a piece or is inconsistent. `piece_bytes`: content of
  /// every piece but the last.
  static std::optional<Piece> read(ByteView packet, std::size_t piece_bytes);
};

/// An acknowledgement: the pieces that the receiver has.
struct Received {
  static constexpr std::size_t bytes = 24;
  std::uint64_t transfer = 0;
  std::uint32_t all_before = 0;  ///< all pieces with a smaller index have arrived; the number of
                                 ///< pieces when the packet is complete
  std::uint32_t beyond = 0;      ///< bit i: piece all_before + 1 + i has arrived

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<Received> read(ByteView packet);
};

/// Sends one large packet.
class OutgoingTransfer {
 public:
  static constexpr std::uint32_t window =
      8;  ///< maximum number of pieces in flight; they fit in a usual socket buffer
  /// After this time without an acknowledgement, the pieces in flight are sent again.
  static constexpr Duration silence = std::chrono::milliseconds(20);
  /// A piece that has not arrived counts as lost, not reordered, when a piece that was sent this
  /// many sendings later has arrived (RFC 9002, 6.1.1).
  static constexpr std::uint64_t reordering_threshold = 3;

  /// `piece_bytes`: content of every piece but the last.
  OutgoingTransfer(std::uint64_t number, Bytes packet, std::size_t piece_bytes);

  /// Sends the pieces that may be sent now.
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

/// Reassembles large packets, one after the other.
class IncomingTransfers {
 public:
  explicit IncomingTransfers(std::size_t piece_bytes) : piece_bytes_(piece_bytes) {}

  /// Returns the acknowledgement to send for this piece; `whole()` may then return the packet.
  Received take(const Piece& piece);
  /// Returns the packet that the last piece completed, but only once; else nullopt.
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
