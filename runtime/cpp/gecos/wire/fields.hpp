// Functions that decode composite values. Generated decoders call one of them for each member.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "gecos/wire/bounds.hpp"
#include "gecos/wire/check.hpp"
#include "gecos/wire/decoder.hpp"

namespace gecos::wire {

/// Reads an appendable value from its block. Skips members that a newer writer appended.
template <class T>
[[nodiscard]] bool get_block(Decoder& from, T& value, const char* field) {
  Decoder block;
  if (!from.open_block(block, field)) return false;
  const bool decoded = value.decode(block);
  return from.close_block(block) && decoded;
}

/// Skips the members that a newer writer appended to an appendable value. @pre `from` contains only
/// the block of this value.
inline bool skip_rest(Decoder& from) {
  ByteView rest;
  return from.get_view(rest, from.remaining());
}

/// Reads a sequence of numbers: first the count, then the numbers.
template <class T>
[[nodiscard]] bool get_numbers(Decoder& from, std::vector<T>& numbers, std::size_t max,
                               const char* field) {
  std::size_t count = 0;
  if (!from.get_count(count, sizeof(T), max, field)) return false;
  numbers.resize(count);
  return from.get_array(numbers, field);
}

/// Reads a sequence of elements: first the count, then each element by a call of `get(T&)`.
template <class T, class Get>
[[nodiscard]] bool get_sequence(Decoder& from, std::vector<T>& elements, std::size_t min_bytes_each,
                                std::size_t max, const char* field, Get&& get) {
  std::size_t count = 0;
  if (!from.get_count(count, min_bytes_each, max, field)) return false;
  elements.assign(count, T{});
  for (std::size_t i = 0; i < count; ++i) {
    if constexpr (std::is_same_v<T, bool>) {
      bool element = false;
      if (!get(element)) return false;
      elements[i] = element;
    } else {
      if (!get(elements[i])) return false;
    }
  }
  return true;
}

/// Reads every element of an array of fixed size by a call of `get(T&)`.
template <class Array, class Get>
[[nodiscard]] bool get_each(Array& elements, Get&& get) {
  for (auto& element : elements) {
    if (!get(element)) return false;
  }
  return true;
}

/// Reads whether an optional value is present, and then the value by a call of `get(T&)`.
template <class T, class Get>
[[nodiscard]] bool get_optional(Decoder& from, std::optional<T>& value, const char* field,
                                Get&& get) {
  bool present = false;
  value.reset();
  if (!from.get(present, field)) return false;
  return !present || get(value.emplace());
}

/// Reads a map: first the count, then the entries. The keys must be strictly ascending, so that
/// each map has only one encoding.
template <class Key, class T, class Order, class GetKey, class Get>
[[nodiscard]] bool get_map(Decoder& from, std::map<Key, T, Order>& entries,
                           std::size_t min_bytes_each, std::size_t max, const char* field,
                           GetKey&& get_key, Get&& get) {
  std::size_t count = 0;
  entries.clear();
  if (!from.get_count(count, min_bytes_each, max, field)) return false;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t offset = from.offset();
    Key key{};
    if (!get_key(key)) return false;
    if (!entries.empty() && !entries.key_comp()(entries.rbegin()->first, key)) {
      return from.fail(DecodeProblem::UnsortedMap, field, offset);
    }
    if (!get(entries.emplace_hint(entries.end(), std::move(key), T{})->second)) return false;
  }
  return true;
}

/// Returns `valid`. If `valid` is false, records that the number that was just read is out of
/// range. `size` is the size of that number in bytes.
[[nodiscard]] inline bool in_range(Decoder& from, bool valid, std::size_t size, const char* field) {
  return valid || from.fail(DecodeProblem::OutOfRange, field, from.offset() - size);
}

/// Returns whether the number that was just read lies within `bounds`. If not, records an error.
/// `limits` is the static text of the range, for example "[0.01, 1.0] m/s".
template <class T>
[[nodiscard]] bool within(Decoder& from, T number, std::type_identity_t<Bounds<T>> bounds,
                          const char* field, const char* limits) {
  return bounds.hold(number) || from.fail_number(DecodeProblem::OutOfRange, refused_number(number),
                                                 limits, sizeof(T), field);
}

/// Like `within`, for all numbers of an array or sequence that was just read.
template <class Numbers>
[[nodiscard]] bool all_within(Decoder& from, const Numbers& numbers,
                              Bounds<typename Numbers::value_type> bounds, const char* field,
                              const char* limits) {
  const auto* const outlier = first_outside(numbers, bounds);
  if (outlier == nullptr) return true;
  const auto after = static_cast<std::size_t>(numbers.data() + numbers.size() - outlier);
  return from.fail_number(DecodeProblem::OutOfRange, refused_number(*outlier), limits,
                          after * sizeof *outlier, field);
}

/// Refuses the number that was just read, because the enum has no enumerator with this number.
/// `known` is static text with the known enumerators.
[[nodiscard]] inline bool no_enumerator(Decoder& from, std::int32_t number, const char* known,
                                        const char* field) {
  return from.fail_number(DecodeProblem::UnknownEnumerator, refused_number(number), known,
                          sizeof number, field);
}

/// Reads the discriminator (tag) of a union, which is encoded as a number of the type `Wire`.
/// Refuses a number that the type of the discriminator cannot represent.
template <class Wire, class Tag>
[[nodiscard]] bool get_tag(Decoder& from, Tag& tag, const char* field) {
  using Narrow = std::conditional_t<std::is_same_v<Tag, char>, unsigned char, Tag>;
  const std::size_t offset = from.offset();
  Wire number{};
  if (!from.get(number, field)) return false;
  const auto narrow = static_cast<Narrow>(number);
  tag = static_cast<Tag>(narrow);
  return static_cast<Wire>(narrow) == number ||
         from.fail(DecodeProblem::UnknownUnionTag, field, offset);
}

/// Reads whether a member (arm) of a union is present. Fails unless the member is present exactly
/// when the discriminator selects it.
[[nodiscard]] inline bool get_arm(Decoder& from, bool selected, const char* field) {
  const std::size_t offset = from.offset();
  bool present = false;
  if (!from.get(present, field)) return false;
  return present == selected || from.fail(DecodeProblem::UnknownUnionTag, field, offset);
}

}  // namespace gecos::wire
