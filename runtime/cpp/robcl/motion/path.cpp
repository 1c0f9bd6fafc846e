#include "robcl/motion/path.hpp"

#include <algorithm>
#include <cassert>

namespace robcl::motion {
namespace {

/// Returns the derivative at index `i` of values that are evenly spaced by `step`. The result is
/// accurate to fourth order in the interior, and to second order near the ends.
JointValues derivative(const std::vector<JointValues>& values, std::size_t i, double step) {
  const std::size_t last = values.size() - 1;
  if (last == 1) return (values[1] - values[0]) / step;
  if (i == 0) return (-3 * values[0] + 4 * values[1] - values[2]) / (2 * step);
  if (i == last) {
    return (3 * values[last] - 4 * values[last - 1] + values[last - 2]) / (2 * step);
  }
  if (i == 1 || i + 1 == last) return (values[i + 1] - values[i - 1]) / (2 * step);
  return (values[i - 2] - values[i + 2] + 8 * (values[i + 1] - values[i - 1])) / (12 * step);
}

}  // namespace

Path::Path(std::vector<JointValues> knots) : knots_(std::move(knots)) {
  assert(knots_.size() >= 2);
  slopes_.reserve(knots_.size());
  for (std::size_t i = 0; i < knots_.size(); ++i) slopes_.push_back(derivative(knots_, i, step()));
}

Path::Derivatives Path::derivatives(std::size_t interval, double part) const {
  const std::size_t i = interval;
  const double t = part;
  const JointValues chord = (knots_[i + 1] - knots_[i]) / step();
  return {
      6 * t * (1 - t) * chord + (1 - t) * (1 - 3 * t) * slopes_[i] +
          t * (3 * t - 2) * slopes_[i + 1],
      (6 * (1 - 2 * t) * chord + (6 * t - 4) * slopes_[i] + (6 * t - 2) * slopes_[i + 1]) / step()};
}

JointValues Path::position(double s) const {
  const double along = std::clamp(s, 0.0, 1.0) * static_cast<double>(intervals());
  const std::size_t i = std::min(static_cast<std::size_t>(along), intervals() - 1);
  const double t = along - static_cast<double>(i);
  const double rest = 1 - t;
  return (1 + 2 * t) * rest * rest * knots_[i] + t * rest * rest * step() * slopes_[i] +
         t * t * (3 - 2 * t) * knots_[i + 1] - t * t * rest * step() * slopes_[i + 1];
}

}  // namespace robcl::motion
