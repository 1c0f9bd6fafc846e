#pragma once

#include "gecos/crypto/ik.hpp"
#include "gecos/crypto/transport.hpp"

namespace gecos::crypto {

/// The result of a handshake: the peer's key, and the keys of both directions. One thread may use
/// `out` while another thread uses `in`.
struct Channel {
  PublicKey peer;
  Hash binding;  ///< equal on both sides, and unique to this channel
  Sealer out;
  Opener in;

  Channel(const PublicKey& with, const SessionKeys& keys, TimePoint now, RekeyRule rule = {})
      : peer(with), binding(keys.binding), out(keys.send, now, rule), in(keys.receive) {}
};

}  // namespace gecos::crypto
