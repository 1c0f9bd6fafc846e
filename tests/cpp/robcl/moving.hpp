// The arms that make random moves in tests, with and without a limit of jerk.
#pragma once

#include <cstdlib>
#include <vector>

#include "arms.hpp"

namespace robcl {

struct Moving {
  const char* name;
  arm::ArmModel (*model)();
  double rise;  ///< time in s in which an acceleration may rise to its limit; 0: no limit of jerk
};

inline const std::vector<Moving> all_moving{
    {"rx90", &rx90, 0.03},
    {"puma560", &puma560, 0.03},
    {"seven_axes", &seven_axes, 0.03},
    {"rx90_without_limit_of_jerk", &rx90, 0},
    {"puma560_without_limit_of_jerk", &puma560, 0},
    {"seven_axes_without_limit_of_jerk", &seven_axes, 0},
};

/// MOTION_MOVES says how many; there are a fifth as many without a limit of jerk.
inline int moves_to_try(const Moving& moving) {
  const char* const asked = std::getenv("MOTION_MOVES");
  const int moves = asked != nullptr ? std::atoi(asked) : 500;
  return moving.rise > 0 ? moves : moves / 5;
}

}  // namespace robcl
