#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/crypto/secret.hpp"

/// Encryption with ChaCha20-Poly1305. The nonce has the form of the Noise protocol: four zero
/// bytes, then a little-endian counter. No function of this file allocates memory.
namespace gecos::crypto {

inline constexpr std::size_t tag_bytes = 16;

/// Encrypts `text` in place and writes to `tag` the authentication tag of `associated` and `text`.
/// Must never be called twice with the same key and counter.
void aead_seal(const Key& key, std::uint64_t counter, ByteView associated,
               std::span<std::byte> text, std::span<std::byte, tag_bytes> tag);

/// Decrypts `text` in place and returns true. Returns false when `text` was not sealed with these
/// parameters; the contents of `text` are then lost.
[[nodiscard]] bool aead_open(const Key& key, std::uint64_t counter, ByteView associated,
                             std::span<std::byte> text, std::span<const std::byte, tag_bytes> tag);

/// Returns the key that follows `key` (the function REKEY of Noise). Nobody can compute `key` from
/// the next key.
Key next_key(const Key& key);

}  // namespace gecos::crypto
