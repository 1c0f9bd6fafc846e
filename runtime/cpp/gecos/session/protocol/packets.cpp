#include "gecos/session/protocol/packets.hpp"

#include <limits>

#include "gecos/session/protocol/handshake.hpp"

namespace gecos::session {
namespace {

void frame(Bytes& into, const wire::PacketHeader& header, std::size_t size) {
  into.resize(wire::packet_size(size));
  const std::span<std::byte> bytes(into);
  wire::encode_packet_head(bytes.first<wire::packet_head_size>(), header, size);
  wire::encode_packet_tail(bytes.last<wire::packet_tail_size>(), 0);
}

/// Returns whether a server may end a call with `detail`. Only clients end a call with the other
/// details. The state CONNECTION_FAILED may come from a server only if the server has not started
/// the call, because the client may then send the call again.
bool ends_a_call(Detail detail) {
  switch (detail) {
    case Detail::ServerCrashed:
    case Detail::NoServer:
    case Detail::Refused:
    case Detail::QosUnavailable:
      return false;
    default:
      return detail > Detail::Done;
  }
}

}  // namespace

void write_packet(Bytes& into, const wire::PacketHeader& header, ByteView body) {
  write_packet(into, header, body.size(), [&](wire::Encoder& to) { to.put_bytes(body); });
}

void write_packet(Bytes& into, const wire::PacketHeader& header, std::size_t size,
                  FunctionRef<void(wire::Encoder&)> encode) {
  frame(into, header, size);
  wire::Encoder to(std::span<std::byte>(into).subspan(wire::packet_head_size, size));
  encode(to);
}

Bytes cancel_body(std::uint64_t last) {
  Bytes body(sizeof last);
  wire::Encoder(body).put(last);
  return body;
}

std::uint64_t last_canceled(ByteView cancel) {
  std::uint64_t last = 0;
  wire::Decoder from(cancel);
  return from.get(last, "last call") ? last : std::numeric_limits<std::uint64_t>::max();
}

void write_failure(Bytes& into, wire::PacketHeader header, const Failure& failure) {
  header.flags = static_cast<std::int8_t>(failure.detail);
  const FailureBody body{failure.text, failure.exception, failure.evidence};
  write_packet(into, header, body.encoded_size(), [&](wire::Encoder& to) { body.encode(to); });
}

Failure failure_from(std::optional<Detail> detail, ByteView body) {
  auto decoded = wire::from_bytes<FailureBody>(body);
  if (!decoded) {
    return {Detail::Fault, "the reply does not decode: " + decoded.error().message(), {}, {}};
  }
  Failure failure{Detail::Fault, std::move(decoded->text), std::move(decoded->exception),
                  std::move(decoded->evidence)};
  if (detail && ends_a_call(*detail)) failure.detail = *detail;
  return failure;
}

Bytes goodbye_body(const std::string& why) {
  Bytes body(wire::string_size(why));
  wire::Encoder(body).put_string(why);
  return body;
}

std::string text_of(ByteView goodbye) {
  wire::Decoder from(goodbye);
  std::string text;
  if (goodbye.empty() || !from.get_string(text) || text.empty()) return {};
  return ": " + text;
}

const Clock& system_clock() {
  static const SystemClock clock;
  return clock;
}

}  // namespace gecos::session
