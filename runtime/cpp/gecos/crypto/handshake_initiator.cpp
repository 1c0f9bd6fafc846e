#include "gecos/crypto/handshake_initiator.hpp"

#include <utility>

namespace gecos::crypto {

HandshakeInitiator::HandshakeInitiator(IkInitiator handshake, const PublicKey& server, Bytes first)
    : handshake_(std::move(handshake)), server_(server), first_(std::move(first)) {}

tl::expected<HandshakeInitiator, HandshakeProblem> HandshakeInitiator::begin(
    const Identity& own, const PublicKey& server, ByteView context, ByteView payload) {
  IkInitiator handshake(own, server, context);
  auto first = handshake.write_first(payload);
  if (!first) return tl::unexpected(first.error());
  return HandshakeInitiator(std::move(handshake), server, std::move(*first));
}

tl::expected<HandshakeInitiator::Opened, HandshakeProblem> HandshakeInitiator::finish(
    ByteView second, TimePoint now, RekeyRule rule) const {
  auto finished = handshake_.read_second(second);
  if (!finished) return tl::unexpected(finished.error());
  return Opened{Channel(server_, finished->keys, now, rule), std::move(finished->payload)};
}

}  // namespace gecos::crypto
