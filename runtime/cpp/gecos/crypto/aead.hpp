#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/crypto/secret.hpp"

/// ChaCha20-Poly1305 with a counter for a nonce, as Noise has it: four zero bytes, then the
/// counter, little-endian. Nothing here allocates.
namespace gecos::crypto {

inline constexpr std::size_t tag_bytes = 16;

/// Encrypts `text` where it stands and writes the tag over both. Never twice with one counter.
void aead_seal(const Key& key, std::uint64_t counter, ByteView associated,
               std::span<std::byte> text, std::span<std::byte, tag_bytes> tag);

/// Decrypts `text` where it stands; false, and `text` is lost, when it was not sealed so.
[[nodiscard]] bool aead_open(const Key& key, std::uint64_t counter, ByteView associated,
                             std::span<std::byte> text, std::span<const std::byte, tag_bytes> tag);

/// Noise's REKEY: the next key, from which this one cannot be found.
Key next_key(const Key& key);

}  // namespace gecos::crypto
