#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "gecos/base/bytes.hpp"

/// What is in a datagram of the lcm medium: a header of 32 bytes, big-endian, then the packet.
/// Pure: bytes in, bytes out.
namespace gecos::media {

enum class DatagramKind : std::uint8_t {
  Hello = 1,  ///< client: I am here
  Welcome,    ///< server: so am I
  Packet,
  Beat,
  Bye,
  Share,    ///< server: a SharedStream, until it was opened
  Opened,   ///< client: stream `number` is being read
  Unshare,  ///< server: stream `number` ends for you
  Sample,   ///< on a stream's own channel: stamp (8 bytes), then the sample `number`
};

struct DatagramHeader {
  static constexpr std::size_t bytes = 32;
  DatagramKind kind = DatagramKind::Beat;
  std::uint16_t reply_port = 0;  ///< where the client listens
  std::uint64_t server = 0;      ///< which life of the server; 0: the client has heard none yet
  std::uint64_t client = 0;
  std::uint64_t number = 0;

  void write(std::span<std::byte, bytes> to) const;
  /// Nothing for bytes that are no datagram of ours.
  static std::optional<DatagramHeader> read(ByteView from);
};

/// Where a shared stream is to be heard.
struct SharedStream {
  static constexpr std::size_t bytes = 20;
  std::uint32_t id = 0;
  std::uint32_t largest = 0;
  std::uint16_t depth = 0;
  std::uint16_t port = 0;
  std::uint64_t channel = 0;

  void write(std::span<std::byte, bytes> to) const;
  static std::optional<SharedStream> read(ByteView from);
};

void write_stamp(std::span<std::byte, 8> to, std::int64_t stamp_ns);
/// @pre `from` has 8 bytes.
std::int64_t read_stamp(ByteView from);

/// An address of this medium: "lcm:239.255.76.67:20017/GO0123456789abcdef".
struct LcmAddress {
  std::string group;
  std::uint16_t port = 0;
  std::string channel;  ///< at most 63 characters, as LCM has it

  std::string to_string() const;
  static std::optional<LcmAddress> parse(std::string_view text);
};

}  // namespace gecos::media
