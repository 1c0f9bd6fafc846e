#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "gecos/base/result.hpp"
#include "gecos/crypto/keys.hpp"

/// Contents of a key file: one line of a word, the key (64 hex digits) and a checksum (8 hex
/// digits).
namespace gecos::crypto {

inline constexpr std::size_t key_file_bytes = 15 + 64 + 1 + 8 + 1;

/// The text of a key file. Wipes itself: the text of a secret key is as secret as the key.
using KeyText = Secret<key_file_bytes>;

enum class KeyFileKind : std::uint8_t { SecretKey, PublicKey };

KeyText key_file_text(KeyFileKind kind, std::span<const std::byte, key_bytes> key);

/// The key in `text`, or the error as a text for users: "is cut short".
tl::expected<Secret<key_bytes>, std::string_view> read_key_file(KeyFileKind kind,
                                                                std::span<const std::byte> text);

}  // namespace gecos::crypto
