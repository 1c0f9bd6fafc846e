#include "gecos/crypto/password.hpp"

#include <sodium.h>

#include <new>

#include "gecos/crypto/keys.hpp"
#include "gecos/crypto/raw.hpp"

namespace gecos::crypto {
namespace {

constexpr unsigned long long passes = 2;
static_assert(sizeof(Salt) == crypto_pwhash_argon2id_SALTBYTES);

}  // namespace

Salt draw_salt() {
  start_sodium();
  Salt salt;
  ::randombytes_buf(salt.bytes().data(), salt.bytes().size());
  return salt;
}

Bytes password_key(ByteView password, const Salt& salt) {
  start_sodium();
  Bytes key(key_bytes);
  if (::crypto_pwhash_argon2id(raw(key.data()), key.size(),
                               reinterpret_cast<const char*>(password.data()), password.size(),
                               raw(salt.bytes().data()), passes, password_memory,
                               crypto_pwhash_argon2id_ALG_ARGON2ID13) != 0) {
    throw std::bad_alloc();
  }
  return key;
}

}  // namespace gecos::crypto
