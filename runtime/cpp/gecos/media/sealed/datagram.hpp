#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "gecos/base/bytes.hpp"
#include "gecos/crypto/keys.hpp"
#include "gecos/crypto/stream_seal.hpp"
#include "gecos/crypto/transport.hpp"

/// The content of a datagram of a sealed medium: a header of 16 bytes in clear, then one frame to
/// which the header is bound. docs/protocol.md, sections "Datagrams" to "Streams", is normative;
/// integers are big-endian. Pure: bytes in, bytes out.
namespace gecos::media {

enum class DatagramKind : std::uint8_t {
  Ask = 1,  ///< client, at a well-known place: whose is it?
  Key,      ///< server: mine. A public key, which proves nothing yet
  First,    ///< client: the handshake's first message
  Second,   ///< server: its second
  Sealed,   ///< both: a sealed packet, see PacketKind
  Sample,   ///< on a stream's own channel: a sealed sample
};

struct DatagramHeader {
  static constexpr std::size_t bytes = 16;
  DatagramKind kind = DatagramKind::Sealed;
  std::uint16_t reply_port = 0;  ///< where the client listens; 0 from a server
  std::uint64_t client = 0;      ///< drawn for each connection; 0 of a sample

  void write(std::span<std::byte, bytes> to) const;
  /// Returns nullopt for bytes that are no datagram of ours.
  static std::optional<DatagramHeader> read(ByteView from);
};

/// What is sealed in a channel.
enum class InnerKind : std::uint8_t {
  Packet = 1,
  Beat,
  Bye,
  Share,         ///< server: a SharedStream, until it was opened
  Opened,        ///< both: stream `number` of yours is being read
  Unshare,       ///< both: stream `number` of mine ends for you
  InwardShare,   ///< client: an InwardShare, until it was opened
  InwardSample,  ///< client: sample `number` of a stream, with an InwardSampleHead
};

/// Stands in front of what is sealed.
struct InnerHeader {
  static constexpr std::size_t bytes = 17;
  InnerKind kind = InnerKind::Beat;
  std::uint64_t number = 0;
  std::int64_t sent_ns = 0;  ///< by the sender's clock, which counts from any moment

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<InnerHeader> read(ByteView from);
};

/// The channel of a shared stream, and the key that opens it. Sent sealed.
struct SharedStream {
  static constexpr std::uint16_t most_depth = 1024;
  static constexpr std::size_t bytes = 20 + crypto::StreamKey::bytes;
  std::uint32_t id = 0;
  std::uint32_t largest = 0;
  std::uint16_t depth = 0;
  std::uint16_t port = 0;
  std::uint64_t channel = 0;
  crypto::StreamKey key;

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<SharedStream> read(ByteView from);
};

inline constexpr std::size_t stamp_bytes = 8;  ///< before a sample
/// How much longer a datagram is than the packet that it carries.
inline constexpr std::size_t packet_overhead =
    DatagramHeader::bytes + crypto::Sealer::overhead + InnerHeader::bytes;
/// How much longer a datagram is than the sample that it carries.
inline constexpr std::size_t sample_overhead =
    DatagramHeader::bytes + crypto::StreamSealer::overhead + stamp_bytes;

/// A stream of a client to its server. Its samples travel in the sealed channel of the two.
struct InwardShare {
  static constexpr std::size_t bytes = 10;
  std::uint32_t id = 0;
  std::uint32_t largest = 0;
  std::uint16_t depth = 0;

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<InwardShare> read(ByteView from);
};

/// Stands in front of an inward sample.
struct InwardSampleHead {
  static constexpr std::size_t bytes = 12;
  std::uint32_t id = 0;
  std::int64_t stamp_ns = 0;

  void write(std::span<std::byte, bytes> to) const;
  /// Returns nullopt when `from` is shorter; the sample follows the head.
  static std::optional<InwardSampleHead> read(ByteView from);
};

void write_stamp(std::span<std::byte, 8> to, std::int64_t stamp_ns);
/// @pre `from` has 8 bytes.
std::int64_t read_stamp(ByteView from);

/// An address: "lcm:239.255.76.67:20017/GO0123456789abcdef#" and 64 hex digits, the server's key; a
/// well-known place has none.
struct SealedAddress {
  std::string medium;
  std::string network;  ///< of letters, digits, '.' and '-', at most 45 characters
  std::uint16_t port = 0;
  std::string channel;  ///< at most 63 characters
  std::optional<crypto::PublicKey> key;

  /// Without the key.
  std::string place() const;
  std::string to_string() const;
  static std::optional<SealedAddress> parse(std::string_view text);
};

/// What both sides know of a handshake without sending it: medium and version, place, and the clear
/// header of its first message.
Bytes handshake_context(const SealedAddress& address, ByteView first_header);

}  // namespace gecos::media
