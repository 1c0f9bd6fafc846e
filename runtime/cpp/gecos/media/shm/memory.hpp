#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/buffers/mapping.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media::shm {

/// Shared memory that this process writes and other processes can map only for reading. The memory
/// has no name in the file system.
struct SealedMemory {
  Descriptor memfd;
  Mapping mapping;
};

/// Makes zeroed shared memory of a fixed size. No other process can map this memory for writing.
tl::expected<SealedMemory, MediumError> make_sealed(const char* name, std::size_t size);

/// Why memory of a peer is not mapped.
struct NotMapped {
  enum class Cause : std::uint8_t {
    InvalidMemory,  ///< the peer sent memory that cannot be used
    NoRoom,         ///< the memory is valid, but this process has no address space left for it
  };
  Cause cause = Cause::InvalidMemory;
  std::string text;
};

/// Maps memory of a peer for reading. Refuses memory that has another size or no seals, because a
/// peer could shrink unsealed memory later, and a read would then kill this process by SIGBUS.
tl::expected<Mapping, NotMapped> map_received(int memfd, std::size_t size);

}  // namespace gecos::media::shm
