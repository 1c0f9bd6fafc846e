#pragma once

#include <cstddef>

namespace gecos::crypto {

/// Converts a pointer to bytes to the pointer type that libsodium takes.
inline unsigned char* raw(std::byte* bytes) { return reinterpret_cast<unsigned char*>(bytes); }
inline const unsigned char* raw(const std::byte* bytes) {
  return reinterpret_cast<const unsigned char*>(bytes);
}

/// Initializes libsodium at the first call: chooses the code for this processor and opens the
/// source of random numbers. Throws std::runtime_error when there is no such source.
void start_sodium();

}  // namespace gecos::crypto
