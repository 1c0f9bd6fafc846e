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

/// Noise's SymmetricState (revision 34, section 5.2) with ChaChaPoly and SHA256. What goes through
/// a handshake is folded in, in order; two sides that folded in the same have the same keys.
class SymmetricState {
 public:
  explicit SymmetricState(std::string_view protocol_name);

  void mix_hash(ByteView data);
  void mix_key(const Key& input);
  /// `to` gets `text`, encrypted, and a tag. @pre `to` has tag_bytes more than `text`; a key was
  /// mixed in.
  void encrypt_and_hash(ByteView text, std::span<std::byte> to);
  /// @pre `sealed` has tag_bytes more than `to`; a key was mixed in. After false this state is of
  /// no use.
  [[nodiscard]] bool decrypt_and_hash(ByteView sealed, std::span<std::byte> to);

  /// The keys of the initiator's and of the responder's messages.
  std::pair<Key, Key> split() const;
  const Hash& hash() const { return hash_; }

 private:
  Key chaining_;
  Hash hash_{};
  Key key_;
  std::uint64_t counter_ = 0;
};

}  // namespace gecos::crypto
