// Functions that print the members of generated types for people and logs. No program parses the
// text.
#pragma once

#include <array>
#include <cstdint>
#include <iomanip>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

namespace gecos::wire {

template <class T>
void print(std::ostream& out, const T& value) {
  out << value;
}
inline void print(std::ostream& out, bool value) { out << (value ? "true" : "false"); }
inline void print(std::ostream& out, std::uint8_t value) { out << static_cast<int>(value); }
inline void print(std::ostream& out, std::int8_t value) { out << static_cast<int>(value); }
inline void print(std::ostream& out, const std::string& value) { out << std::quoted(value); }

template <class T>
void print(std::ostream& out, const std::optional<T>& value);
template <class T>
void print(std::ostream& out, const std::vector<T>& values);
template <class T, std::size_t size>
void print(std::ostream& out, const std::array<T, size>& values);
template <class Key, class T, class Order>
void print(std::ostream& out, const std::map<Key, T, Order>& entries);

template <class Range>
void print_range(std::ostream& out, const Range& values) {
  const char* separator = "";
  out << '[';
  for (const auto& value : values) {
    out << separator;
    print(out, value);
    separator = ", ";
  }
  out << ']';
}

template <class T>
void print(std::ostream& out, const std::optional<T>& value) {
  if (value) {
    print(out, *value);
  } else {
    out << "none";
  }
}

template <class T>
void print(std::ostream& out, const std::vector<T>& values) {
  print_range(out, values);
}

template <class T, std::size_t size>
void print(std::ostream& out, const std::array<T, size>& values) {
  print_range(out, values);
}

template <class Key, class T, class Order>
void print(std::ostream& out, const std::map<Key, T, Order>& entries) {
  const char* separator = "";
  out << '{';
  for (const auto& [key, value] : entries) {
    out << separator;
    print(out, key);
    out << ": ";
    print(out, value);
    separator = ", ";
  }
  out << '}';
}

/// Prints the parts one after the other. A part that is a string literal is printed unchanged, and
/// any other part as a value.
template <class... Parts>
std::ostream& print_all(std::ostream& out, const Parts&... parts) {
  const auto put = [&out](const auto& part) {
    if constexpr (std::is_array_v<std::remove_reference_t<decltype(part)>>) {
      out << part;
    } else {
      print(out, part);
    }
  };
  (put(parts), ...);
  return out;
}

}  // namespace gecos::wire
