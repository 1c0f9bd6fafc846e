// Checks whether this process may open more file descriptors.
#pragma once

#include <cstddef>

namespace gecos {

/// Whether this process can open `count` more descriptors now: opens and closes that many. When
/// false, errno is set.
bool descriptors_left(std::size_t count);

}  // namespace gecos
