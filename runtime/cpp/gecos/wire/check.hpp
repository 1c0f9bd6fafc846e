// Error texts for values that must not be sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include "gecos/wire/bounds.hpp"
#include "gecos/wire/decode_error.hpp"
#include "gecos/wire/text.hpp"

namespace gecos::wire {

/// Returns a question for an error text when `value` probably has the wrong unit, for example "; is
/// the value in degrees?". Otherwise returns an empty text. There is a question when `value` is
/// outside the range from `low` to `high`, but would be inside it as a number of degrees (if `unit`
/// is "rad") or of millimetres (if `unit` is "m"). A number of at most pi is probably meant in rad,
/// and a number below 1 in m; there is then no question. The sign of `value` does not matter for
/// these two limits.
std::string_view mistaken_unit(double value, double low, double high, std::string_view unit);

template <class T>
RefusedNumber refused_number(T number) {
  if constexpr (std::is_floating_point_v<T>) {
    return double{number};
  } else if constexpr (std::is_unsigned_v<T>) {
    return std::uint64_t{number};
  } else {
    return std::int64_t{number};
  }
}

/// Returns an error text such as "110 is outside [-2.0, 2.0] rad; is the value in degrees?" or "3
/// is outside [-2.0, 2.0] rad; give at most 2.0 rad".
std::string outside_limits(RefusedNumber number, std::string_view limits);

/// Returns an error text such as "7 is no Speed; give one of SLOW, FAST". In this example, `known`
/// is "no Speed; give one of SLOW, FAST".
std::string none_of(RefusedNumber number, std::string_view known);

/// Returns an error text such as "Trajectory.speed: 3 is outside [0.01, 1.0] m/s; give at most 1.0
/// m/s".
std::string out_of_range(std::string_view field, RefusedNumber number, std::string_view limits);

template <class T>
std::string out_of_range(std::string_view field, T number, std::string_view limits) {
  return out_of_range(field, refused_number(number), limits);
}

/// Returns an error text for the element at `index`, such as "Joints.position[2]: 3 is outside
/// [-2.0, 2.0] rad; …".
std::string element_out_of_range(std::string_view field, std::ptrdiff_t index, RefusedNumber number,
                                 std::string_view limits);

/// Returns the error text for the element to which `outlier` points. This element must be one of
/// `numbers`.
template <class Numbers>
std::string element_out_of_range(std::string_view field, const Numbers& numbers,
                                 const typename Numbers::value_type* outlier,
                                 std::string_view limits) {
  return element_out_of_range(field, outlier - numbers.data(), refused_number(*outlier), limits);
}

/// Returns an error text such as "Scan.echoes: 500 elements, at most 360 fit; shorten it". `what`
/// is "elements" or "bytes".
std::string over_bound(std::string_view field, std::size_t size, std::size_t bound,
                       std::string_view what);

/// Returns an error text such as "Pose.name: the string is not UTF-8 or contains NUL; convert it to
/// UTF-8".
std::string bad_text(std::string_view field);

/// Returns an error text such as "Shape: the value does not agree with the union's discriminator;
/// make …".
std::string wrong_arm(std::string_view type);

}  // namespace gecos::wire
