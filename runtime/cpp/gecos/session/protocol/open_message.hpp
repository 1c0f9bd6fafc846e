#pragma once

#include <algorithm>
#include <cstdint>

#include "gecos/base/bytes.hpp"
#include "gecos/wire/encoder.hpp"

namespace gecos::session {

/// Makes `message` the LCM message of a sample of an open stream: the fingerprint of the sample's
/// type, then the sample. Allocates no memory if `message` had this size before.
inline void write_open_message(Bytes& message, std::uint64_t fingerprint, ByteView sample) {
  message.resize(sizeof fingerprint + sample.size());
  wire::Encoder(message).put(static_cast<std::int64_t>(fingerprint));
  std::ranges::copy(sample, message.begin() + sizeof fingerprint);
}

}  // namespace gecos::session
