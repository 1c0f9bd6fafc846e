// Values as objects of the JSON library, whose header takes a compiler seconds to read; where text
// is enough, json_text.hpp is.
#pragma once

#include <nlohmann/json.hpp>
#include <utility>

#include "gecos/wire/json_text.hpp"

namespace gecos::wire {

namespace json_detail {

bool check_depth(const nlohmann::json& data, JsonError& error);

}  // namespace json_detail

/// As `to_json_text`, with the members sorted by their names.
template <class T>
nlohmann::json to_json(const T& value) {
  nlohmann::ordered_json draft;
  JsonShape<T>::write(JsonWriter(draft), value);
  return draft;
}

/// As `from_json_text`; which members stood there twice is no longer known.
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
