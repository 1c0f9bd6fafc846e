#pragma once

#include "script.hpp"

namespace gecos::fuzz {

/// A connection over shm, of either role, whose peer holds real memory and a real socket and does
/// with them what it likes.
void try_shm_connection(Script script);

}  // namespace gecos::fuzz
