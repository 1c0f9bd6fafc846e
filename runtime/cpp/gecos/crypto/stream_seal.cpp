#include "gecos/crypto/stream_seal.hpp"

#include <sodium.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "gecos/crypto/big_endian.hpp"
#include "gecos/crypto/keys.hpp"
#include "gecos/crypto/raw.hpp"

namespace gecos::crypto {
namespace {

static_assert(StreamSealer::signature_bytes == crypto_sign_BYTES);
static_assert(crypto_sign_SECRETKEYBYTES == 64 && crypto_sign_PUBLICKEYBYTES == 32);

using Digest = std::array<unsigned char, crypto_generichash_BYTES_MAX>;

/// Returns the digest that the writer signs. The digest covers a fixed text that states the purpose
/// of the signature, the counter, the associated data and the sample.
Digest digest_of(std::span<const std::byte, Sealer::text_at> counter, ByteView associated,
                 ByteView sample) {
  constexpr std::string_view purpose = "gecos stream 1";
  std::array<std::byte, 8> size;
  write_u64(size, associated.size());
  crypto_generichash_state state;
  Digest digest;
  ::crypto_generichash_init(&state, nullptr, 0, digest.size());
  for (const ByteView part :
       {std::as_bytes(std::span(purpose)), ByteView(counter), ByteView(size), associated, sample}) {
    ::crypto_generichash_update(&state, raw(part.data()), part.size());
  }
  ::crypto_generichash_final(&state, digest.data(), digest.size());
  return digest;
}

}  // namespace

void StreamKey::write(std::span<std::byte, bytes> to) const {
  std::ranges::copy(key.bytes(), to.begin());
  std::ranges::copy(signer, to.begin() + 32);
}

StreamKey StreamKey::read(std::span<const std::byte, bytes> from) {
  StreamKey read{Key(from.first<32>()), {}};
  std::ranges::copy(from.last<32>(), read.signer.begin());
  return read;
}

StreamSealer::StreamSealer(std::uint64_t next) : next_(next) {
  key_.key = Key(KeyPair::draw().secret.bytes());
  ::crypto_sign_keypair(raw(key_.signer.data()), raw(signing_.bytes().data()));
}

void StreamSealer::seal(ByteView associated, std::span<std::byte> frame) {
  if (frame.size() < overhead)
    throw std::invalid_argument("the frame is too short for counter, signature and tag");
  const auto counter = frame.first<text_at>();
  write_u64(counter, next_);
  const auto text = frame.subspan(text_at, frame.size() - Sealer::overhead);
  const auto sample = text.first(text.size() - signature_bytes);
  const Digest digest = digest_of(counter, associated, sample);
  ::crypto_sign_detached(raw(text.data() + sample.size()), nullptr, digest.data(), digest.size(),
                         raw(signing_.bytes().data()));
  aead_seal(key_.key, next_++, associated, text, frame.last<tag_bytes>());
}

tl::expected<std::span<std::byte>, OpenProblem> StreamOpener::open(ByteView associated,
                                                                   std::span<std::byte> frame) {
  if (frame.size() < StreamSealer::overhead) return tl::unexpected(OpenProblem::TooShort);
  const auto counter = frame.first<StreamSealer::text_at>();
  const std::uint64_t number = read_u64(counter);
  if (number == std::numeric_limits<std::uint64_t>::max()) {
    return tl::unexpected(OpenProblem::TooNew);  // Noise reserves this nonce for REKEY
  }
  if (seen_.too_old(number)) return tl::unexpected(OpenProblem::TooOld);
  if (!seen_.fresh(number)) return tl::unexpected(OpenProblem::Replayed);
  const auto text = frame.subspan(StreamSealer::text_at, frame.size() - Sealer::overhead);
  if (!aead_open(key_.key, number, associated, text, frame.last<tag_bytes>())) {
    return tl::unexpected(OpenProblem::Forged);
  }
  const auto sample = text.first(text.size() - StreamSealer::signature_bytes);
  const Digest digest = digest_of(counter, associated, sample);
  if (::crypto_sign_verify_detached(raw(text.data() + sample.size()), digest.data(), digest.size(),
                                    raw(key_.signer.data())) != 0) {
    return tl::unexpected(OpenProblem::Forged);
  }
  seen_.mark(number);
  return sample;
}

}  // namespace gecos::crypto
