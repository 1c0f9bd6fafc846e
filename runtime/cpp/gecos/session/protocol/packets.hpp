// Functions that write packets, each with header and body, into a reused buffer.
#pragma once

#include <optional>
#include <string>

#include "gecos/base/function_ref.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// The value of the flags of a Call packet whose call was sent before in another session. The body
/// begins with a SentBefore: the id of that session, and the counter of the call in that session.
inline constexpr std::int8_t sent_again = 1;
inline constexpr std::size_t sent_before_size = 8 + 8;
struct SentBefore {
  std::uint64_t session = 0;
  std::uint64_t counter = 0;

  void encode(wire::Encoder& to) const { to.put(session, counter); }
  [[nodiscard]] bool decode(wire::Decoder& from) {
    return from.get(session, "session") && from.get(counter, "counter");
  }
};
/// The value of the flags of a Call packet that contains an actor command and whose body begins
/// with a ChainReport (chain_report.hpp).
inline constexpr std::int8_t reports = 2;
/// The value of the flags of a Call packet with an actor command that the program issued after it
/// had stopped the object. Failures of earlier commands then do not matter for this command
/// (server/blend_chain.hpp).
inline constexpr std::int8_t stands_alone = 3;
/// Returns the body of a Cancel packet. `last` is the counter of the newest call that the client
/// had issued at the time of the cancel. Later calls are not canceled.
Bytes cancel_body(std::uint64_t last);
/// Returns the counter in the body of a Cancel packet; the largest number when the body is empty.
std::uint64_t last_canceled(ByteView cancel);
/// The value of the flags of a Goodbye packet after which no call of the session may start. A
/// client sends this packet when it has lost the session, or when a Goodbye without this flag was
/// not acknowledged.
inline constexpr std::int8_t withdraws = 1;
/// The value of the flags of a Goodbye packet from a server that no longer admits the client. The
/// body says why.
inline constexpr std::int8_t revokes = 2;

void write_packet(Bytes& into, const wire::PacketHeader& header, ByteView body);
/// Writes a packet. `encode` writes the body, which takes `size` bytes.
void write_packet(Bytes& into, const wire::PacketHeader& header, std::size_t size,
                  FunctionRef<void(wire::Encoder&)> encode);

/// Writes a packet that ends a call with `failure`.
void write_failure(Bytes& into, wire::PacketHeader header, const Failure& failure);
/// Decodes the packet body that `write_failure` wrote. An unknown detail, or a detail with which a
/// server must not end a call, counts as FAULT.
Failure failure_from(std::optional<Detail> detail, ByteView body);
/// Encodes the reason `why` as the body of a Goodbye packet.
Bytes goodbye_body(const std::string& why);
/// Returns ": " and the reason in the body of a Goodbye packet; an empty text when the body
/// contains no reason.
std::string text_of(ByteView goodbye);

/// Returns the clock of the system. Time-outs of sessions use the clock of the Runtime instead,
/// which tests replace by a fake clock.
const Clock& system_clock();

}  // namespace gecos::session
