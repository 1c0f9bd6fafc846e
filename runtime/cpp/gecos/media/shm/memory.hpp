#pragma once

#include <cstddef>
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

/// Maps memory of a peer for reading. Refuses memory that has another size or no seals, because a
/// peer could shrink unsealed memory later, and a read would then kill this process by SIGBUS.
tl::expected<Mapping, std::string> map_received(int memfd, std::size_t size);

}  // namespace gecos::media::shm
