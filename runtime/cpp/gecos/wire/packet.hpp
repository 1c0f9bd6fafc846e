// The one envelope that calls travel in: a stable LCM type, see docs/protocol-packet.lcm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/ids.hpp"
#include "gecos/base/result.hpp"
#include "gecos/wire/decode_error.hpp"

namespace gecos::wire {

/// The purpose of a packet. New kinds may be added at the end; a receiver ignores those it does not
/// know. 8, 9, 10 and 13 to 16 are reserved.
enum class PacketKind : std::int8_t {
  Hello = 1,     ///< client asks for a session
  Welcome = 2,   ///< server opens it
  Refused = 3,   ///< server does not, the body says why
  Call = 4,      ///< an operation with its parameters
  Reply = 5,     ///< its one terminal outcome
  Progress = 6,  ///< how far a running one is, with feedback
  Cancel = 7,    ///< client asks to end a running one
  Goodbye = 11,  ///< the session ends in order
  Query = 12,    ///< what became of a counter?
};

inline constexpr std::int8_t packet_version = 1;

/// Every field but body and tag. Zero where a kind has no use for one.
struct PacketHeader {
  std::int8_t version = packet_version;
  PacketKind kind{};
  std::int8_t flags = 0;  ///< meaning depends on the kind
  FunctionCode code{};
  SessionId session{};
  std::uint64_t counter = 0;       ///< numbers a session's packets; a repeated one keeps it
  std::uint64_t acknowledged = 0;  ///< highest counter below which all arrived
  Epoch epoch{};
  Duration deadline{0};  ///< left when it was sent; 0: none

  friend bool operator==(const PacketHeader&, const PacketHeader&) = default;
};

/// A decoded packet. Body and tag borrow the bytes that were decoded.
struct PacketView {
  PacketHeader header;
  ByteView body;
  ByteView tag;  ///< authentication of everything before it; empty where the medium needs none
};

/// The fingerprint, which an LCM reader checks first.
inline constexpr std::int64_t packet_fingerprint = static_cast<std::int64_t>(0x90a18da222518b52u);

inline constexpr std::size_t packet_head_size = 8 + 4 + 4 + 5 * 8 + 4;  ///< up to the body
inline constexpr std::size_t packet_tail_size = 4;                      ///< the tag's count

/// All of a packet around `body_size` and `tag_size` bytes.
constexpr std::size_t packet_size(std::size_t body_size, std::size_t tag_size = 0) {
  return packet_head_size + body_size + packet_tail_size + tag_size;
}

/// What stands before the body, so that a sender gathers {head, body, tail, tag} or encodes the
/// body right after the head, and copies it once.
/// @pre body_size fits int32, deadline is not negative.
void encode_packet_head(std::span<std::byte, packet_head_size> to, const PacketHeader& header,
                        std::size_t body_size);

/// Says what is left of the deadline of a packet that is sent again.
/// @pre `packet` is an encoded one, `left` is not negative
void write_deadline(std::span<std::byte> packet, Duration left);

/// The bytes between body and tag: the size of the tag.
void encode_packet_tail(std::span<std::byte, packet_tail_size> to, std::size_t tag_size);

/// A complete packet in one buffer; copies body and tag.
Bytes encode_packet(const PacketHeader& header, ByteView body, ByteView tag = {});

/// Versions and kinds are not judged here: a newer peer is to be answered, not dropped.
tl::expected<PacketView, DecodeError> decode_packet(ByteView bytes);

}  // namespace gecos::wire
