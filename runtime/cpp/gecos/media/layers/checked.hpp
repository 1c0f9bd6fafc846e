#pragma once

#include <cstdint>
#include <memory>

#include "gecos/base/bytes.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// CRC-32C (Castagnoli), as iSCSI and ext4 use it: any one damage of up to 32 bits in a row is
/// found, and of all others one in 2^32 is not.
std::uint32_t crc32c(ByteView bytes, std::uint32_t before = 0);

/// Wraps a medium that says of itself that packets may arrive damaged: each carries its checksum,
/// and one whose checksum is wrong is as good as lost. Against damage, not against malice.
std::unique_ptr<Medium> make_checked(std::unique_ptr<Medium> inner);

}  // namespace gecos::media
