#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gecos/base/bytes.hpp"
#include "gecos/base/result.hpp"
#include "gecos/crypto/keys.hpp"
#include "gecos/crypto/noise.hpp"

/// The handshake Noise_IK_25519_ChaChaPoly_SHA256. It consists of two messages. Afterwards both
/// sides know each other's public key and share two secret keys. The initiator must know the
/// responder's public key beforehand. The files handshake_initiator.hpp and handshake_acceptor.hpp
/// add the repetition of messages, the check that a key is admitted, and limits.
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

  /// Returns the first message of the handshake. Must be called only once.
  tl::expected<Bytes, HandshakeProblem> write_first(ByteView payload);

  struct Finished {
    SessionKeys keys;
    Bytes payload;
  };
  /// Reads the second message of the handshake. Fails and changes nothing when the message is
  /// forged; the genuine message may still arrive.
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

  /// Reads the first message of a handshake. Stores nothing of a message that fails the checks.
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
