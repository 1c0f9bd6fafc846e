#pragma once

#include "gecos/crypto/channel.hpp"

namespace gecos::crypto {

/// A client's side of opening a channel.
///
///     auto opening = Opening::begin(identity, server_key, context, payload);
///     send(opening->first());      // repeated as it is, 20, 40, 80, then 160 ms apart, until
///     auto opened = opening->finish(answer, now);   // succeeds, then `opened->channel` is ready
///
/// Repeating the same bytes is what lets the server answer twice without a second channel. An
/// opening that has no answer after the server's HandshakeRule::answers_kept (5 s) has to begin
/// anew.
///
/// `context` is what both sides know about where they meet (address, the datagram's header in
/// clear); it is not sent, and a first message is worth nothing in any other context.
class Opening {
 public:
  /// `own` must outlive it. WeakKey when `server` is no key that an honest program has.
  static tl::expected<Opening, HandshakeProblem> begin(const Identity& own, const PublicKey& server,
                                                       ByteView context, ByteView payload);

  const Bytes& first() const { return first_; }

  struct Opened {
    Channel channel;
    Bytes payload;  ///< the server's, encrypted and proved
  };
  /// A forged answer changes nothing; the right answer may still arrive.
  tl::expected<Opened, HandshakeProblem> finish(ByteView second, TimePoint now,
                                                RekeyRule rule = {}) const;

 private:
  Opening(IkInitiator handshake, const PublicKey& server, Bytes first);

  IkInitiator handshake_;
  PublicKey server_;
  Bytes first_;
};

}  // namespace gecos::crypto
