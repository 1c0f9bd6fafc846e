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

/// Encoding and decoding of the datagrams of a sealed medium. A datagram consists of a plaintext
/// header of 16 bytes and one frame, which authenticates the header. Integers are big-endian. The
/// sections "Datagrams" to "Streams" of docs/protocol.md are normative. The functions only convert
/// bytes; they do no input or output.
namespace gecos::media {

enum class DatagramKind : std::uint8_t {
  Ask = 1,  ///< client: asks for the server's key at a well-known address
  Key,      ///< server: its public key, which is not proved yet
  First,    ///< client: the first message of the handshake
  Second,   ///< server: the second message of the handshake
  Sealed,   ///< client or server: a sealed message, see InnerKind
  Sample,   ///< on a stream's own channel: a sealed sample
};

struct DatagramHeader {
  static constexpr std::size_t bytes = 16;
  DatagramKind kind = DatagramKind::Sealed;
  std::uint16_t reply_port = 0;  ///< UDP port on which the client receives; 0 from a server
  std::uint64_t client = 0;      ///< random number of the connection; 0 in a sample

  void write(std::span<std::byte, bytes> to) const;
  /// Reads the header of a datagram. Returns nullopt for bytes that are not a datagram of gecos.
  static std::optional<DatagramHeader> read(ByteView from);
};

/// The kinds of sealed messages that are sent on the channel of a connection.
enum class InnerKind : std::uint8_t {
  Packet = 1,
  Beat,
  Bye,
  Share,         ///< server: announces a SharedStream; repeated until it is opened
  Opened,        ///< client or server: the sender reads the receiver's stream `number`
  Unshare,       ///< client or server: the sender stops sharing its own stream `number`
  InwardShare,   ///< client: announces an InwardShare; repeated until it is opened
  InwardSample,  ///< client: sample `number` of a stream, with an InwardSampleHead
  Refuse,        ///< server: does not admit the client whose key it knows; the body says why
};

/// The header of every sealed message.
struct InnerHeader {
  static constexpr std::size_t bytes = 17;
  InnerKind kind = InnerKind::Beat;
  std::uint64_t number = 0;
  std::int64_t sent_ns = 0;  ///< send time by the sender's clock, whose origin is arbitrary

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<InnerHeader> read(ByteView from);
};

/// The announcement of a stream from a server to a client: the stream's channel, and the key that
/// decrypts its samples. The announcement is sent sealed.
struct SharedStream {
  static constexpr std::uint16_t most_depth = 1024;
  static constexpr std::size_t bytes = 20 + crypto::StreamKey::bytes;
  std::uint32_t id = 0;
  std::uint32_t largest = 0;
  std::uint16_t depth = 0;
  std::uint16_t port = 0;
  std::uint64_t channel = 0;
  crypto::StreamKey key;

  /// Returns the value of `depth` for a stream that keeps `samples` samples. Throws
  /// std::runtime_error with a text for people when that are more than `most_depth`.
  static std::uint16_t depth_for(std::size_t samples);

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<SharedStream> read(ByteView from);
};

inline constexpr std::size_t stamp_bytes = 8;  ///< size of the time stamp in front of a sample
/// The number of bytes that a datagram has in addition to its packet.
inline constexpr std::size_t packet_overhead =
    DatagramHeader::bytes + crypto::Sealer::overhead + InnerHeader::bytes;
/// The number of bytes that a datagram of a stream has in addition to its sample.
inline constexpr std::size_t sample_overhead =
    DatagramHeader::bytes + crypto::StreamSealer::overhead + stamp_bytes;

/// The message by which a client announces an inward stream to its server. The samples then follow
/// in datagrams that are sealed with the keys of the connection.
struct InwardShare {
  static constexpr std::size_t bytes = 10;
  std::uint32_t id = 0;
  std::uint32_t largest = 0;
  std::uint16_t depth = 0;

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<InwardShare> read(ByteView from);
};

/// The header of a sample that a client sends to its server.
struct InwardSampleHead {
  static constexpr std::size_t bytes = 12;
  std::uint32_t id = 0;
  std::int64_t stamp_ns = 0;

  void write(std::span<std::byte, bytes> to) const;
  /// Reads the header at the start of `from`; the sample follows it. Returns nullopt when `from` is
  /// shorter than the header.
  static std::optional<InwardSampleHead> read(ByteView from);
};

void write_stamp(std::span<std::byte, 8> to, std::int64_t stamp_ns);
/// @pre `from` has 8 bytes.
std::int64_t read_stamp(ByteView from);

/// The address of a server. Its text is for example "lcm:239.255.76.67:20017/GO0123456789abcdef#",
/// followed by the server's key in 64 hex digits. A well-known address has no '#' and no key.
struct SealedAddress {
  std::string medium;
  std::string network;  ///< letters, digits, '.' and '-'; at most 45 characters
  std::uint16_t port = 0;
  std::string channel;  ///< at most 63 characters
  std::optional<crypto::PublicKey> key;

  /// Returns the text of the address without the key.
  std::string place() const;
  std::string to_string() const;
  static std::optional<SealedAddress> parse(std::string_view text);
};

/// Returns the context of a handshake: the name and version of the medium, the address without its
/// key, and the plaintext header of the first message. The context is not sent, because both sides
/// know it.
Bytes handshake_context(const SealedAddress& address, ByteView first_header);

}  // namespace gecos::media
