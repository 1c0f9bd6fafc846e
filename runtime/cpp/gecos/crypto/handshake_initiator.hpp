#pragma once

#include "gecos/crypto/channel.hpp"

namespace gecos::crypto {

/// The client's side of the handshake that opens a channel. It is used like this:
///
///     auto initiator = HandshakeInitiator::begin(identity, server_key, context, payload);
///     send(initiator->first());   // and repeat it unchanged after 20, 40, 80, then every 160 ms
///     auto opened = initiator->finish(answer, now);   // until it succeeds: use opened->channel
///
/// The client must repeat the first message with the same bytes, so that the server can answer it
/// again without opening a second channel. A client that has no answer after the server's
/// HandshakeRule::answers_kept (5 s) must begin a new handshake.
///
/// `context` is data that both sides know, such as the address and the unencrypted header of the
/// datagram. The context is not sent. The server refuses a first message that was made for another
/// context.
class HandshakeInitiator {
 public:
  /// Begins a handshake with the server that has the public key `server`. `own` must outlive the
  /// initiator. Fails with WeakKey when `server` is not a secure public key.
  static tl::expected<HandshakeInitiator, HandshakeProblem> begin(const Identity& own,
                                                                  const PublicKey& server,
                                                                  ByteView context,
                                                                  ByteView payload);

  const Bytes& first() const { return first_; }

  struct Opened {
    Channel channel;
    Bytes payload;  ///< the server's payload, which was encrypted and authenticated
  };
  /// Opens the channel by the server's answer `second`. Fails and changes nothing when the answer
  /// is forged; the genuine answer may still arrive.
  tl::expected<Opened, HandshakeProblem> finish(ByteView second, TimePoint now,
                                                RekeyRule rule = {}) const;

 private:
  HandshakeInitiator(IkInitiator handshake, const PublicKey& server, Bytes first);

  IkInitiator handshake_;
  PublicKey server_;
  Bytes first_;
};

}  // namespace gecos::crypto
