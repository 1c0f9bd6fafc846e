#include "gecos/wire/packet.hpp"

#include <array>
#include <cassert>

#include "gecos/wire/contents.hpp"
#include "gecos/wire/decoder.hpp"
#include "gecos/wire/encoder.hpp"

namespace gecos::wire {
namespace {

struct HeadField {
  const char* name;
  std::size_t size;
};

// The fields of the head of a packet in their order, up to the field body_n.
constexpr std::array<HeadField, 11> head_fields{{{"", fingerprint_size},
                                                 {"version", 1},
                                                 {"kind", 1},
                                                 {"flags", 1},
                                                 {"reserved", 1},
                                                 {"code", 4},
                                                 {"session", 8},
                                                 {"counter", 8},
                                                 {"acknowledged", 8},
                                                 {"epoch", 8},
                                                 {"deadline_ns", 8}}};
constexpr std::size_t deadline_offset = packet_head_size - 4 - 8;

/// Records that a packet has only `size` bytes, fewer than the head of a packet. The error names
/// the first field of the head that is missing or cut off.
bool refuse_short_head(Decoder& in, std::size_t size) {
  std::size_t offset = 0;
  for (const HeadField& field : head_fields) {
    if (offset + field.size > size) return in.fail(DecodeProblem::Truncated, field.name, offset);
    offset += field.size;
  }
  return false;  // not reached: a short head ends inside a field
}

/// Decodes the header of a packet. Checks the size only once and then loads the fields from fixed
/// offsets, because every call decodes a header.
bool decode_header(Decoder& in, PacketHeader& header) {
  constexpr std::size_t size = packet_head_size - 4;
  if (in.remaining() < size) return refuse_short_head(in, in.remaining());
  ByteView head;
  if (!in.get_view(head, size)) return false;
  const std::byte* at = head.data();
  const auto take = [&at]<typename T>(T) {
    const T value = load_big_endian<T>(at);
    at += sizeof(T);
    return value;
  };
  if (take(packet_fingerprint) != packet_fingerprint) {
    return in.fail(DecodeProblem::WrongFingerprint, "", 0);
  }
  header.version = take(std::int8_t{});
  header.kind = PacketKind{take(std::int8_t{})};
  header.flags = take(std::int8_t{});
  take(std::int8_t{});  // reserved
  header.code = FunctionCode{take(std::uint32_t{})};
  header.session = SessionId{take(std::uint64_t{})};
  header.counter = take(std::uint64_t{});
  header.acknowledged = take(std::uint64_t{});
  header.epoch = Epoch{take(std::uint64_t{})};
  header.deadline = Duration{take(std::int64_t{})};
  return header.deadline >= Duration::zero() ||
         in.fail(DecodeProblem::OutOfRange, "deadline_ns", deadline_offset);
}

bool get_counted(Decoder& in, ByteView& bytes, const char* count_name, const char* name) {
  std::size_t count = 0;
  return in.get_count(count, 1, npos, count_name) && in.get_view(bytes, count, name);
}

}  // namespace

void encode_packet_head(std::span<std::byte, packet_head_size> to, const PacketHeader& header,
                        std::size_t body_size) {
  assert(header.deadline >= Duration::zero());
  Encoder out(to);
  out.put(packet_fingerprint);
  out.put(header.version);
  out.put(static_cast<std::int8_t>(header.kind));
  out.put(header.flags);
  out.put(std::int8_t{0});  // reserved
  out.put(number(header.code));
  out.put(number(header.session));
  out.put(header.counter);
  out.put(header.acknowledged);
  out.put(number(header.epoch));
  out.put(std::int64_t{header.deadline.count()});
  out.put_count(body_size);
  assert(out.written() == packet_head_size);
}

void write_deadline(std::span<std::byte> packet, Duration left) {
  assert(packet.size() >= packet_head_size && left >= Duration::zero());
  Encoder(packet.subspan(deadline_offset, 8)).put(std::int64_t{left.count()});
}

void encode_packet_tail(std::span<std::byte, packet_tail_size> to, std::size_t tag_size) {
  Encoder(to).put_count(tag_size);
}

Bytes encode_packet(const PacketHeader& header, ByteView body, ByteView tag) {
  Bytes bytes(packet_size(body.size(), tag.size()));
  const std::span<std::byte> all(bytes);
  encode_packet_head(all.first<packet_head_size>(), header, body.size());
  Encoder rest(all.subspan(packet_head_size));
  rest.put_bytes(body);
  rest.put_count(tag.size());
  rest.put_bytes(tag);
  return bytes;
}

tl::expected<PacketView, DecodeError> decode_packet(ByteView bytes) {
  tl::expected<PacketView, DecodeError> result;
  PacketView& packet = *result;
  Decoder in(bytes);
  const bool decoded = decode_header(in, packet.header) &&
                       get_counted(in, packet.body, "body_n", "body") &&
                       get_counted(in, packet.tag, "tag_n", "tag") && in.expect_end();
  if (!decoded) result = tl::make_unexpected(in.error());
  return result;
}

}  // namespace gecos::wire
