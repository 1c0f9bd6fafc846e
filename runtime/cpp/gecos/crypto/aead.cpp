#include "gecos/crypto/aead.hpp"

#include <sodium.h>

#include <array>
#include <limits>

#include "gecos/crypto/raw.hpp"

namespace gecos::crypto {
namespace {

static_assert(tag_bytes == crypto_aead_chacha20poly1305_ietf_ABYTES);

using Nonce = std::array<unsigned char, crypto_aead_chacha20poly1305_ietf_NPUBBYTES>;

Nonce nonce_of(std::uint64_t counter) {
  Nonce nonce{};
  for (std::size_t i = 0; i < sizeof counter; ++i) {
    nonce[4 + i] = static_cast<unsigned char>(counter >> (8 * i));
  }
  return nonce;
}

}  // namespace

void aead_seal(const Key& key, std::uint64_t counter, ByteView associated,
               std::span<std::byte> text, std::span<std::byte, tag_bytes> tag) {
  ::crypto_aead_chacha20poly1305_ietf_encrypt_detached(
      raw(text.data()), raw(tag.data()), nullptr, raw(text.data()), text.size(),
      raw(associated.data()), associated.size(), nullptr, nonce_of(counter).data(),
      raw(key.bytes().data()));
}

bool aead_open(const Key& key, std::uint64_t counter, ByteView associated,
               std::span<std::byte> text, std::span<const std::byte, tag_bytes> tag) {
  std::byte nothing{};  // libsodium takes a null output for "verify only"
  std::byte* const to = text.empty() ? &nothing : text.data();
  return ::crypto_aead_chacha20poly1305_ietf_decrypt_detached(
             raw(to), nullptr, raw(to), text.size(), raw(tag.data()), raw(associated.data()),
             associated.size(), nonce_of(counter).data(), raw(key.bytes().data())) == 0;
}

Key next_key(const Key& key) {
  Key next;
  std::array<std::byte, tag_bytes> unused;
  aead_seal(key, std::numeric_limits<std::uint64_t>::max(), {}, next.bytes(), unused);
  return next;
}

}  // namespace gecos::crypto
