#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/crypto/secret.hpp"

/// ChaCha20-Poly1305 with the nonce of Noise: four zero bytes, then a counter, little-endian. No
/// function here allocates.
namespace gecos::crypto {

inline constexpr std::size_t tag_bytes = 16;

/// Encrypts `text` in place and writes the tag of `associated` and `text`. Must never be called
/// twice with the same key and counter.
void aead_seal(const Key& key, std::uint64_t counter, ByteView associated,
               std::span<std::byte> text, std::span<std::byte, tag_bytes> tag);

/// Decrypts `text` in place. False, and `text` is destroyed, when it was not sealed with these
/// parameters.
[[nodiscard]] bool aead_open(const Key& key, std::uint64_t counter, ByteView associated,
                             std::span<std::byte> text, std::span<const std::byte, tag_bytes> tag);

/// Noise's REKEY: the next key, from which `key` cannot be computed.
Key next_key(const Key& key);

}  // namespace gecos::crypto
