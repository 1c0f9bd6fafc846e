#include "gecos/media/sealed/datagram.hpp"

#include <algorithm>
#include <charconv>
#include <stdexcept>
#include <string>

namespace gecos::media {
namespace {

constexpr std::uint16_t magic = 0x6763;
constexpr std::uint8_t version = 2;
constexpr std::size_t longest_medium = 16;
constexpr std::size_t longest_channel = 63;
constexpr std::size_t longest_network = 45;  // maximum length of an IPv6 address as text

template <class T>
void put(std::byte* to, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    to[i] = static_cast<std::byte>(value >> (8 * (sizeof(T) - 1 - i)));
  }
}

template <class T>
T get(const std::byte* from) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value = value << 8 | std::to_integer<std::uint64_t>(from[i]);
  }
  return static_cast<T>(value);
}

}  // namespace

void DatagramHeader::write(std::span<std::byte, bytes> to) const {
  put<std::uint16_t>(&to[0], magic);
  to[2] = std::byte{version};
  to[3] = static_cast<std::byte>(kind);
  put<std::uint16_t>(&to[4], reply_port);
  put<std::uint16_t>(&to[6], 0);
  put<std::uint64_t>(&to[8], client);
}

std::optional<DatagramHeader> DatagramHeader::read(ByteView from) {
  if (from.size() < bytes || get<std::uint16_t>(&from[0]) != magic ||
      from[2] != std::byte{version}) {
    return std::nullopt;
  }
  const auto kind = std::to_integer<std::uint8_t>(from[3]);
  if (kind < static_cast<std::uint8_t>(DatagramKind::Ask) ||
      kind > static_cast<std::uint8_t>(DatagramKind::Sample)) {
    return std::nullopt;
  }
  return DatagramHeader{static_cast<DatagramKind>(kind), get<std::uint16_t>(&from[4]),
                        get<std::uint64_t>(&from[8])};
}

void InnerHeader::write(std::span<std::byte, bytes> to) const {
  to[0] = static_cast<std::byte>(kind);
  put<std::uint64_t>(&to[1], number);
  put<std::uint64_t>(&to[9], static_cast<std::uint64_t>(sent_ns));
}

std::optional<InnerHeader> InnerHeader::read(ByteView from) {
  if (from.size() < bytes) return std::nullopt;
  const auto kind = std::to_integer<std::uint8_t>(from[0]);
  if (kind < static_cast<std::uint8_t>(InnerKind::Packet) ||
      kind > static_cast<std::uint8_t>(InnerKind::Refuse)) {
    return std::nullopt;
  }
  return InnerHeader{static_cast<InnerKind>(kind), get<std::uint64_t>(&from[1]),
                     get<std::int64_t>(&from[9])};
}

void SharedStream::write(std::span<std::byte, bytes> to) const {
  put<std::uint32_t>(&to[0], id);
  put<std::uint32_t>(&to[4], largest);
  put<std::uint16_t>(&to[8], depth);
  put<std::uint16_t>(&to[10], port);
  put<std::uint64_t>(&to[12], channel);
  key.write(to.last<crypto::StreamKey::bytes>());
}

std::uint16_t SharedStream::depth_for(std::size_t samples) {
  if (samples > most_depth) {
    throw std::runtime_error(
        "this medium keeps at most " + std::to_string(most_depth) +
        " samples of a stream, and the interface asks for depth=" + std::to_string(samples) +
        "; use the stream on the host of its server, or reduce the depth");
  }
  return static_cast<std::uint16_t>(std::max<std::size_t>(samples, 1));
}

std::optional<SharedStream> SharedStream::read(ByteView from) {
  if (from.size() != bytes) return std::nullopt;
  SharedStream stream;
  stream.id = get<std::uint32_t>(&from[0]);
  stream.largest = get<std::uint32_t>(&from[4]);
  stream.depth = get<std::uint16_t>(&from[8]);
  stream.port = get<std::uint16_t>(&from[10]);
  stream.channel = get<std::uint64_t>(&from[12]);
  stream.key = crypto::StreamKey::read(from.last<crypto::StreamKey::bytes>());
  if (stream.depth == 0 || stream.depth > SharedStream::most_depth || stream.port == 0) {
    return std::nullopt;
  }
  return stream;
}

void InwardShare::write(std::span<std::byte, bytes> to) const {
  put<std::uint32_t>(&to[0], id);
  put<std::uint32_t>(&to[4], largest);
  put<std::uint16_t>(&to[8], depth);
}

std::optional<InwardShare> InwardShare::read(ByteView from) {
  if (from.size() != bytes) return std::nullopt;
  const InwardShare share{get<std::uint32_t>(&from[0]), get<std::uint32_t>(&from[4]),
                          get<std::uint16_t>(&from[8])};
  if (share.depth == 0 || share.depth > SharedStream::most_depth) return std::nullopt;
  return share;
}

void InwardSampleHead::write(std::span<std::byte, bytes> to) const {
  put<std::uint32_t>(&to[0], id);
  put<std::uint64_t>(&to[4], static_cast<std::uint64_t>(stamp_ns));
}

std::optional<InwardSampleHead> InwardSampleHead::read(ByteView from) {
  if (from.size() < bytes) return std::nullopt;
  return InwardSampleHead{get<std::uint32_t>(&from[0]), get<std::int64_t>(&from[4])};
}

void write_stamp(std::span<std::byte, 8> to, std::int64_t stamp_ns) {
  put<std::uint64_t>(to.data(), static_cast<std::uint64_t>(stamp_ns));
}

std::int64_t read_stamp(ByteView from) { return get<std::int64_t>(from.data()); }

std::string SealedAddress::place() const {
  return medium + ":" + network + ":" + std::to_string(port) + "/" + channel;
}

std::string SealedAddress::to_string() const {
  return key ? place() + "#" + key->to_string() : place();
}

std::optional<SealedAddress> SealedAddress::parse(std::string_view text) {
  SealedAddress address;
  const std::size_t named = text.find(':');
  if (named == std::string_view::npos) return std::nullopt;
  address.medium = text.substr(0, named);
  text.remove_prefix(named + 1);
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const std::size_t colon = text.substr(0, slash).rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  address.network = text.substr(0, colon);
  const std::string_view end_of_place = text.substr(slash + 1);
  const std::size_t hash = end_of_place.find('#');
  address.channel = end_of_place.substr(0, hash);
  if (hash != std::string_view::npos) {
    address.key = crypto::PublicKey::parse(end_of_place.substr(hash + 1));
    if (!address.key) return std::nullopt;
  }
  const auto plain = [](const std::string& word, std::size_t longest) {
    return !word.empty() && word.size() <= longest && std::ranges::all_of(word, [](char c) {
      return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
             c == '.' || c == '-';
    });
  };
  const std::string_view port = text.substr(colon + 1, slash - colon - 1);
  const auto [end, problem] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  if (!plain(address.medium, longest_medium) || !plain(address.network, longest_network) ||
      problem != std::errc{} || end != port.data() + port.size() || address.port == 0 ||
      address.channel.empty() || address.channel.size() > longest_channel) {
    return std::nullopt;
  }
  return address;
}

Bytes handshake_context(const SealedAddress& address, ByteView first_header) {
  Bytes context;
  const std::string name = "gecos " + address.medium + " " + std::to_string(version);
  const std::string place = address.place();
  for (const ByteView part :
       {std::as_bytes(std::span(name)), std::as_bytes(std::span(place)), first_header}) {
    context.insert(context.end(), part.begin(), part.end());
  }
  return context;
}

}  // namespace gecos::media
