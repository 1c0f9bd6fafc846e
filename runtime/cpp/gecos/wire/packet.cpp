#include "gecos/wire/packet.hpp"

#include <cassert>
#include <limits>

#include "gecos/wire/decoder.hpp"
#include "gecos/wire/encoder.hpp"

namespace gecos::wire {
namespace {

bool decode_header(Decoder& in, PacketHeader& header) {
  std::int8_t kind = 0;
  std::int8_t reserved = 0;
  std::uint32_t code = 0;
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::int64_t deadline = 0;
  if (!in.get(header.version, "version") || !in.get(kind, "kind") ||
      !in.get(header.flags, "flags") || !in.get(reserved, "reserved") || !in.get(code, "code") ||
      !in.get(session, "session") || !in.get(header.counter, "counter") ||
      !in.get(header.acknowledged, "acknowledged") || !in.get(epoch, "epoch")) {
    return false;
  }
  const std::size_t deadline_offset = in.offset();
  if (!in.get(deadline, "deadline_ns")) return false;
  if (deadline < 0) return in.fail(DecodeProblem::OutOfRange, "deadline_ns", deadline_offset);
  header.kind = PacketKind{kind};
  header.code = FunctionCode{code};
  header.session = SessionId{session};
  header.epoch = Epoch{epoch};
  header.deadline = Duration{deadline};
  return true;
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
  PacketView packet;
  Decoder in(bytes);
  std::int64_t fingerprint = 0;
  const bool decoded =
      in.get(fingerprint) &&
      (fingerprint == packet_fingerprint || in.fail(DecodeProblem::WrongFingerprint, "", 0)) &&
      decode_header(in, packet.header) && get_counted(in, packet.body, "body_n", "body") &&
      get_counted(in, packet.tag, "tag_n", "tag") && in.expect_end();
  if (!decoded) return tl::make_unexpected(in.error());
  return packet;
}

}  // namespace gecos::wire
