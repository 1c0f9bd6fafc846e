// JSON of structs from the list of their members: what generated `<file>_json.cpp` instantiates.
#pragma once

#include <array>
#include <string_view>
#include <tuple>

#include "gecos/wire/json_shapes.hpp"

namespace gecos::wire {

template <class Owner, class T>
struct JsonMember {
  std::string_view name;
  T Owner::*place;

  template <class Value>
  void write(JsonWriter to, const Value& value) const {
    to.member(name, value.*place);
  }
  template <class Value>
  bool read(const JsonReader& from, Value& value) const {
    return from.member(name, value.*place);
  }
};

/// A member whose value is never shown.
template <class Owner, class T>
struct JsonSecret {
  std::string_view name;
  T Owner::*place;

  template <class Value>
  void write(JsonWriter to, const Value& /*value*/) const {
    to.hidden_member(name);
  }
  template <class Value>
  bool read(const JsonReader& from, Value& value) const {
    return from.hidden_member(name, value.*place);
  }
};

/// A std::tuple of the members of T, those of its bases first.
template <class T>
constexpr int json_members = 0;

template <class T>
void JsonStruct<T>::write(JsonWriter to, const T& value) {
  to.open_object();
  std::apply([&](const auto&... each) { (each.write(to, value), ...); }, json_members<T>);
}

template <class T>
bool JsonStruct<T>::read(const JsonReader& from, T& value) {
  return std::apply(
      [&](const auto&... each) {
        const std::array<std::string_view, sizeof...(each)> names{each.name...};
        return from.expect_object(names) && (each.read(from, value) && ...);
      },
      json_members<T>);
}

}  // namespace gecos::wire
