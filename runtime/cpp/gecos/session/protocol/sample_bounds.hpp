#pragma once

#include <cstddef>

/// The bounds of a stream whose interface declares none.
namespace gecos::session {

/// The size in bytes of the largest sample.
inline constexpr std::size_t unbounded_sample = 64 * 1024;
/// The number of samples that are kept.
inline constexpr std::size_t usual_depth = 16;

}  // namespace gecos::session
