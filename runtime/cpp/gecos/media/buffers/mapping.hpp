#pragma once

#include <cstddef>
#include <utility>

namespace gecos::media {

/// Owns a page-aligned block of mapped memory. The kernel backs a page with memory at its first
/// use.
class Mapping {
 public:
  Mapping() = default;
  /// Maps private zeroed memory. Throws std::bad_alloc on failure.
  static Mapping anonymous(std::size_t size);
  /// Maps the memory of a memfd, which is shared with all processes that map it. Returns an empty
  /// Mapping when the kernel refuses.
  static Mapping shared(int memfd, std::size_t size, bool writable);

  Mapping(Mapping&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();

  explicit operator bool() const { return data_ != nullptr; }
  std::byte* data() const { return data_; }
  std::size_t size() const { return size_; }

  /// Must be called in a forked child: replaces the memory by private zeroed memory. The child then
  /// shares nothing with its parent, and code that still reads the memory sees an empty ring. Does
  /// not allocate memory.
  void forget();

 private:
  Mapping(std::byte* data, std::size_t size) : data_(data), size_(size) {}
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace gecos::media
