#include "gecos/wire/check.hpp"

#include <array>
#include <charconv>

namespace gecos::wire {

namespace {

template <class Number>
std::string outside(std::string_view field, Number value, std::string_view range) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  std::string text(field);
  text.append(": ").append(digits.data(), end).append(" is outside ").append(range);
  return text;
}

}  // namespace

std::string out_of_range(std::string_view field, double value, std::string_view range) {
  return outside(field, value, range);
}

std::string out_of_range(std::string_view field, long long value, std::string_view range) {
  return outside(field, value, range);
}

std::string out_of_range(std::string_view field, unsigned long long value, std::string_view range) {
  return outside(field, value, range);
}

std::string over_bound(std::string_view field, std::size_t size, std::size_t bound,
                       std::string_view what) {
  std::string text(field);
  text.append(": ").append(std::to_string(size)).append(" ").append(what);
  text.append(", at most ").append(std::to_string(bound)).append(" fit");
  return text;
}

std::string bad_text(std::string_view field) {
  return std::string(field) + ": the string is not UTF-8 or contains NUL";
}

std::string wrong_arm(std::string_view type) {
  return std::string(type) + ": the value does not agree with the union's discriminator";
}

}  // namespace gecos::wire
