#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace gecos::crypto {

/// Records which of the newest `size` packet numbers have been seen. All lower numbers count as
/// seen.
///
/// The numbers are bits in a ring that is twice as long as the window. When the window moves,
/// mark() can therefore clear whole words that the window does not use yet. So mark() takes the
/// same time whether packets arrive in order or not.
class ReplayWindow {
 public:
  static constexpr std::uint64_t size = 1024;

  bool too_old(std::uint64_t number) const { return number < next_ && next_ - number > size; }
  bool fresh(std::uint64_t number) const {
    return !too_old(number) && (number >= next_ || (word(number) & bit(number)) == 0);
  }
  /// Records that the packet `number` was seen. @pre fresh(number) is true, and the sender of the
  /// packet is authenticated.
  void mark(std::uint64_t number) {
    if (number >= next_) {
      const std::uint64_t from =
          next_ == 0 ? 0 : (next_ - 1) / word_bits + 1;  // the first unused word
      const std::uint64_t to = number / word_bits;
      if (to >= from) {
        const std::uint64_t count = std::min<std::uint64_t>(to - from + 1, words_.size());
        for (std::uint64_t i = 0; i < count; ++i) words_[(to - i) % words_.size()] = 0;
      }
      next_ = number + 1;
    }
    words_[(number / word_bits) % words_.size()] |= bit(number);
  }

 private:
  static constexpr std::uint64_t word_bits = 64;
  static std::uint64_t bit(std::uint64_t number) { return std::uint64_t{1} << number % word_bits; }
  std::uint64_t word(std::uint64_t number) const {
    return words_[(number / word_bits) % words_.size()];
  }

  std::array<std::uint64_t, 2 * size / word_bits> words_{};
  std::uint64_t next_ = 0;  // one above the highest number seen
};

}  // namespace gecos::crypto
