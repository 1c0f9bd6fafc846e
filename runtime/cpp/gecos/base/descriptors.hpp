// How many descriptors are left to this process.
#pragma once

#include <cstddef>

namespace gecos {

/// Whether this process can open `count` more descriptors now: it takes them and gives them back.
/// False with errno.
bool descriptors_left(std::size_t count);

}  // namespace gecos
