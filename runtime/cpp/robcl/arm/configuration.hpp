// The eight configurations in which a six-axis arm with a spherical wrist can reach one pose.
//
// In the arm's plane, d is the horizontal distance of the wrist centre W from axis 1, positive in
// joint 1's direction. (wx, wz) and (ex, ez) are W and the elbow E, seen from the shoulder:
// horizontal distance and height. The configuration is
//   righty where d > 0, else lefty,
//   above where sign(d)·(wx·ez - wz·ex) > 0, else below,
//   noflip where joint 5, counted from the angle at which axes 4 and 6 are parallel, is > 0, else
//   flip.
// Each of these values is zero exactly at the singularity of the shoulder, the elbow or the wrist.
#pragma once

#include <iosfwd>
#include <optional>

namespace robcl::arm {

enum class Shoulder { Righty, Lefty };
enum class Elbow { Above, Below };
enum class Wrist { Noflip, Flip };

/// A wanted or a present configuration. An empty member means: any value (wanted), or undefined at
/// a singularity (present).
struct Configuration {
  std::optional<Shoulder> shoulder{};
  std::optional<Elbow> elbow{};
  std::optional<Wrist> wrist{};

  /// Whether no member of `other` contradicts this configuration; empty members contradict nothing.
  bool admits(const Configuration& other) const;
  friend bool operator==(const Configuration&, const Configuration&) = default;
};

/// Prints for example "righty, above, noflip".
std::ostream& operator<<(std::ostream& out, const Configuration& configuration);

}  // namespace robcl::arm
