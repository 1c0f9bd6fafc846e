// Packets as the session writes them: head and body one after the other, in one reused buffer.
#pragma once

#include <optional>
#include <string>

#include "gecos/base/function_ref.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Flags of a Call whose body begins with the session and counter that it was sent under before.
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
/// Flags of a Goodbye after which no call of the session may start: its client got no answer to a
/// Goodbye without this flag.
inline constexpr std::int8_t withdraws = 1;

void write_packet(Bytes& into, const wire::PacketHeader& header, ByteView body);
/// As above, with a body of `size` bytes that `encode` writes.
void write_packet(Bytes& into, const wire::PacketHeader& header, std::size_t size,
                  FunctionRef<void(wire::Encoder&)> encode);

/// The terminal outcome of a call as a packet.
void write_failure(Bytes& into, wire::PacketHeader header, const Failure& failure);
/// Decodes what `write_failure` wrote. A detail that is unknown, or with which a server must not
/// end a call, counts as FAULT.
Failure failure_from(std::optional<Detail> detail, ByteView body);
/// The body of a Goodbye that gives a reason.
Bytes goodbye_body(const std::string& why);
/// ": why", from the body of a Goodbye; empty when it gives no reason.
std::string text_of(ByteView goodbye);

/// The clock of real waits; policies use the lab's clock.
const Clock& system_clock();

}  // namespace gecos::session
