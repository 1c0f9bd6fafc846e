#pragma once

#include <cstdint>
#include <memory>

#include "gecos/base/bytes.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// CRC-32C (Castagnoli), as iSCSI and ext4 use it: it detects every error burst of up to 32 bits,
/// and misses one in 2^32 of all other errors.
std::uint32_t crc32c(ByteView bytes, std::uint32_t before = 0);

/// Wraps a medium over which packets may arrive damaged: each packet carries a checksum, and a
/// packet with a wrong checksum is dropped. Protects against damage, not against attacks.
std::unique_ptr<Medium> make_checked(std::unique_ptr<Medium> inner);

}  // namespace gecos::media
