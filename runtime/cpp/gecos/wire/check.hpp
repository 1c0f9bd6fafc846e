// Error texts for values that must not be sent.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "gecos/wire/bounds.hpp"
#include "gecos/wire/text.hpp"

namespace gecos::wire {

/// The text "Trajectory.speed: 3 is outside [0.01, 1.0]".
std::string out_of_range(std::string_view field, double value, std::string_view range);
std::string out_of_range(std::string_view field, long long value, std::string_view range);
std::string out_of_range(std::string_view field, unsigned long long value, std::string_view range);

/// The text "Scan.echoes: 500 elements, at most 360 fit". `what` is "elements" or "bytes".
std::string over_bound(std::string_view field, std::size_t size, std::size_t bound,
                       std::string_view what);

/// The text "Pose.name: the string is not UTF-8 or contains NUL".
std::string bad_text(std::string_view field);

/// The text "Shape: the value does not agree with the union's discriminator".
std::string wrong_arm(std::string_view type);

}  // namespace gecos::wire
