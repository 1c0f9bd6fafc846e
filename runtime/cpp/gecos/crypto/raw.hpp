#pragma once

#include <cstddef>

namespace gecos::crypto {

/// Converts a pointer to bytes to the pointer type that libsodium takes.
inline unsigned char* raw(std::byte* bytes) { return reinterpret_cast<unsigned char*>(bytes); }
inline const unsigned char* raw(const std::byte* bytes) {
  return reinterpret_cast<const unsigned char*>(bytes);
}

}  // namespace gecos::crypto
