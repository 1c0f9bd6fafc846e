#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace devices {

/// Holds the newest value that one thread writes and any number of threads read. Writing is
/// wait-free. A reader reads again if the writer changed the value during the read. A write takes
/// less than a microsecond, so a reader rarely reads more than twice.
template <typename T>
requires std::is_trivially_copyable_v<T>
class Latest {
 public:
  explicit Latest(const T& value) { write(value); }

  void write(const T& value) {
    std::array<std::uint64_t, words> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    version_.fetch_add(1);  // odd: tells readers that the words are changing
    for (std::size_t i = 0; i < words; ++i) words_[i].store(raw[i]);
    version_.fetch_add(1);  // even again: publishes the words to readers
  }

  T read() const {
    std::array<std::uint64_t, words> raw;
    std::uint64_t before = 0;
    do {
      before = version_.load();
      for (std::size_t i = 0; i < words; ++i) raw[i] = words_[i].load();
    } while (before % 2 != 0 || version_.load() != before);
    T value;
    std::memcpy(static_cast<void*>(&value), raw.data(), sizeof(T));
    return value;
  }

 private:
  static constexpr std::size_t words = (sizeof(T) + 7) / 8;
  std::atomic<std::uint64_t> version_{0};
  std::array<std::atomic<std::uint64_t>, words> words_{};  // the bytes of T
};

}  // namespace devices
