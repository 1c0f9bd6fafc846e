// An encoder that writes values in the LCM type encoding: numbers are big-endian, and fields are
// written in their declared order.
#pragma once

#include <cassert>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>

#include "gecos/base/bytes.hpp"
#include "gecos/wire/swap_copy.hpp"

namespace gecos::wire {

/// A contiguous range of numbers, for example a span, a vector or an array.
template <typename Range>
concept NumberRange = requires(Range& range) {
  range.data();
  range.size();
  requires Number<std::remove_cvref_t<decltype(*range.data())>>;
};

/// Returns the number of bytes that `put_string` writes for `text`: a count, the text and a NUL.
constexpr std::size_t string_size(std::string_view text) { return 4 + text.size() + 1; }

/// The place in a sample for the octets of its @bulk sequence. The publisher writes the octets
/// there after all other members of the sample were encoded.
struct BulkPlace {
  std::size_t size = 0;           ///< number of octets
  std::span<std::byte> octets{};  ///< in the buffer of the encoder; empty before put_bulk()
};

/// Writes values into a buffer, one after the other. The caller must make the buffer as large as
/// the `encoded_size()` of the value. Only a debug build checks that the written values fit into
/// the buffer.
class Encoder {
 public:
  explicit Encoder(std::span<std::byte> buffer)
      : begin_(buffer.data()), cursor_(begin_), end_(begin_ + buffer.size()) {}

  /// Appends numbers and booleans, one after the other. One call with many values is faster than
  /// many calls, because the compiler must assume that each write may change `cursor_`.
  template <typename... T>
  requires((Number<T> || std::same_as<T, bool>)&&...) void put(T... values) {
    assert((sizeof(T) + ... + 0) <= room());
    std::byte* cursor = cursor_;
    ((store(cursor, values), cursor += sizeof(T)), ...);
    cursor_ = cursor;
  }

  /// Appends the count of the elements that follow, or the size of a block, as a 32-bit integer.
  void put_count(std::size_t count) {
    assert(count <= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()));
    put(static_cast<std::int32_t>(count));
  }

  /// Appends a string. @pre `text` is UTF-8 without NUL (`valid_text`); readers refuse any other
  /// text.
  void put_string(std::string_view text) {
    put_count(text.size() + 1);
    put_bytes(std::as_bytes(std::span(text.data(), text.size())));
    put(std::uint8_t{0});
  }

  /// Appends raw bytes, without a count.
  void put_bytes(ByteView bytes) {
    assert(bytes.size() <= room());
    if (!bytes.empty()) std::memcpy(cursor_, bytes.data(), bytes.size());
    cursor_ += bytes.size();
  }

  /// Appends all numbers of a span, vector or array, without a count. Swaps the bytes of all
  /// numbers at once, which is faster than writing one number after the other.
  template <NumberRange Range>
  void put_array(const Range& numbers) {
    constexpr std::size_t width = sizeof(*numbers.data());
    assert(numbers.size() * width <= room());
    swap_copy<width>(cursor_, reinterpret_cast<const std::byte*>(numbers.data()), numbers.size());
    cursor_ += numbers.size() * width;
  }

  /// Makes the next put_bulk() leave `place.size` bytes free, and stores the place of these free
  /// bytes in `place`. `place` must outlive the encoder.
  void leave_bulk(BulkPlace& place) { bulk_ = &place; }

  /// Appends a @bulk sequence of octets: the count, then the octets. After a call of leave_bulk(),
  /// ignores `octets` and leaves the bytes for the octets free.
  void put_bulk(std::span<const std::uint8_t> octets) {
    if (bulk_ == nullptr) {
      put_count(octets.size());
      put_bytes(std::as_bytes(octets));
      return;
    }
    put_count(bulk_->size);
    assert(bulk_->size <= room());
    bulk_->octets = std::span(cursor_, bulk_->size);
    cursor_ += bulk_->size;
    bulk_ = nullptr;
  }

  std::size_t written() const { return static_cast<std::size_t>(cursor_ - begin_); }

 private:
  template <typename T>
  static void store(std::byte* to, T value) {
    if constexpr (std::same_as<T, bool>) {
      *to = value ? std::byte{1} : std::byte{0};
    } else {
      store_big_endian(to, value);
    }
  }

  [[maybe_unused]] std::size_t room() const { return static_cast<std::size_t>(end_ - cursor_); }

  std::byte* begin_;
  std::byte* cursor_;
  std::byte* end_;
  BulkPlace* bulk_ = nullptr;
};

}  // namespace gecos::wire
