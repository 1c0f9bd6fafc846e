// Inverse kinematics for small steps: stays near the present joint positions.
#pragma once

#include <Eigen/Cholesky>
#include <optional>

#include "robcl/arm/joint_values.hpp"
#include "robcl/arm/kinematics.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"

namespace robcl::arm {

/// The difference of two poses: the distance along each axis in m, and the rotation as its axis
/// times its angle, in rad.
using PoseStep = Eigen::Matrix<double, 6, 1>;

/// Returns the step from the pose `from` to the pose `to`, in the coordinate system from which both
/// poses are seen. The angle of the rotation is at most pi.
PoseStep step_between(const Frame& from, const Frame& to);

/// The damped inverse of a Jacobian matrix. Never allocates memory.
class DampedInverse {
 public:
  explicit DampedInverse(const Jacobian& jacobian);

  /// Returns the joint speeds, in rad/s, that give the twist `twist`, in m/s and rad/s, to the
  /// point for which the Jacobian matrix was computed. If several joint speeds are possible, as for
  /// an arm with more than six joints, returns the smallest ones. At a singularity the speeds are
  /// large but finite.
  JointValues joint_speeds(const PoseStep& twist) const {
    return jacobian_.transpose() * PoseStep(root_.solve(twist));
  }
  /// Returns a measure of the distance to the nearest singularity; 0 at a singularity. The measure
  /// is roughly the least speed, in m/s or rad/s, of the point for which the Jacobian matrix was
  /// computed, if the vector of the joint speeds has the length 1 rad/s.
  double singularity_distance() const;

 private:
  using Square = Eigen::Matrix<double, 6, 6>;

  Jacobian jacobian_;
  Square square_;
  Eigen::LLT<Square> root_;
};

/// Finds the joint positions for a pose of the tool near a pose whose joint positions are known.
/// The solution is near the known joint positions, so that the arm keeps its configuration and no
/// joint makes a whole turn. Works for every arm; an arm with more than six joints moves as little
/// as possible.
///
/// The method is Newton's, with the damped inverse of the Jacobian matrix (Y. Nakamura and H.
/// Hanafusa, "Inverse Kinematic Solutions with Singularity Robustness for Robot Manipulator
/// Control", 1986). Never allocates memory.
class LocalInverse {
 public:
  /// The accuracy of a solution, in m and rad, unless the caller accepts a lower one.
  static constexpr double accuracy = 1e-10;
  /// The greatest angle, in rad, by which the position of a joint in a solution may differ from its
  /// known position.
  static constexpr double furthest = 0.5;

  explicit LocalInverse(const ArmModel& model, const Frame& flange_from_tool = {})
      : forward_(model, flange_from_tool) {}

  struct Solution {
    JointValues joints;
    Frame base_from_tool;
    DampedInverse inverse;  ///< inverse of the tool's Jacobian matrix at `joints`
  };
  /// Returns the solution whose joint positions are `joints`.
  Solution at(const JointValues& joints) const;
  /// Returns joint positions that put the tool at `base_from_tool`. Returns nullopt if the search
  /// finds none within `furthest` of the joint positions of `known`, for example beyond the reach
  /// of the arm or near a singularity. Does not check the limits of the joints.
  std::optional<Solution> solve(const Frame& base_from_tool, const Solution& known,
                                double tolerance = accuracy) const;

 private:
  static constexpr int most_steps = 8;

  const Kinematics forward_;
};

}  // namespace robcl::arm
