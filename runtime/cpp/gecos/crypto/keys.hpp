#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "gecos/base/bytes.hpp"
#include "gecos/crypto/secret.hpp"

/// X25519 keys. They identify the user of a program to its peers over a network that other people
/// can read.
namespace gecos::crypto {

inline constexpr std::size_t key_bytes = 32;

struct PublicKey {
  std::array<std::byte, key_bytes> bytes{};

  auto operator<=>(const PublicKey&) const = default;
  /// Returns the key as 64 hex digits. File names and addresses contain it in this form.
  std::string to_string() const;
  /// Returns the first eight hex digits of the key, for messages to people.
  std::string short_name() const;
  static std::optional<PublicKey> parse(std::string_view hex_digits);
  /// @pre `from` has key_bytes bytes.
  static PublicKey of(ByteView from);
};

struct KeyPair {
  Secret<key_bytes> secret;
  PublicKey public_key;

  static KeyPair draw();
  static KeyPair of(const Secret<key_bytes>& secret);
};

/// The key pair by which other programs recognize a user. The memory of the secret key lies between
/// guard pages and is left out of core dumps. The system does not swap this memory out, as far as
/// its limit on locked memory allows.
class Identity {
 public:
  /// Throws std::bad_alloc when there is no memory for the secret key.
  explicit Identity(const KeyPair& pair);

  const PublicKey& public_key() const { return public_key_; }
  std::span<const std::byte, key_bytes> secret() const;

 private:
  struct Free {
    void operator()(std::byte* memory) const;
  };
  std::unique_ptr<std::byte[], Free> secret_;
  PublicKey public_key_;
};

/// Returns the secret that the owner of the secret key `secret` shares with the owner of the public
/// key `peer`. Returns nothing when `peer` is a weak public key, which would give the same shared
/// secret with every secret key.
std::optional<Key> shared_secret(std::span<const std::byte, key_bytes> secret,
                                 const PublicKey& peer);

}  // namespace gecos::crypto
