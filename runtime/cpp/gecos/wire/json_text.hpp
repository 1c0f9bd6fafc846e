// Converts values to and from JSON text, for people, logs and tools. The form is the same as that
// of Python's gecos.wire.json.
//
// Members and enumerators are written by name, bitmasks as lists of flags, unions as {"tag": …,
// "value": …}, maps as lists of pairs, octets as lists of numbers, NaN and infinities as "nan",
// "inf" and "-inf". 64-bit integers are exact. Secrets are written as "***". A program that uses
// this header must also include "<file>_json.hpp" of the interface, and must link the interface's
// library `…_json`.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "gecos/base/result.hpp"
#include "gecos/wire/json_shapes.hpp"

namespace gecos::wire {

/// The maximum nesting depth of JSON values. JSON that is nested more deeply is refused.
inline constexpr int json_depth = 100;

namespace json_detail {

std::string text(const void* value, const JsonKind& kind, int indent);
/// Parses `text` and calls `read` with the value. Fails if `text` is not JSON or is nested too
/// deeply.
bool parse(std::string_view text, JsonError& error, bool (*read)(const JsonReader&, void*),
           void* target);
/// Returns true when `violation`, the result of `gecos_violation`, is empty. Otherwise stores
/// `violation` in `error`.
bool allowed(const std::string& violation, JsonError& error);

template <class T>
bool read_checked(const JsonReader& from, void* target) {
  T& value = *static_cast<T*>(target);
  if (!JsonShape<T>::read(from, value)) return false;
  if constexpr (layout::Listed<T>) {
    return allowed(layout::violation(value), from.error());
  } else {
    return allowed(violation_of(value), from.error());
  }
}

}  // namespace json_detail

/// Returns `value` as JSON text. The members are in the order of the interface. The text is one
/// line, or several lines when `indent` is 0 or more. Invalid UTF-8 in a string becomes U+FFFD.
/// Never fails; for example, an unknown enumerator is written as its number.
template <class T>
std::string to_json_text(const T& value, int indent = -1) {
  return json_detail::text(&value, json_kind<T>, indent);
}

/// Converts JSON text to a value. Fails when the text does not fit the type T, when a number is
/// outside its range or when a string is too long; the error names the member. Missing members get
/// their default values. A member that occurs twice is refused.
template <class T>
tl::expected<T, JsonError> from_json_text(std::string_view text) {
  tl::expected<T, JsonError> result;
  JsonError error;
  const bool fine = json_detail::parse(text, error, &json_detail::read_checked<T>, &*result);
  if (!fine) result = tl::make_unexpected(std::move(error));
  return result;
}

}  // namespace gecos::wire
