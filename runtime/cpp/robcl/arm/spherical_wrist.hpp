// Closed-form inverse kinematics of six-axis arms whose last three axes meet in one point.
//
// The geometry of the arm must be as follows. Axis 2 is at right angles to axis 1, and axis 3 is
// parallel to axis 2. Axes 4, 5 and 6 meet in the wrist centre, and axis 5 is at right angles to
// axes 4 and 6. Axis 2 may have an offset from axis 1, and so may the plane in which joints 2 and 3
// move the arm. All industrial six-axis arms of this kind have this geometry, for example the RX90
// and the Puma 560. The method is that of D. Pieper, "The Kinematics of Manipulators under Computer
// Control" (1968). Joints 1 to 3 alone place the wrist centre: they are a planar arm with two
// links, which joint 1 turns. Joints 4 to 6 are a ZYZ rotation, which gives the remaining
// orientation.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>

#include "robcl/arm/inverse.hpp"
#include "robcl/arm/kinematics.hpp"

namespace robcl::arm {

class SphericalWristInverse final : public InverseKinematics {
 public:
  /// Makes a solver for `model`. Returns null if the arm has another geometry, or if forward
  /// kinematics show that the solver's solutions for test poses are wrong. Throws
  /// std::invalid_argument if the joint positions `model.front()` are at a singularity, or have the
  /// elbow below the line from the shoulder to the wrist.
  static std::unique_ptr<SphericalWristInverse> for_arm(const ArmModel& model);

  tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                           const JointValues& reference,
                                           const Configuration& wanted) override;
  Configuration configuration(const JointValues& joints) override;
  bool has_configurations() const override { return true; }

  struct Solution {
    JointValues joints;  ///< within half a turn of the reference; may be outside the joint limits
    Configuration configuration;
  };
  struct Solutions {
    std::array<Solution, 8> each;
    std::size_t count = 0;
  };
  /// Returns all solutions in configurations that `wanted` admits, at most eight. At a singularity,
  /// some of the solutions are equal.
  Solutions all(const Frame& base_from_flange, const JointValues& reference,
                const Configuration& wanted = {}) const;

 private:
  explicit SphericalWristInverse(const ArmModel& model) : model_(model) {}

  bool measure_geometry();
  bool verify();
  void look_at_front();
  void add_wrists(const Frame& base_from_flange, const Eigen::Vector3d& first_three,
                  const JointValues& reference, Configuration configuration,
                  const Configuration& wanted, Solutions& found) const;
  std::string why_out_of_reach(const Frame& base_from_flange) const;

  ArmModel model_;

  // The following members are the geometry of the arm in the base frame while all joints are at
  // zero. Axes are unit vectors.
  std::array<Eigen::Vector3d, 6> axes_;
  Eigen::Matrix3d zero_turn_;        // orientation of the flange
  Eigen::Vector3d flange_to_wrist_;  // wrist centre, seen from the flange (constant)
  Eigen::Matrix3d base_from_plane_;  // columns: joint 1's direction, axis 2, axis 1
  Eigen::Vector3d origin_;           // point of axis 1 at the height of axis 2

  // The following members are lengths in m and angles in rad in the plane in which joints 2 and 3
  // move the arm. The angles are measured from axis 1 towards the direction of joint 1.
  double shoulder_ = 0;  // distance from axis 1 to axis 2
  double lateral_ = 0;   // offset of the wrist centre along axis 2
  double upper_arm_ = 0, upper_arm_angle_ = 0;
  double forearm_ = 0, forearm_angle_ = 0;
  double third_sign_ = 1;  // -1 if axis 3 points opposite to axis 2

  Eigen::Matrix3d base_from_wrist_;  // z along axis 4, y along axis 5
  double sixth_tilt_ = 0;            // angle from axis 4 to axis 6 about axis 5, at most 90 deg
  double sixth_sign_ = 1;            // -1 if sixth_tilt_ is measured to the reversed axis 6

  // The signs that the three measures in configuration.hpp have where the arm is righty, above and
  // noflip. If the model has no `front`, the arm is righty where the wrist is in the direction of
  // joint 1, and noflip where joint 5 is positive.
  double righty_ = 1, above_ = 1, noflip_ = 1;
};

}  // namespace robcl::arm
