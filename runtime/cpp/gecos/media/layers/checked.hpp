#pragma once

#include <cstdint>
#include <memory>

#include "gecos/base/bytes.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// Returns the checksum CRC-32C (Castagnoli), which iSCSI and ext4 also use. It detects every error
/// burst of up to 32 bits, and misses one in 2^32 of all other errors. `before` is the checksum of
/// the bytes that precede `bytes`.
std::uint32_t crc32c(ByteView bytes, std::uint32_t before = 0);

/// Wraps a medium over which packets may arrive damaged. Each packet gets a checksum, and the
/// receiver drops a packet whose checksum is wrong. This protects against damage, but not against
/// attacks.
std::unique_ptr<Medium> make_checked(std::unique_ptr<Medium> inner);

}  // namespace gecos::media
