// The closed-form inverse of six-axis arms whose last three axes meet in one point.
//
// Geometry (all industrial six-axis arms of this kind, the RX90 and the Puma 560 among them): axis
// 2 is at right angles to axis 1, axis 3 parallel to axis 2, axes 4, 5, 6 meet in the wrist centre
// with axis 5 at right angles to both others. Offsets between axes 1 and 2, and of the arm's plane,
// are allowed. Solved after D. Pieper, "The Kinematics of Manipulators under Computer Control"
// (1968): the wrist centre depends on joints 1 to 3 only (a plane arm with two links, turned by
// joint 1), what is left to turn is a ZYZ rotation by joints 4 to 6.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>

#include "robcl/arm/inverse.hpp"
#include "robcl/arm/kinematics.hpp"

namespace robcl::arm {

class SphericalWristInverse final : public InverseKinematics {
 public:
  /// Null when the arm has another geometry, or when FK(IK) does not come back to the pose.
  static std::unique_ptr<SphericalWristInverse> for_arm(const ArmModel& model);

  tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                           const JointValues& reference,
                                           const Configuration& wanted) override;
  Configuration configuration(const JointValues& joints) override;

  struct Solution {
    JointValues joints;  ///< copies nearest the reference, limits not looked at
    Configuration configuration;
  };
  struct Solutions {
    std::array<Solution, 8> each;
    std::size_t count = 0;
  };
  /// All up to eight solutions. At a singularity two of them are the same.
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
  Eigen::Matrix3d zero_turn_;        // of the flange
  Eigen::Vector3d flange_to_wrist_;  // wrist centre, seen from the flange: never moves
  Eigen::Matrix3d base_from_plane_;  // columns: joint 1's direction, axis 2, axis 1
  Eigen::Vector3d origin_;           // on axis 1, as high as axis 2

  // In the arm's plane: lengths, m, and angles from axis 1 towards joint 1's direction, rad.
  double shoulder_ = 0;  // from axis 1 to axis 2
  double lateral_ = 0;   // offset of the wrist centre along axis 2
  double upper_arm_ = 0, upper_arm_angle_ = 0;
  double forearm_ = 0, forearm_angle_ = 0;
  double third_sign_ = 1;  // -1 where axis 3 points against axis 2

  Eigen::Matrix3d base_from_wrist_;  // z along axis 4, y along axis 5
  double sixth_tilt_ = 0;            // of axis 6 from axis 4 about axis 5, at most 90 degrees
  double sixth_sign_ = 1;            // -1 where the tilt was measured to axis 6 reversed
};

}  // namespace robcl::arm
