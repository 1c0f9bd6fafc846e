// Checks whether the numbers in arrays and sequences are within a range.
#pragma once

#include <limits>

namespace gecos::wire {

/// The range from `low` to `high`, which includes both limits. NaN is outside every range.
template <class T>
struct Bounds {
  static constexpr bool is_float = std::numeric_limits<T>::has_infinity;
  T low = is_float ? -std::numeric_limits<T>::infinity() : std::numeric_limits<T>::min();
  T high = is_float ? std::numeric_limits<T>::infinity() : std::numeric_limits<T>::max();

  constexpr bool hold(T number) const { return (number >= low) & (number <= high); }
};

/// Returns a pointer to the first number outside `bounds`, or null if there is none. When all
/// numbers are within `bounds`, the function runs only one loop, which has no branches.
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
