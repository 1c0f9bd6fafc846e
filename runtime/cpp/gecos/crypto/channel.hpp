#pragma once

#include "gecos/crypto/ik.hpp"
#include "gecos/crypto/transport.hpp"

namespace gecos::crypto {

/// Result of a handshake: both directions and the peer's key. One thread may use `out` while
/// another uses `in`.
struct Channel {
  PublicKey peer;
  Hash binding;  ///< equal on both sides, and unique to this channel
  Sealer out;
  Opener in;

  Channel(const PublicKey& with, const SessionKeys& keys, TimePoint now, RekeyRule rule = {})
      : peer(with), binding(keys.binding), out(keys.send, now, rule), in(keys.receive) {}
};

}  // namespace gecos::crypto
