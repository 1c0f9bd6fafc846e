// The concept GeneralContents: types whose values encode themselves. Such types are generated or
// written by hand.
#pragma once

#include <array>
#include <cassert>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>

#include "gecos/base/bytes.hpp"
#include "gecos/base/result.hpp"
#include "gecos/wire/decoder.hpp"
#include "gecos/wire/encoder.hpp"

namespace gecos::wire {

/// A type whose values encode themselves. `encode` writes the fields, which take exactly
/// `encoded_size()` bytes. `decode` reads and validates the fields. `fingerprint` returns the value
/// that lcm-gen computes for the declared layout of the type.
template <typename T>
concept GeneralContents = std::default_initializable<T> &&
    requires(const T& value, T& target, Encoder& encoder, Decoder& decoder) {
  { value.encoded_size() } -> std::same_as<std::size_t>;
  { value.encode(encoder) } -> std::same_as<void>;
  { target.decode(decoder) } -> std::same_as<bool>;
  { T::fingerprint() } -> std::same_as<std::int64_t>;
};

/// Returns an error text that says why `value` must not be sent. The text is empty when the value
/// may be sent, and for types without checks.
template <class T>
std::string violation_of([[maybe_unused]] const T& value) {
  if constexpr (requires { gecos_violation(value); }) {
    return gecos_violation(value);
  } else {
    return {};
  }
}

/// Returns the encoded size in bytes of a number, or of a value that encodes itself.
template <class T>
std::size_t plain_size(const T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    return sizeof value;
  } else {
    return value.encoded_size();
  }
}
template <class T>
void put_plain(Encoder& to, const T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    to.put(value);
  } else {
    value.encode(to);
  }
}

/// Writes an appendable value as a block: first the encoded size of the value, then its fields.
/// `size` is the encoded size.
template <class T>
void put_block(Encoder& to, const T& value, std::size_t size) {
  to.put_count(size);
  value.encode(to);
}

/// A value that converts to an array of any size, or to an array of arrays. Every element of the
/// array equals `value`.
template <class T>
struct Everywhere {
  T value;

  template <class Element, std::size_t size>
  constexpr operator std::array<Element, size>() const {
    std::array<Element, size> all{};
    if constexpr (std::is_same_v<Element, T>) {
      all.fill(value);
    } else {
      all.fill(*this);
    }
    return all;
  }
};
template <class T>
Everywhere(T) -> Everywhere<T>;

inline constexpr std::size_t fingerprint_size = 8;

/// Returns the encoded fields of `value`, without the fingerprint.
template <GeneralContents T>
Bytes to_bytes(const T& value) {
  Bytes bytes(value.encoded_size());
  Encoder encoder(bytes);
  value.encode(encoder);
  assert(encoder.written() == bytes.size());
  return bytes;
}

/// Decodes the result of `to_bytes`. Fails if bytes are left over.
template <GeneralContents T>
tl::expected<T, DecodeError> from_bytes(ByteView bytes) {
  tl::expected<T, DecodeError> result;
  Decoder decoder(bytes);
  if (!result->decode(decoder) || !decoder.expect_end()) {
    return tl::make_unexpected(decoder.error());
  }
  return result;
}

/// Returns `value` as an LCM message: the fingerprint of the type, then the encoded fields.
template <GeneralContents T>
Bytes to_message(const T& value) {
  Bytes bytes(fingerprint_size + value.encoded_size());
  Encoder encoder(bytes);
  encoder.put(T::fingerprint());
  value.encode(encoder);
  assert(encoder.written() == bytes.size());
  return bytes;
}

/// Decodes the result of `to_message`. Fails with WrongFingerprint for a message of another type.
template <GeneralContents T>
tl::expected<T, DecodeError> from_message(ByteView message) {
  tl::expected<T, DecodeError> result;
  Decoder decoder(message);
  std::int64_t fingerprint = 0;
  const bool decoded =
      decoder.get(fingerprint) &&
      (fingerprint == T::fingerprint() || decoder.fail(DecodeProblem::WrongFingerprint, "", 0)) &&
      result->decode(decoder) && decoder.expect_end();
  if (!decoded) return tl::make_unexpected(decoder.error());
  return result;
}

}  // namespace gecos::wire
