#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "gecos/base/bytes.hpp"
#include "gecos/crypto/aead.hpp"
#include "gecos/crypto/secret.hpp"

namespace gecos::crypto {

using Hash = std::array<std::byte, 32>;

/// The SymmetricState of the Noise protocol (revision 34, section 5.2) with ChaChaPoly and SHA256.
/// Each side mixes in the data of the handshake in the same order. Two sides that mixed in the same
/// data have the same keys.
class SymmetricState {
 public:
  explicit SymmetricState(std::string_view protocol_name);

  void mix_hash(ByteView data);
  void mix_key(const Key& input);
  /// Encrypts `text` and writes it, followed by a tag, to `to`. @pre `to` is tag_bytes longer than
  /// `text`, and mix_key() was called.
  void encrypt_and_hash(ByteView text, std::span<std::byte> to);
  /// Decrypts `sealed` into `to`. Returns false when `sealed` is forged; the caller must then
  /// discard this state. @pre `sealed` is tag_bytes longer than `to`, and mix_key() was called.
  [[nodiscard]] bool decrypt_and_hash(ByteView sealed, std::span<std::byte> to);

  /// Returns two keys after the handshake: the key for the initiator's messages, then the key for
  /// the responder's messages.
  std::pair<Key, Key> split() const;
  const Hash& hash() const { return hash_; }

 private:
  Key chaining_;
  Hash hash_{};
  Key key_;
  std::uint64_t counter_ = 0;
};

}  // namespace gecos::crypto
