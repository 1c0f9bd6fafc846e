// Converts values to and from objects of the JSON library, whose header takes seconds to compile.
// When text is enough, include json_text.hpp instead.
#pragma once

#include <nlohmann/json.hpp>
#include <utility>

#include "gecos/wire/json_text.hpp"

namespace gecos::wire {

namespace json_detail {

bool check_depth(const nlohmann::json& data, JsonError& error);

}  // namespace json_detail

/// Like `to_json_text`, but gives an object, whose members are sorted by name.
template <class T>
nlohmann::json to_json(const T& value) {
  nlohmann::ordered_json draft;
  JsonShape<T>::write(JsonWriter(draft), value);
  return draft;
}

/// Like `from_json_text`, but cannot detect duplicate members: `data` has only one of each.
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
