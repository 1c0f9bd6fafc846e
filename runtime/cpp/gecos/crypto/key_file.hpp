#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "gecos/base/result.hpp"
#include "gecos/crypto/keys.hpp"

/// The format of a key file. The file has one line of three words: the kind of the key, the key (64
/// hex digits) and a checksum (8 hex digits).
namespace gecos::crypto {

inline constexpr std::size_t key_file_bytes = 15 + 64 + 1 + 8 + 1;

/// The text of a key file. The destructor overwrites the text, because the text contains the key,
/// which may be secret.
using KeyText = Secret<key_file_bytes>;

enum class KeyFileKind : std::uint8_t { SecretKey, PublicKey };

KeyText key_file_text(KeyFileKind kind, std::span<const std::byte, key_bytes> key);

/// Returns the key in `text`, the contents of a key file. On failure, returns an error text for
/// users, for example "is cut short".
tl::expected<Secret<key_bytes>, std::string_view> read_key_file(KeyFileKind kind,
                                                                std::span<const std::byte> text);

}  // namespace gecos::crypto
