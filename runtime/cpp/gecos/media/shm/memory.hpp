#pragma once

#include <cstddef>
#include <string>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/media/parts/mapping.hpp"

namespace gecos::media::shm {

/// Memory that we write and others may map, read-only. Nothing of it has a name.
struct SealedMemory {
  Descriptor memfd;
  Mapping mapping;
};

/// Zeroed memory that can no longer change its size, nor be mapped for writing by anybody else.
tl::expected<SealedMemory, MediumError> make_sealed(const char* name, std::size_t size);

/// Maps memory that a peer made, read-only. Refuses what could hurt later: another size, or missing
/// seals (cut off under our feet it would kill us by SIGBUS).
tl::expected<Mapping, std::string> map_received(int memfd, std::size_t size);

}  // namespace gecos::media::shm
