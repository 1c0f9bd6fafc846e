// Converts values to and from objects of the JSON library. The header of that library takes seconds
// to compile. Code that needs only JSON text should include json_text.hpp.
#pragma once

#include <nlohmann/json.hpp>
#include <utility>

#include "gecos/wire/json_text.hpp"

namespace gecos::wire {

namespace json_detail {

bool check_depth(const nlohmann::json& data, JsonError& error);

}  // namespace json_detail

/// Returns `value` as a JSON object, not as text like `to_json_text`. The members of the object are
/// sorted by name.
template <class T>
nlohmann::json to_json(const T& value) {
  nlohmann::ordered_json draft;
  JsonShape<T>::write(JsonWriter(draft), value);
  return draft;
}

/// Converts a JSON object to a value, like `from_json_text`. Cannot detect a member that occurred
/// twice in the text, because `data` has only one member of each name.
template <class T>
tl::expected<T, JsonError> from_json(const nlohmann::json& data) {
  tl::expected<T, JsonError> result;
  JsonError error;
  const bool fine = json_detail::check_depth(data, error) &&
                    json_detail::read_checked<T>(JsonReader(data, error), &*result);
  if (!fine) result = tl::make_unexpected(std::move(error));
  return result;
}

}  // namespace gecos::wire
