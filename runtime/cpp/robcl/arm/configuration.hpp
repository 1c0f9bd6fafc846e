// The eight ways in which a six-axis arm with a spherical wrist reaches one pose.
//
// With the wrist centre W, the shoulder S and the elbow E in the arm's plane (wx, ex horizontal
// along joint 1's direction, wz, ez heights above S): righty while wx > 0; above while
// sign(wx)·(wx·ez - wz·ex) > 0; noflip while joint 5, counted from where axes 4 and 6 are parallel,
// is > 0. Each measure is zero exactly at the shoulder, elbow and wrist singularity.
#pragma once

#include <iosfwd>
#include <optional>

namespace robcl::arm {

enum class Shoulder { Righty, Lefty };
enum class Elbow { Above, Below };
enum class Wrist { Noflip, Flip };

/// A demanded or a present configuration. An empty member: any value will do, or it is not defined.
struct Configuration {
  std::optional<Shoulder> shoulder{};
  std::optional<Elbow> elbow{};
  std::optional<Wrist> wrist{};

  /// Whether `other` is all that this asks for.
  bool admits(const Configuration& other) const;
  friend bool operator==(const Configuration&, const Configuration&) = default;
};

/// "righty, above, noflip"
std::ostream& operator<<(std::ostream& out, const Configuration& configuration);

}  // namespace robcl::arm
