#pragma once

#include <cassert>
#include <concepts>

#include "gecos/wire/contents.hpp"

namespace gecos::wire {

/// A type whose values encode themselves but which has no fingerprint, because no interface
/// declares it. Such types hold the arguments or the result of a call.
template <class T>
concept Encodable = std::default_initializable<T> &&
    requires(const T& value, T& target, Encoder& encoder, Decoder& decoder) {
  { value.encoded_size() } -> std::same_as<std::size_t>;
  { value.encode(encoder) } -> std::same_as<void>;
  { target.decode(decoder) } -> std::same_as<bool>;
};

template <Encodable T>
Bytes encoded(const T& value) {
  Bytes bytes(value.encoded_size());
  Encoder encoder(bytes);
  value.encode(encoder);
  assert(encoder.written() == bytes.size());
  return bytes;
}

/// Decodes the result of `encoded`. Fails if bytes are left over.
template <Encodable T>
tl::expected<T, DecodeError> decoded(ByteView bytes) {
  tl::expected<T, DecodeError> result;
  Decoder decoder(bytes);
  if (!result->decode(decoder) || !decoder.expect_end()) {
    return tl::make_unexpected(decoder.error());
  }
  return result;
}

}  // namespace gecos::wire
