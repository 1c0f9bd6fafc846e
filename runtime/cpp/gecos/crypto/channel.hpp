#pragma once

#include "gecos/crypto/ik.hpp"
#include "gecos/crypto/transport.hpp"

namespace gecos::crypto {

/// Result of a handshake: both directions and the peer's key. The two halves may be used
/// by one thread each.
struct Channel {
  PublicKey peer;
  Hash binding;  ///< the same on both sides, and of this channel alone
  Sealer out;
  Opener in;

  Channel(const PublicKey& with, const SessionKeys& keys, TimePoint now, RekeyRule rule = {})
      : peer(with), binding(keys.binding), out(keys.send, now, rule), in(keys.receive) {}
};

}  // namespace gecos::crypto
