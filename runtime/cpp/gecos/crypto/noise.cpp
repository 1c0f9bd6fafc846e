#include "gecos/crypto/noise.hpp"

#include <sodium.h>

#include <algorithm>
#include <tuple>

#include "gecos/crypto/raw.hpp"

namespace gecos::crypto {
namespace {

static_assert(sizeof(Hash) == crypto_hash_sha256_BYTES);

/// Returns the HMAC-SHA256 of `first` followed by `second`.
Key hmac(const Key& key, ByteView first, ByteView second) {
  crypto_auth_hmacsha256_state state;
  ::crypto_auth_hmacsha256_init(&state, raw(key.bytes().data()), key.bytes().size());
  ::crypto_auth_hmacsha256_update(&state, raw(first.data()), first.size());
  ::crypto_auth_hmacsha256_update(&state, raw(second.data()), second.size());
  Key result;
  ::crypto_auth_hmacsha256_final(&state, raw(result.bytes().data()));
  ::sodium_memzero(&state, sizeof state);
  return result;
}

/// Returns the two outputs of the function HKDF of the Noise protocol.
std::pair<Key, Key> derive(const Key& chaining, ByteView input) {
  constexpr std::array one{std::byte{1}};
  constexpr std::array two{std::byte{2}};
  const Key secret = hmac(chaining, input, {});
  const Key first = hmac(secret, {}, one);
  return {first, hmac(secret, first.bytes(), two)};
}

}  // namespace

SymmetricState::SymmetricState(std::string_view protocol_name) {
  if (protocol_name.size() <= hash_.size()) {
    std::ranges::transform(protocol_name, hash_.begin(), [](char c) { return std::byte(c); });
  } else {
    ::crypto_hash_sha256(raw(hash_.data()),
                         reinterpret_cast<const unsigned char*>(protocol_name.data()),
                         protocol_name.size());
  }
  chaining_ = Key(hash_);
}

void SymmetricState::mix_hash(ByteView data) {
  crypto_hash_sha256_state state;
  ::crypto_hash_sha256_init(&state);
  ::crypto_hash_sha256_update(&state, raw(hash_.data()), hash_.size());
  ::crypto_hash_sha256_update(&state, raw(data.data()), data.size());
  ::crypto_hash_sha256_final(&state, raw(hash_.data()));
}

void SymmetricState::mix_key(const Key& input) {
  std::tie(chaining_, key_) = derive(chaining_, input.bytes());
  counter_ = 0;
}

void SymmetricState::encrypt_and_hash(ByteView text, std::span<std::byte> to) {
  const auto inside = to.first(text.size());
  std::ranges::copy(text, inside.begin());
  aead_seal(key_, counter_++, hash_, inside, to.last<tag_bytes>());
  mix_hash(to);
}

bool SymmetricState::decrypt_and_hash(ByteView sealed, std::span<std::byte> to) {
  std::ranges::copy(sealed.first(to.size()), to.begin());
  if (!aead_open(key_, counter_++, hash_, to, sealed.last<tag_bytes>())) return false;
  mix_hash(sealed);
  return true;
}

std::pair<Key, Key> SymmetricState::split() const { return derive(chaining_, {}); }

}  // namespace gecos::crypto
