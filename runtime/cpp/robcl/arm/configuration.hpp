// The eight configurations in which a six-axis arm with a spherical wrist can reach one pose.
//
// A configuration is a posture that a person can see. It does not depend on the directions in which
// the joint angles count as positive. The model of an arm names joint positions `front` at which
// the arm is righty, above and noflip by definition: the elbow up, the wrist in front of the
// shoulder, the flange bent up from the forearm, as in the nominal pose qn of the Puma 560 (P.
// Corke). The direction "in front" is fixed to link 1: it turns with joint 1.
//
// The definition uses the vertical plane in which the arm moves. d is the horizontal distance of
// the wrist centre W from axis 1, and is positive in front. (wx, wz) and (ex, ez) are the
// horizontal distance and the height of W and of the elbow E, seen from the shoulder. The
// configuration is righty where d > 0, else lefty; above where sign(d)·(wx·ez - wz·ex) > 0, else
// below; noflip where joint 5, counted from the angle at which axes 4 and 6 are parallel, has the
// sign that it has at `front`, else flip. Each of these three measures is zero exactly at the
// singularity of the shoulder, of the elbow or of the wrist.
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
