// Checks of the numbers in arrays and sequences against a range.
#pragma once

#include <limits>

namespace gecos::wire {

/// The range from `low` to `high`, both included. NaN is outside.
template <class T>
struct Bounds {
  static constexpr bool is_float = std::numeric_limits<T>::has_infinity;
  T low = is_float ? -std::numeric_limits<T>::infinity() : std::numeric_limits<T>::min();
  T high = is_float ? std::numeric_limits<T>::infinity() : std::numeric_limits<T>::max();

  constexpr bool hold(T number) const { return (number >= low) & (number <= high); }
};

/// A pointer to the first number outside `bounds`, or null. When all numbers are inside, only one
/// loop without branches runs.
template <class Numbers>
constexpr const typename Numbers::value_type* first_outside(
    const Numbers& numbers, Bounds<typename Numbers::value_type> bounds) {
  bool inside = true;
  for (const auto number : numbers) inside &= bounds.hold(number);
  if (inside) return nullptr;
  const auto* number = numbers.data();
  while (bounds.hold(*number)) ++number;
  return number;
}

}  // namespace gecos::wire
