#include "robcl/motion/smoothing.hpp"

#include <cmath>

namespace robcl::motion {

Smoothing Smoothing::over(double rise, double cycle) {
  constexpr double rounding = 1e-6;
  const double cycles = std::ceil(rise / cycle - rounding);
  if (cycles <= 1) return {};
  return {static_cast<std::size_t>(cycles), cycles * cycle, rise};
}

}  // namespace robcl::motion
