#pragma once

#include <array>
#include <cstring>

#include "gecos/base/bytes.hpp"

namespace gecos {

/// An owned sequence of bytes. A sequence of up to 128 bytes, which most calls do not exceed, is
/// stored in the object itself, without an allocation.
class ShortBytes {
 public:
  ShortBytes() = default;
  explicit ShortBytes(ByteView bytes) { assign(bytes); }
  // Objects cannot be copied, because the result of view() may point into the object.
  ShortBytes(const ShortBytes&) = delete;
  ShortBytes& operator=(const ShortBytes&) = delete;

  void assign(ByteView bytes) {
    size_ = bytes.size();
    if (size_ > few_.size()) {
      many_.assign(bytes.begin(), bytes.end());
    } else if (size_ != 0) {
      std::memcpy(few_.data(), bytes.data(), size_);
    }
  }
  ByteView view() const { return {size_ > few_.size() ? many_.data() : few_.data(), size_}; }

 private:
  std::size_t size_ = 0;
  std::array<std::byte, 128> few_;  // uninitialized: only size_ bytes are read
  Bytes many_;
};

}  // namespace gecos
