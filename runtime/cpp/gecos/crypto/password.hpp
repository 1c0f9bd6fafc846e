#pragma once

#include <cstddef>

#include "gecos/base/bytes.hpp"
#include "gecos/crypto/secret.hpp"

namespace gecos::crypto {

/// Random bytes that make the keys of equal passwords differ. They are no secret.
using Salt = Secret<16>;
Salt draw_salt();

/// Memory that one call of password_key takes, in bytes.
constexpr std::size_t password_memory = 19 * 1024 * 1024;

/// Returns the key that Argon2id derives from `password`, 32 bytes. The derivation takes some tens
/// of milliseconds on purpose, so that it is slow to guess passwords. Throws std::bad_alloc when
/// there is not enough memory. Call this function on a thread for which nothing else waits.
Bytes password_key(ByteView password, const Salt& salt);

}  // namespace gecos::crypto
