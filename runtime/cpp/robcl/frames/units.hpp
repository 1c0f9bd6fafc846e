// Conversions from millimetres and degrees to SI units, and back. All other interfaces use SI
// units.
#pragma once

#include <numbers>

namespace robcl {

constexpr double mm(double millimetres) { return millimetres * 1e-3; }
constexpr double deg(double degrees) { return degrees * (std::numbers::pi / 180.0); }

/// Convert SI units to millimetres and degrees, for display. For example, `in_mm(0.2) == 200`.
constexpr double in_mm(double metres) { return metres * 1e3; }
constexpr double in_deg(double radians) { return radians * (180.0 / std::numbers::pi); }

/// Literals such as `200_mm` and `90_deg`, whose values are in metres and radians. A program must
/// write `using namespace robcl::literals;` to use them.
inline namespace literals {
constexpr double operator""_mm(long double value) { return mm(static_cast<double>(value)); }
constexpr double operator""_mm(unsigned long long value) { return mm(static_cast<double>(value)); }
constexpr double operator""_deg(long double value) { return deg(static_cast<double>(value)); }
constexpr double operator""_deg(unsigned long long value) {
  return deg(static_cast<double>(value));
}
}  // namespace literals

}  // namespace robcl
