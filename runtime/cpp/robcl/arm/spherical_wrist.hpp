// Closed-form inverse kinematics of six-axis arms whose last three axes meet in one point.
//
// Geometry (all industrial six-axis arms of this kind, the RX90 and the Puma 560 among them): axis
// 2 is at right angles to axis 1, axis 3 parallel to axis 2, axes 4, 5, 6 meet in the wrist centre
// with axis 5 at right angles to both others. Offsets between axes 1 and 2, and of the arm's plane,
// are allowed. Solved after D. Pieper, "The Kinematics of Manipulators under Computer Control"
// (1968): joints 1 to 3 alone place the wrist centre (a planar arm with two links, turned by joint
// 1); joints 4 to 6 are a ZYZ rotation that gives the remaining orientation.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>

#include "robcl/arm/inverse.hpp"
#include "robcl/arm/kinematics.hpp"

namespace robcl::arm {

class SphericalWristInverse final : public InverseKinematics {
 public:
  /// Returns null if the arm has another geometry, or if forward kinematics of the solutions does
  /// not reproduce test poses.
  static std::unique_ptr<SphericalWristInverse> for_arm(const ArmModel& model);

  tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                           const JointValues& reference,
                                           const Configuration& wanted) override;
  Configuration configuration(const JointValues& joints) override;

  struct Solution {
    JointValues joints;  ///< each within half a turn of the reference; limits are not checked
    Configuration configuration;
  };
  struct Solutions {
    std::array<Solution, 8> each;
    std::size_t count = 0;
  };
  /// All solutions, at most eight. At a singularity, some solutions are equal.
  Solutions all(const Frame& base_from_flange, const JointValues& reference) const;

 private:
  explicit SphericalWristInverse(const ArmModel& model) : model_(model) {}

  bool measure_geometry();
  bool verify();
  void add_wrists(const Frame& base_from_flange, const Eigen::Vector3d& first_three,
                  const JointValues& reference, Configuration configuration,
                  Solutions& found) const;
  std::string why_out_of_reach(const Frame& base_from_flange) const;

  ArmModel model_;

  // Geometry of the arm with all joints at zero, in the base frame. Axes are unit vectors.
  std::array<Eigen::Vector3d, 6> axes_;
  Eigen::Matrix3d zero_turn_;        // orientation of the flange
  Eigen::Vector3d flange_to_wrist_;  // wrist centre, seen from the flange (constant)
  Eigen::Matrix3d base_from_plane_;  // columns: joint 1's direction, axis 2, axis 1
  Eigen::Vector3d origin_;           // point of axis 1 at the height of axis 2

  // In the arm's plane: lengths in m, and angles in rad from axis 1 towards joint 1's direction.
  double shoulder_ = 0;  // distance from axis 1 to axis 2
  double lateral_ = 0;   // offset of the wrist centre along axis 2
  double upper_arm_ = 0, upper_arm_angle_ = 0;
  double forearm_ = 0, forearm_angle_ = 0;
  double third_sign_ = 1;  // -1 if axis 3 points opposite to axis 2

  Eigen::Matrix3d base_from_wrist_;  // z along axis 4, y along axis 5
  double sixth_tilt_ = 0;            // angle from axis 4 to axis 6 about axis 5, at most 90 deg
  double sixth_sign_ = 1;            // -1 if sixth_tilt_ is measured to the reversed axis 6
};

}  // namespace robcl::arm
