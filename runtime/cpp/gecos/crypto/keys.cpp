#include "gecos/crypto/keys.hpp"

#include <sodium.h>

#include <cstring>
#include <new>
#include <stdexcept>

#include "gecos/crypto/raw.hpp"

namespace gecos::crypto {
namespace {

static_assert(key_bytes == crypto_scalarmult_BYTES && key_bytes == crypto_scalarmult_SCALARBYTES);

}  // namespace

void start_sodium() {
  static const bool started = ::sodium_init() >= 0;
  if (!started)
    throw std::runtime_error("libsodium cannot start: the system has no source of random numbers");
}

void wipe(std::span<std::byte> bytes) { ::sodium_memzero(bytes.data(), bytes.size()); }

std::string PublicKey::to_string() const {
  std::string text(2 * key_bytes + 1, '\0');
  ::sodium_bin2hex(text.data(), text.size(), raw(bytes.data()), bytes.size());
  text.pop_back();
  return text;
}

std::string PublicKey::short_name() const { return to_string().substr(0, 8); }

std::optional<PublicKey> PublicKey::parse(std::string_view hex_digits) {
  PublicKey key;
  std::size_t size = 0;
  if (hex_digits.size() != 2 * key_bytes ||
      ::sodium_hex2bin(raw(key.bytes.data()), key_bytes, hex_digits.data(), hex_digits.size(),
                       nullptr, &size, nullptr) != 0 ||
      size != key_bytes) {
    return std::nullopt;
  }
  return key;
}

PublicKey PublicKey::of(ByteView from) {
  PublicKey key;
  std::memcpy(key.bytes.data(), from.data(), key_bytes);
  return key;
}

KeyPair KeyPair::of(const Secret<key_bytes>& secret) {
  start_sodium();
  KeyPair pair{secret, {}};
  ::crypto_scalarmult_base(raw(pair.public_key.bytes.data()), raw(secret.bytes().data()));
  return pair;
}

KeyPair KeyPair::draw() {
  start_sodium();
  Secret<key_bytes> secret;
  ::randombytes_buf(secret.bytes().data(), key_bytes);
  return of(secret);
}

Identity::Identity(const KeyPair& pair) : public_key_(pair.public_key) {
  start_sodium();
  secret_.reset(static_cast<std::byte*>(::sodium_malloc(key_bytes)));
  if (secret_ == nullptr) throw std::bad_alloc();
  std::memcpy(secret_.get(), pair.secret.bytes().data(), key_bytes);
  ::sodium_mprotect_readonly(secret_.get());
}

std::span<const std::byte, key_bytes> Identity::secret() const {
  return std::span<const std::byte, key_bytes>(secret_.get(), key_bytes);
}

void Identity::Free::operator()(std::byte* memory) const { ::sodium_free(memory); }

std::optional<Key> shared_secret(std::span<const std::byte, key_bytes> secret,
                                 const PublicKey& peer) {
  Key shared;
  if (::crypto_scalarmult(raw(shared.bytes().data()), raw(secret.data()), raw(peer.bytes.data())) !=
      0) {
    return std::nullopt;
  }
  return shared;
}

}  // namespace gecos::crypto
