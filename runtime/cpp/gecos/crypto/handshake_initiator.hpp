#pragma once

#include "gecos/crypto/channel.hpp"

namespace gecos::crypto {

/// A client's side of opening a channel.
///
///     auto initiator = HandshakeInitiator::begin(identity, server_key, context, payload);
///     send(initiator->first());      // repeated as it is, 20, 40, 80, then 160 ms apart, until
///     auto opened = initiator->finish(answer, now);   // succeeds, then `opened->channel` is ready
///
/// Repeating the same bytes is what lets the server answer twice without a second channel. An
/// initiator that has no answer after the server's HandshakeRule::answers_kept (5 s) has to begin
/// anew.
///
/// `context` is what both sides know about where they meet (address, the datagram's header in
/// clear); it is not sent, and a first message is worth nothing in any other context.
class HandshakeInitiator {
 public:
  /// `own` must outlive it. WeakKey when `server` is no key that an honest program has.
  static tl::expected<HandshakeInitiator, HandshakeProblem> begin(const Identity& own,
                                                                  const PublicKey& server,
                                                                  ByteView context,
                                                                  ByteView payload);

  const Bytes& first() const { return first_; }

  struct Opened {
    Channel channel;
    Bytes payload;  ///< the server's, encrypted and proved
  };
  /// A forged answer changes nothing; the right answer may still arrive.
  tl::expected<Opened, HandshakeProblem> finish(ByteView second, TimePoint now,
                                                RekeyRule rule = {}) const;

 private:
  HandshakeInitiator(IkInitiator handshake, const PublicKey& server, Bytes first);

  IkInitiator handshake_;
  PublicKey server_;
  Bytes first_;
};

}  // namespace gecos::crypto
