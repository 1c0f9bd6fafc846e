#pragma once

#include "gecos/crypto/channel.hpp"

namespace gecos::crypto {

/// The client's side of opening a channel.
///
///     auto initiator = HandshakeInitiator::begin(identity, server_key, context, payload);
///     send(initiator->first());   // and repeat it unchanged after 20, 40, 80, then every 160 ms
///     auto opened = initiator->finish(answer, now);   // until it succeeds: use opened->channel
///
/// The same bytes must be repeated, so that the server can answer twice without a second channel.
/// An initiator without an answer after the server's HandshakeRule::answers_kept (5 s) must begin a
/// new handshake.
///
/// `context` is data that both sides know (address, the clear header of the datagram). It is not
/// sent, and a first message is refused in any other context.
class HandshakeInitiator {
 public:
  /// `own` must outlive the initiator. Fails as WeakKey when `server` is not a secure public key.
  static tl::expected<HandshakeInitiator, HandshakeProblem> begin(const Identity& own,
                                                                  const PublicKey& server,
                                                                  ByteView context,
                                                                  ByteView payload);

  const Bytes& first() const { return first_; }

  struct Opened {
    Channel channel;
    Bytes payload;  ///< the server's payload, which was encrypted and authenticated
  };
  /// A forged answer changes nothing; the genuine answer may still arrive.
  tl::expected<Opened, HandshakeProblem> finish(ByteView second, TimePoint now,
                                                RekeyRule rule = {}) const;

 private:
  HandshakeInitiator(IkInitiator handshake, const PublicKey& server, Bytes first);

  IkInitiator handshake_;
  PublicKey server_;
  Bytes first_;
};

}  // namespace gecos::crypto
