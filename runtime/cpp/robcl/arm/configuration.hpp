// The eight configurations in which a six-axis arm with a spherical wrist can reach one pose.
//
// The definition uses the vertical plane in which the arm moves. d is the horizontal distance of
// the wrist centre W from axis 1, and is positive in the direction of joint 1. (wx, wz) and (ex,
// ez) are the horizontal distance and the height of W and of the elbow E, seen from the shoulder.
// The configuration is righty where d > 0, else lefty, above where sign(d)·(wx·ez - wz·ex) > 0,
// else below, noflip where joint 5, counted from the angle at which axes 4 and 6 are parallel, is >
// 0, else flip. Each of these three values is zero exactly at the singularity of the shoulder, of
// the elbow or of the wrist.
#pragma once

#include <iosfwd>
#include <optional>

namespace robcl::arm {

enum class Shoulder { Righty, Lefty };
enum class Elbow { Above, Below };
enum class Wrist { Noflip, Flip };

/// The wanted or the present configuration of an arm. In a wanted configuration, an empty member
/// allows any value. In a present configuration, a member is empty if its value is undefined at a
/// singularity.
struct Configuration {
  std::optional<Shoulder> shoulder{};
  std::optional<Elbow> elbow{};
  std::optional<Wrist> wrist{};

  /// Returns true if no member of `other` contradicts this configuration. An empty member
  /// contradicts nothing.
  bool admits(const Configuration& other) const;
  friend bool operator==(const Configuration&, const Configuration&) = default;
};

/// Prints a text such as "righty, above, noflip".
std::ostream& operator<<(std::ostream& out, const Configuration& configuration);

}  // namespace robcl::arm
