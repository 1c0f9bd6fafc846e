#include "gecos/wire/check.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

namespace gecos::wire {

namespace {

/// Returns the number at the beginning of `text`, for example 0.01 for "0.01". The text comes from
/// gidl, so it always begins with a number.
double bound_of(std::string_view text) {
  double bound = 0;
  std::from_chars(text.data(), text.data() + text.size(), bound);
  return bound;
}

/// Returns advice about a number that is outside `limits`: the question of `mistaken_unit`, or a
/// text such as "; give at least 0.01 m".
std::string advice(double number, std::string_view limits) {
  const auto comma = limits.find(", "), end = limits.find(']');
  if (comma == limits.npos || end == limits.npos) return {};
  const auto low = limits.substr(1, comma - 1), high = limits.substr(comma + 2, end - comma - 2);
  const auto unit = limits.substr(end + 1);  // " m", or empty
  const auto question =
      mistaken_unit(number, bound_of(low), bound_of(high), unit.empty() ? unit : unit.substr(1));
  if (!question.empty()) return std::string(question);
  const auto give = [&](std::string text, std::string_view bound) {
    return text.append(bound).append(unit);
  };
  if (number < bound_of(low)) return give("; give at least ", low);
  if (number > bound_of(high)) return give("; give at most ", high);
  return std::isnan(number) ? "; give a number" : "";
}

std::string shown(RefusedNumber number) {
  return std::visit(
      [](auto value) {
        std::array<char, 32> digits;
        return std::string(digits.data(),
                           std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
      },
      number);
}

}  // namespace

std::string_view mistaken_unit(double value, double low, double high, std::string_view unit) {
  const auto fits = [&](double meant) { return meant >= low && meant <= high; };
  const double size = std::abs(value);
  if (fits(value)) return {};
  if (unit == "rad" && size > std::numbers::pi && fits(value * std::numbers::pi / 180)) {
    return "; is the value in degrees?";
  }
  if (unit == "m" && size >= 1 && fits(value / 1000)) return "; is the value in millimetres?";
  return {};
}

std::string outside_limits(RefusedNumber number, std::string_view limits) {
  const double value = std::visit([](auto each) { return static_cast<double>(each); }, number);
  return shown(number).append(" is outside ").append(limits).append(advice(value, limits));
}

std::string none_of(RefusedNumber number, std::string_view known) {
  return shown(number).append(" is ").append(known);
}

std::string out_of_range(std::string_view field, RefusedNumber number, std::string_view limits) {
  return std::string(field).append(": ").append(outside_limits(number, limits));
}

std::string element_out_of_range(std::string_view field, std::ptrdiff_t index, RefusedNumber number,
                                 std::string_view limits) {
  const auto element = std::string(field) + "[" + std::to_string(index) + "]";
  return out_of_range(element, number, limits);
}

std::string over_bound(std::string_view field, std::size_t size, std::size_t bound,
                       std::string_view what) {
  std::string text(field);
  text.append(": ").append(std::to_string(size)).append(" ").append(what);
  text.append(", at most ").append(std::to_string(bound)).append(" fit; shorten it");
  return text;
}

std::string bad_text(std::string_view field) {
  return std::string(field) + ": the string is not UTF-8 or contains NUL; convert it to UTF-8";
}

std::string wrong_arm(std::string_view type) {
  return std::string(type) +
         ": the value does not agree with the union's discriminator; make it with one of the "
         "functions make_…";
}

}  // namespace gecos::wire
