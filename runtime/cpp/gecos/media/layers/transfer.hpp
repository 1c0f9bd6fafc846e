#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/function_ref.hpp"

/// Transfers a large packet in pieces over a medium that loses, repeats and reorders them. Only
/// pieces that got lost are sent again. Pure: time is passed in, sending is the caller's.
/// docs/protocol.md, "Large packets", is normative. One thread at a time.
namespace gecos::media {

inline constexpr std::size_t largest_transfer = 8 * 1024 * 1024;

/// Some bytes of a packet.
struct Piece {
  static constexpr std::size_t head_bytes = 24;
  std::uint64_t transfer = 0;  ///< counts the sender's large packets, from 1
  std::uint32_t size = 0;      ///< of the packet
  std::uint32_t index = 0;
  ByteView content;

  void write_head(std::span<std::byte, head_bytes> to) const;
  /// Returns nullopt for a packet that is no piece or contradicts itself. `piece_bytes`: the bytes
  /// of each piece but the last.
  static std::optional<Piece> read(ByteView packet, std::size_t piece_bytes);
};

/// The pieces that the receiver has.
struct Received {
  static constexpr std::size_t bytes = 24;
  std::uint64_t transfer = 0;
  std::uint32_t all_before = 0;  ///< every piece before this one has arrived; the number of pieces
                                 ///< when the packet is whole
  std::uint32_t beyond = 0;      ///< bit i: piece all_before + 1 + i too

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<Received> read(ByteView packet);
};

/// Sends one packet.
class OutgoingTransfer {
 public:
  static constexpr std::uint32_t window =
      8;  ///< maximum number of pieces in flight; a usual socket buffer takes them
  /// After this time without an acknowledgement, the pieces in flight are sent again.
  static constexpr Duration silence = std::chrono::milliseconds(20);
  /// A piece counts as lost, not reordered, when so many that were sent later have arrived (RFC
  /// 9002, 6.1.1).
  static constexpr std::uint64_t reordering_threshold = 3;

  /// `piece_bytes`: what each piece carries; the last has less.
  OutgoingTransfer(std::uint64_t number, Bytes packet, std::size_t piece_bytes);

  /// Sends what may be sent now.
  void advance(TimePoint now, FunctionRef<void(const Piece&)> send);
  void take(const Received& received, TimePoint now);
  bool complete() const { return all_before_ == pieces_.size(); }
  const Bytes& packet() const { return packet_; }

 private:
  struct State {
    std::uint64_t sent_as = 0;  // number of the sending among all sendings; 0: not in flight
    bool arrived = false;
  };
  const std::uint64_t number_;
  const Bytes packet_;
  const std::size_t piece_bytes_;
  std::vector<State> pieces_;
  std::uint32_t all_before_ = 0;
  std::uint64_t sendings_ = 0;
  std::uint64_t newest_arrived_ = 0;  // by sent_as
  TimePoint last_word_{};
};

/// Reassembles one packet after the other.
class IncomingTransfers {
 public:
  explicit IncomingTransfers(std::size_t piece_bytes) : piece_bytes_(piece_bytes) {}

  /// Returns the acknowledgement to send for this piece; `whole()` may then return the packet.
  Received take(const Piece& piece);
  /// The packet that the last piece completed; returned once only.
  std::optional<Bytes> whole();

 private:
  const std::size_t piece_bytes_;
  std::uint64_t number_ = 0;  // the newest seen
  std::uint32_t missing_ = 0;
  std::uint32_t all_before_ = 0;
  std::vector<bool> arrived_;
  Bytes packet_;
  bool ready_ = false;
};

}  // namespace gecos::media
