// Checks whether this process can open more file descriptors.
#pragma once

#include <cstddef>

namespace gecos {

/// Returns whether this process can open `count` more file descriptors now: tries to open `count`
/// descriptors and closes them again. Sets errno when it returns false.
bool descriptors_left(std::size_t count);

}  // namespace gecos
