// Types for a sequence of bytes that is owned, and for one that is borrowed.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gecos {

using Bytes = std::vector<std::byte>;

/// A borrowed sequence of bytes. The bytes must outlive the view.
using ByteView = std::span<const std::byte>;

}  // namespace gecos
