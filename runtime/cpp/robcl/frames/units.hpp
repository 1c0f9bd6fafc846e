// Conversions for millimetres and degrees. All other interfaces use SI units.
#pragma once

#include <numbers>

namespace robcl {

constexpr double mm(double millimetres) { return millimetres * 1e-3; }
constexpr double deg(double degrees) { return degrees * (std::numbers::pi / 180.0); }

/// Convert back, for display: `in_mm(0.2) == 200`.
constexpr double in_mm(double metres) { return metres * 1e3; }
constexpr double in_deg(double radians) { return radians * (180.0 / std::numbers::pi); }

/// `using namespace robcl::literals;` makes `200_mm` and `90_deg` metres and radians.
inline namespace literals {
constexpr double operator""_mm(long double value) { return mm(static_cast<double>(value)); }
constexpr double operator""_mm(unsigned long long value) { return mm(static_cast<double>(value)); }
constexpr double operator""_deg(long double value) { return deg(static_cast<double>(value)); }
constexpr double operator""_deg(unsigned long long value) {
  return deg(static_cast<double>(value));
}
}  // namespace literals

}  // namespace robcl
