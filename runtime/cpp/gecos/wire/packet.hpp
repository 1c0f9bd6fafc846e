// The packet in which all calls are sent. The packet is an LCM type that does not change; see
// docs/protocol-packet.lcm.
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

/// The purpose of a packet. New kinds may be added at the end. A receiver ignores kinds that it
/// does not know. The numbers 8, 9, 10 and 13 to 16 are reserved.
enum class PacketKind : std::int8_t {
  Hello = 1,     ///< client asks for a session
  Welcome = 2,   ///< server opens the session
  Refused = 3,   ///< server refuses the session; the body says why
  Call = 4,      ///< an operation with its parameters
  Reply = 5,     ///< the one terminal outcome of a call
  Progress = 6,  ///< progress of a call, with feedback
  Cancel = 7,    ///< client asks to cancel a call
  Goodbye = 11,  ///< the session ends in order
  Query = 12,    ///< client asks for the state of a call
};

inline constexpr std::int8_t packet_version = 1;

/// All fields of a packet except its body and its tag. A field that the packet's kind does not use
/// is zero.
struct PacketHeader {
  std::int8_t version = packet_version;
  PacketKind kind{};
  std::int8_t flags = 0;  ///< bits whose meaning depends on `kind`
  FunctionCode code{};
  SessionId session{};
  std::uint64_t counter = 0;       ///< number in the session; the same when a packet is sent again
  std::uint64_t acknowledged = 0;  ///< the client waits for no call up to this counter
  Epoch epoch{};
  Duration deadline{0};  ///< time left when the packet was sent; 0: no deadline

  friend bool operator==(const PacketHeader&, const PacketHeader&) = default;
};

/// A decoded packet. Its body and its tag refer to the bytes that were decoded.
struct PacketView {
  PacketHeader header;
  ByteView body;
  ByteView tag;  ///< authenticates the bytes before it; empty where the medium needs none
};

/// The fingerprint of the packet type. An LCM reader checks it before anything else.
inline constexpr std::int64_t packet_fingerprint = static_cast<std::int64_t>(0x90a18da222518b52u);

inline constexpr std::size_t packet_head_size =
    8 + 4 + 4 + 5 * 8 + 4;                          ///< size of the part before the body
inline constexpr std::size_t packet_tail_size = 4;  ///< size of the tag's count

/// Returns the size in bytes of a packet whose body has `body_size` bytes and whose tag has
/// `tag_size` bytes.
constexpr std::size_t packet_size(std::size_t body_size, std::size_t tag_size = 0) {
  return packet_head_size + body_size + packet_tail_size + tag_size;
}

/// Writes the bytes of a packet before its body. A sender therefore copies the body only once: the
/// sender can send head, body, tail and tag together, or encode the body right after the head. @pre
/// `body_size` fits in 32 bits, and the deadline is not negative.
void encode_packet_head(std::span<std::byte, packet_head_size> to, const PacketHeader& header,
                        std::size_t body_size);

/// Writes the time that is left until the deadline into a packet that is sent again.
/// @pre `packet` is an encoded packet, and `left` is not negative
void write_deadline(std::span<std::byte> packet, Duration left);

/// Writes the bytes of a packet between its body and its tag. They contain the size of the tag.
void encode_packet_tail(std::span<std::byte, packet_tail_size> to, std::size_t tag_size);

/// Returns a complete packet in one buffer. Copies the body and the tag.
Bytes encode_packet(const PacketHeader& header, ByteView body, ByteView tag = {});

/// Decodes a packet. Accepts packets of any version and kind, so that the caller can answer a newer
/// peer and need not drop its packets.
tl::expected<PacketView, DecodeError> decode_packet(ByteView bytes);

}  // namespace gecos::wire
