// A decoder that reads values in the LCM type encoding from untrusted bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/bytes.hpp"
#include "gecos/wire/decode_error.hpp"
#include "gecos/wire/encoder.hpp"
#include "gecos/wire/swap_copy.hpp"
#include "gecos/wire/text.hpp"

namespace gecos::wire {

inline constexpr std::size_t npos = std::numeric_limits<std::size_t>::max();
inline constexpr int max_depth = 16;
inline constexpr std::size_t max_zero_width = 65'536;

/// Reads values from bytes, one after the other. Every function that reads returns whether it
/// succeeded. After the first failure, all reads fail, and `error()` returns the first error. If a
/// count is larger than the number of elements that the bytes can hold, the decoder refuses the
/// count before it allocates memory. Throws only std::bad_alloc. The parameter `field` is the name
/// of the field for the error, and must be static text.
class Decoder {
 public:
  /// Makes an empty decoder. `open_block` can make it a decoder of the bytes of a block.
  Decoder() : Decoder(ByteView{}) {}

  explicit Decoder(ByteView bytes)
      : begin_(bytes.data()), cursor_(begin_), end_(begin_ + bytes.size()) {}

  template <Number T>
  [[nodiscard]] bool get(T& value, const char* field = "") {
    if (remaining() < sizeof(T)) return fail(DecodeProblem::Truncated, field);
    value = load_big_endian<T>(cursor_);
    cursor_ += sizeof(T);
    return true;
  }

  [[nodiscard]] bool get(bool& value, const char* field = "") {
    if (remaining() < 1) return fail(DecodeProblem::Truncated, field);
    if (*cursor_ > std::byte{1}) return fail(DecodeProblem::InvalidBoolean, field);
    value = *cursor_++ == std::byte{1};
    return true;
  }

  /// Reads a UTF-8 string of at most `max` bytes, without its terminating NUL.
  [[nodiscard]] bool get_string(std::string& text, std::size_t max = npos, const char* field = "") {
    std::string_view view;
    if (!get_string_view(view, max, field)) return false;
    text.assign(view);
    return true;
  }

  /// Reads a string without a copy: `text` refers to the bytes that were given to the decoder.
  [[nodiscard]] bool get_string_view(std::string_view& text, std::size_t max = npos,
                                     const char* field = "") {
    const std::byte* const start = cursor_;
    std::int32_t length = 0;
    if (!get(length, field)) return false;
    const auto size = static_cast<std::size_t>(length) - 1;
    if (length < 1) return fail_at(start, DecodeProblem::NegativeCount, field);
    if (size > max) return fail_at(start, DecodeProblem::OverBound, field);
    if (size >= remaining()) return fail_at(start, DecodeProblem::Truncated, field);
    const std::string_view view(reinterpret_cast<const char*>(cursor_), size);
    if (cursor_[size] != std::byte{0}) return fail_at(start, DecodeProblem::MissingNul, field);
    if (!plain_ascii(view)) {
      if (view.find('\0') != npos) return fail_at(start, DecodeProblem::NulInString, field);
      if (!valid_utf8(view)) return fail_at(start, DecodeProblem::InvalidUtf8, field);
    }
    cursor_ += size + 1;
    text = view;
    return true;
  }

  /// Reads the count of elements of which each takes at least `min_bytes_each` bytes. Refuses a
  /// count that is negative, larger than `max`, or larger than the remaining bytes can hold. So the
  /// caller can safely allocate memory for `count` elements.
  [[nodiscard]] bool get_count(std::size_t& count, std::size_t min_bytes_each,
                               std::size_t max = npos, const char* field = "") {
    const std::byte* const start = cursor_;
    std::int32_t number = 0;
    if (!get(number, field)) return false;
    if (number < 0) return fail_at(start, DecodeProblem::NegativeCount, field);
    const auto size = static_cast<std::size_t>(number);
    if (size > max) return fail_at(start, DecodeProblem::OverBound, field);
    if (min_bytes_each == 0) {
      if (size > max_zero_width) return fail_at(start, DecodeProblem::OverBound, field);
    } else if (size > remaining() / min_bytes_each) {
      return fail_at(start, DecodeProblem::Truncated, field);
    }
    count = size;
    return true;
  }

  /// Fills a span, vector or array with numbers. Swaps the bytes of all numbers at once, which is
  /// faster than reading one number after the other.
  template <typename Range>
  requires NumberRange<std::remove_reference_t<Range>>
  [[nodiscard]] bool get_array(Range&& numbers, const char* field = "") {
    constexpr std::size_t width = sizeof(*numbers.data());
    if (failed_) return false;
    if (numbers.size() > remaining() / width) return fail(DecodeProblem::Truncated, field);
    swap_copy<width>(reinterpret_cast<std::byte*>(numbers.data()), cursor_, numbers.size());
    cursor_ += numbers.size() * width;
    return true;
  }

  [[nodiscard]] bool get_bytes(std::span<std::byte> bytes, const char* field = "") {
    return get_array(bytes, field);
  }

  /// Reads `size` bytes without a copy: `view` refers to the bytes that were given to the decoder.
  [[nodiscard]] bool get_view(ByteView& view, std::size_t size, const char* field = "") {
    if (failed_) return false;
    if (size > remaining()) return fail(DecodeProblem::Truncated, field);
    view = ByteView(cursor_, size);
    cursor_ += size;
    return true;
  }

  /// Makes the next get_bulk() store in `octets` a view of the octets of a @bulk sequence, instead
  /// of a copy. The view refers to the bytes that were given to the decoder. `octets` must outlive
  /// the decoder.
  void keep_bulk(std::optional<ByteView>& octets) { bulk_ = &octets; }

  /// Reads a @bulk sequence of at most `max` octets into `octets`. After a call of keep_bulk(),
  /// leaves `octets` empty, because keep_bulk() has named another destination.
  [[nodiscard]] bool get_bulk(std::vector<std::uint8_t>& octets, std::size_t max,
                              const char* field) {
    std::size_t count = 0;
    ByteView view;
    if (!get_count(count, 1, max, field) || !get_view(view, count, field)) return false;
    if (bulk_ != nullptr && !bulk_->has_value()) {
      *bulk_ = view;
      octets.clear();
    } else {
      const auto* const first = reinterpret_cast<const std::uint8_t*>(view.data());
      octets.assign(first, first + view.size());
    }
    return true;
  }

  /// Skips the block of an appendable struct, and makes `inner` a decoder of the bytes in the
  /// block. Bytes that `inner` does not read come from a newer writer and are ignored.
  [[nodiscard]] bool open_block(Decoder& inner, const char* field = "") {
    std::size_t size = 0;
    if (!get_count(size, 1, npos, field)) return false;
    inner = *this;
    inner.end_ = cursor_ + size;
    cursor_ += size;
    return true;
  }

  /// Must be called after the struct was read from `inner`, the decoder that `open_block` made.
  /// Takes over the first error of `inner`. Returns true when neither decoder has an error.
  [[nodiscard]] bool close_block(const Decoder& inner) {
    if (!inner.failed_) return !failed_;
    if (failed_) return false;
    error_ = inner.error_;
    return give_up();
  }

  /// Must be called before a nested struct is read; a DepthGuard calls it. Fails when structs are
  /// nested more than `max_depth` levels deep.
  [[nodiscard]] bool enter(const char* field = "") {
    if (depth_ == max_depth) return fail(DecodeProblem::TooDeep, field);
    ++depth_;
    return true;
  }
  void leave() { --depth_; }

  /// Records that the value that was just read is invalid, unless there is an earlier error. Always
  /// returns false.
  bool fail(DecodeProblem problem, const char* field = "") {
    return fail_at(cursor_, problem, field);
  }

  /// Records that a value that was read earlier is invalid. `offset` is the position at which that
  /// value began: the result of `offset()` before the value was read.
  bool fail(DecodeProblem problem, const char* field, std::size_t offset) {
    return fail_at(begin_ + offset, problem, field);
  }

  /// Records that the decoder refuses `number`, which was read from the last `size` bytes. `limits`
  /// is a static text that says which numbers are valid: the range, or the known enumerators.
  /// Always returns false.
  bool fail_number(DecodeProblem problem, RefusedNumber number, const char* limits,
                   std::size_t size, const char* field);

  /// Returns true when no read failed and no bytes are left. Otherwise records an error.
  [[nodiscard]] bool expect_end() {
    if (failed_) return false;
    return cursor_ == end_ ? true : fail(DecodeProblem::TrailingBytes);
  }

  bool failed() const { return failed_; }
  bool at_end() const { return !failed_ && cursor_ == end_; }
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - cursor_); }
  std::size_t offset() const { return static_cast<std::size_t>(cursor_ - begin_); }

  /// Returns the first error. @pre a read failed
  const DecodeError& error() const { return error_; }

 private:
  bool fail_at(const std::byte* where, DecodeProblem problem, const char* field) {
    if (failed_) return false;
    error_ = DecodeError{problem, static_cast<std::size_t>(where - begin_), field};
    return give_up();
  }

  bool give_up() {
    failed_ = true;
    end_ = cursor_;  // nothing remains, so that every later read fails by its usual check
    return false;
  }

  const std::byte* begin_;
  const std::byte* cursor_;
  const std::byte* end_;
  int depth_ = 0;
  bool failed_ = false;
  std::optional<ByteView>* bulk_ = nullptr;
  DecodeError error_;
};

/// Makes a decoder count one more nesting level while the guard lives. Use it like this: `if
/// (DepthGuard guard(decoder); guard) …`.
class DepthGuard {
 public:
  explicit DepthGuard(Decoder& decoder, const char* field = "")
      : decoder_(decoder), entered_(decoder.enter(field)) {}
  ~DepthGuard() {
    if (entered_) decoder_.leave();
  }
  DepthGuard(const DepthGuard&) = delete;
  DepthGuard& operator=(const DepthGuard&) = delete;

  explicit operator bool() const { return entered_; }

 private:
  Decoder& decoder_;
  bool entered_;
};

}  // namespace gecos::wire
