#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gecos/base/bytes.hpp"
#include "gecos/base/result.hpp"
#include "gecos/crypto/keys.hpp"
#include "gecos/crypto/noise.hpp"

/// The handshake Noise_IK_25519_ChaChaPoly_SHA256: two messages, after which both sides know each
/// other's public key and share two keys. The initiator knows the responder's public key
/// beforehand. Repetition, admission and limits are in handshake_initiator.hpp and
/// handshake_acceptor.hpp.
namespace gecos::crypto {

inline constexpr std::string_view noise_name = "Noise_IK_25519_ChaChaPoly_SHA256";

enum class HandshakeProblem : std::uint8_t {
  WrongSize,  ///< too short for a message of this handshake
  WeakKey,    ///< a public key that gives the same shared secret with every key
  Forged,     ///< wrong recipient, sender or prologue, or an altered message
};
std::string_view to_string(HandshakeProblem problem);

struct SessionKeys {
  Key send;
  Key receive;
  Hash binding;  ///< equal on both sides, and unique to this handshake
};

class IkInitiator {
 public:
  static constexpr std::size_t first_overhead = key_bytes + key_bytes + tag_bytes + tag_bytes;

  IkInitiator(const Identity& own, const PublicKey& responder, ByteView prologue,
              const KeyPair& ephemeral = KeyPair::draw());

  /// Writes the first message. Must be called only once.
  tl::expected<Bytes, HandshakeProblem> write_first(ByteView payload);

  struct Finished {
    SessionKeys keys;
    Bytes payload;
  };
  /// A forged message changes nothing: the genuine message may still arrive.
  tl::expected<Finished, HandshakeProblem> read_second(ByteView message) const;

 private:
  const Identity& own_;
  PublicKey responder_;
  KeyPair ephemeral_;
  SymmetricState state_;
};

class IkResponder {
 public:
  static constexpr std::size_t second_overhead = key_bytes + tag_bytes;

  /// Stores nothing from a message that fails.
  static tl::expected<IkResponder, HandshakeProblem> read_first(const Identity& own,
                                                                ByteView message,
                                                                ByteView prologue);

  const PublicKey& initiator() const { return initiator_; }
  const Bytes& payload() const { return payload_; }

  struct Finished {
    SessionKeys keys;
    Bytes message;
  };
  tl::expected<Finished, HandshakeProblem> write_second(
      ByteView payload, const KeyPair& ephemeral = KeyPair::draw()) const;

 private:
  explicit IkResponder(const SymmetricState& state) : state_(state) {}

  SymmetricState state_;
  PublicKey initiator_;
  PublicKey initiator_ephemeral_;
  Bytes payload_;
};

}  // namespace gecos::crypto
