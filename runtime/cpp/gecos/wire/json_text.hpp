// Values as JSON text, for people, logs and tools: what Python's gecos.wire.json writes and takes.
//
// Members and enumerators stand by their names, bitmasks as lists of flags, unions as
// {"tag": …, "value": …}, maps as lists of pairs, octets as lists of numbers; whole numbers of
// 64 bits are exact, "nan", "inf" and "-inf" stand for themselves. Secrets are "***".
// Include this and "<file>_json.hpp" of the interface; link the interface's library `…_json`.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "gecos/base/result.hpp"
#include "gecos/wire/json_shapes.hpp"

namespace gecos::wire {

/// Nested deeper, JSON is refused.
inline constexpr int json_depth = 100;

namespace json_detail {

std::string text(const void* value, const JsonKind& kind, int indent);
/// Calls `read` with what the text says, unless it is no JSON, or nested too deep.
bool parse(std::string_view text, JsonError& error, bool (*read)(const JsonReader&, void*),
           void* target);
/// The text of `gecos_violation` as an error; false unless it is empty.
bool allowed(const std::string& violation, JsonError& error);

template <class T>
bool read_checked(const JsonReader& from, void* target) {
  T& value = *static_cast<T*>(target);
  if (!JsonShape<T>::read(from, value)) return false;
  if constexpr (requires { gecos_violation(value); }) {
    return allowed(gecos_violation(value), from.error());
  }
  return true;
}

}  // namespace json_detail

/// Members in the order of the interface, on one line; over lines with an `indent` of 0 or more.
/// Invalid UTF-8 in a string becomes U+FFFD. Never fails: an enumerator that the enum does not have
/// stands as its number.
template <class T>
std::string to_json_text(const T& value, int indent = -1) {
  return json_detail::text(&value, json_kind<T>, indent);
}

/// The error names the member, also for what must not be sent: a number out of its range, a text
/// too long. Members that are left out have their defaults; a member that is there twice is
/// refused.
template <class T>
tl::expected<T, JsonError> from_json_text(std::string_view text) {
  tl::expected<T, JsonError> result;
  JsonError error;
  const bool fine = json_detail::parse(text, error, &json_detail::read_checked<T>, &*result);
  if (!fine) result = tl::make_unexpected(std::move(error));
  return result;
}

}  // namespace gecos::wire
