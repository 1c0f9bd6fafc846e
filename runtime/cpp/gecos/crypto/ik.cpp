#include "gecos/crypto/ik.hpp"

#include <algorithm>

namespace gecos::crypto {
namespace {

constexpr std::size_t sealed_key_bytes = key_bytes + tag_bytes;

SymmetricState begin(ByteView prologue, const PublicKey& responder) {
  SymmetricState state(noise_name);
  state.mix_hash(prologue);
  // The initiator knows the responder's key beforehand. This is the pre-message "<- s" of the Noise
  // pattern.
  state.mix_hash(responder.bytes);
  return state;
}

[[nodiscard]] bool mix_shared(SymmetricState& state, std::span<const std::byte, key_bytes> secret,
                              const PublicKey& peer) {
  const auto shared = shared_secret(secret, peer);
  if (shared) state.mix_key(*shared);
  return shared.has_value();
}

}  // namespace

std::string_view to_string(HandshakeProblem problem) {
  switch (problem) {
    case HandshakeProblem::WrongSize:
      return "the message is too short for this handshake";
    case HandshakeProblem::WeakKey:
      return "the message has an insecure public key";
    case HandshakeProblem::Forged:
      return "the message is not for this key and address, or it was altered";
  }
  return "unknown";
}

IkInitiator::IkInitiator(const Identity& own, const PublicKey& responder, ByteView prologue,
                         const KeyPair& ephemeral)
    : own_(own), responder_(responder), ephemeral_(ephemeral), state_(begin(prologue, responder)) {}

// Noise message pattern: -> e, es, s, ss
tl::expected<Bytes, HandshakeProblem> IkInitiator::write_first(ByteView payload) {
  Bytes message(first_overhead + payload.size());
  const std::span<std::byte> all(message);
  std::ranges::copy(ephemeral_.public_key.bytes, all.begin());
  state_.mix_hash(ephemeral_.public_key.bytes);
  if (!mix_shared(state_, ephemeral_.secret.bytes(), responder_)) {
    return tl::unexpected(HandshakeProblem::WeakKey);
  }
  state_.encrypt_and_hash(own_.public_key().bytes, all.subspan(key_bytes, sealed_key_bytes));
  if (!mix_shared(state_, own_.secret(), responder_)) {
    return tl::unexpected(HandshakeProblem::WeakKey);
  }
  state_.encrypt_and_hash(payload, all.subspan(key_bytes + sealed_key_bytes));
  return message;
}

// Noise message pattern: <- e, ee, se
tl::expected<IkInitiator::Finished, HandshakeProblem> IkInitiator::read_second(
    ByteView message) const {
  if (message.size() < IkResponder::second_overhead) {
    return tl::unexpected(HandshakeProblem::WrongSize);
  }
  SymmetricState state = state_;
  const PublicKey theirs = PublicKey::of(message.first(key_bytes));
  state.mix_hash(theirs.bytes);
  if (!mix_shared(state, ephemeral_.secret.bytes(), theirs) ||
      !mix_shared(state, own_.secret(), theirs)) {
    return tl::unexpected(HandshakeProblem::WeakKey);
  }
  Bytes payload(message.size() - IkResponder::second_overhead);
  if (!state.decrypt_and_hash(message.subspan(key_bytes), payload)) {
    return tl::unexpected(HandshakeProblem::Forged);
  }
  const auto [ours, responders] = state.split();
  return Finished{{ours, responders, state.hash()}, std::move(payload)};
}

tl::expected<IkResponder, HandshakeProblem> IkResponder::read_first(const Identity& own,
                                                                    ByteView message,
                                                                    ByteView prologue) {
  if (message.size() < IkInitiator::first_overhead) {
    return tl::unexpected(HandshakeProblem::WrongSize);
  }
  IkResponder responder(begin(prologue, own.public_key()));
  SymmetricState& state = responder.state_;
  responder.initiator_ephemeral_ = PublicKey::of(message.first(key_bytes));
  state.mix_hash(responder.initiator_ephemeral_.bytes);
  if (!mix_shared(state, own.secret(), responder.initiator_ephemeral_)) {
    return tl::unexpected(HandshakeProblem::WeakKey);
  }
  if (!state.decrypt_and_hash(message.subspan(key_bytes, sealed_key_bytes),
                              responder.initiator_.bytes)) {
    return tl::unexpected(HandshakeProblem::Forged);
  }
  if (!mix_shared(state, own.secret(), responder.initiator_)) {
    return tl::unexpected(HandshakeProblem::WeakKey);
  }
  responder.payload_.resize(message.size() - IkInitiator::first_overhead);
  if (!state.decrypt_and_hash(message.subspan(key_bytes + sealed_key_bytes), responder.payload_)) {
    return tl::unexpected(HandshakeProblem::Forged);
  }
  return responder;
}

tl::expected<IkResponder::Finished, HandshakeProblem> IkResponder::write_second(
    ByteView payload, const KeyPair& ephemeral) const {
  SymmetricState state = state_;
  Bytes message(second_overhead + payload.size());
  std::ranges::copy(ephemeral.public_key.bytes, message.begin());
  state.mix_hash(ephemeral.public_key.bytes);
  if (!mix_shared(state, ephemeral.secret.bytes(), initiator_ephemeral_) ||
      !mix_shared(state, ephemeral.secret.bytes(), initiator_)) {
    return tl::unexpected(HandshakeProblem::WeakKey);
  }
  state.encrypt_and_hash(payload, std::span(message).subspan(key_bytes));
  const auto [initiators, ours] = state.split();
  return Finished{{ours, initiators, state.hash()}, std::move(message)};
}

}  // namespace gecos::crypto
