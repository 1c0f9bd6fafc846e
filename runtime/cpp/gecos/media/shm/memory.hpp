#pragma once

#include <cstddef>
#include <string>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/media/parts/mapping.hpp"

namespace gecos::media::shm {

/// Memory that this process writes and others may map read-only. It has no name in the file system.
struct SealedMemory {
  Descriptor memfd;
  Mapping mapping;
};

/// Makes zeroed memory whose size is fixed and which no other process can map for writing.
tl::expected<SealedMemory, MediumError> make_sealed(const char* name, std::size_t size);

/// Maps memory that a peer made, read-only. Refuses memory of another size or without seals: if the
/// peer shrank it later, a read would kill this process by SIGBUS.
tl::expected<Mapping, std::string> map_received(int memfd, std::size_t size);

}  // namespace gecos::media::shm
