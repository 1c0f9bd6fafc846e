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

/// Noise's SymmetricState (revision 34, section 5.2) with ChaChaPoly and SHA256. The data of a
/// handshake is mixed in, in order; two sides that mixed in the same data have the same keys.
class SymmetricState {
 public:
  explicit SymmetricState(std::string_view protocol_name);

  void mix_hash(ByteView data);
  void mix_key(const Key& input);
  /// Writes `text`, encrypted, and a tag to `to`. @pre `to` is tag_bytes longer than `text`; a key
  /// was mixed in.
  void encrypt_and_hash(ByteView text, std::span<std::byte> to);
  /// Decrypts `sealed` into `to`. False when `sealed` is forged; this state must then be discarded.
  /// @pre `sealed` is tag_bytes longer than `to`; a key was mixed in.
  [[nodiscard]] bool decrypt_and_hash(ByteView sealed, std::span<std::byte> to);

  /// The key for the initiator's messages and the key for the responder's messages.
  std::pair<Key, Key> split() const;
  const Hash& hash() const { return hash_; }

 private:
  Key chaining_;
  Hash hash_{};
  Key key_;
  std::uint64_t counter_ = 0;
};

}  // namespace gecos::crypto
