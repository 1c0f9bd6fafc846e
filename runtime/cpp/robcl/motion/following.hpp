// Sensor-guided motion: corrections move the tool while it moves.
#pragma once

#include <cstdint>
#include <optional>

#include "robcl/arm/kinematics.hpp"
#include "robcl/arm/local_inverse.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/motion/joint_limiter.hpp"
#include "robcl/motion/pace.hpp"
#include "robcl/motion/tool_lead.hpp"
#include "robcl/motion/trajectory_generator.hpp"

namespace robcl::motion {

/// The axes along which a correction moves and turns the tool.
enum class CorrectionAxes {
  Tool,  ///< the axes of the tool: pose · correction
  Base   ///< the axes of the arm's base, about the origin of the tool
};

struct FollowLimits {
  ToolLimits tool{};
  /// The corrections together may move the tool target this far from where it was at the start, in
  /// m and rad.
  double distance = 0.5;
  double angle = deg(90);  ///< below pi
};

/// What became of the corrections so far.
struct FollowState {
  std::uint64_t applied = 0;  ///< corrections that have moved the target of the tool
  std::uint64_t dropped = 0;  ///< corrections beyond FollowLimits::distance or angle
  double distance_left = 0;   ///< m, from the tool to its target
  double angle_left = 0;      ///< rad, the same
  std::uint32_t limit_axis =
      0;                      ///< the arm holds because this axis, from 1, is at its limit; 0: no
  bool out_of_reach = false;  ///< the arm holds at the end of its reach or at a singularity
};

/// Where a Following gets its corrections. The control loop calls these functions once per cycle or
/// more often: they must neither allocate memory nor wait.
class CorrectionSource {
 public:
  virtual ~CorrectionSource() = default;
  /// Returns the oldest correction that was not returned yet; nullopt if there is none.
  virtual std::optional<Frame> next() = 0;
  /// Whether the corrections have stopped for longer than they may.
  virtual bool expired() = 0;
  /// Receives the state at the end of each cycle.
  virtual void report(const FollowState& state) = 0;
};

/// Moves the tool to a target that corrections shift. All corrections that wait are multiplied to
/// the target in order. The tool moves to the target within its limits of speed and acceleration,
/// so that what cannot be done in one cycle is done in the next ones; at the target it stands. It
/// never moves on without a correction. When the corrections have stopped for too long, the motion
/// brakes and ends.
///
/// The arm keeps its configuration. It holds in front of a joint limit, of the end of its reach and
/// of a singularity, and moves again when the target is back. A Following with an unlimited number
/// of joints in a row that jump is bounded too: JointLimiter keeps the limits of the joints.
class Following final : public TrajectoryGenerator {
 public:
  /// @pre the arm stands at `start`, inside its limits. `source` must outlive the motion.
  Following(const arm::ArmModel& model, const JointValues& start, const Frame& flange_from_tool,
            CorrectionAxes axes, const FollowLimits& limits, CorrectionSource& source);

  const JointValues& start() const override { return start_; }
  JointValues advance(double seconds) override;
  void stop() override { stopping_ = true; }
  void rest() override;
  bool standing() const override {
    return stopping_ && lead_.at_rest() && joints_.at_rest() && joints_.at_target();
  }
  bool stopping() const override { return stopping_; }
  /// A Following has no duration: its fraction and remaining time are always 0.
  double fraction() const override { return 0; }
  double remaining() const override { return 0; }

  /// Whether the motion ended because its source expired.
  bool expired() const { return expired_; }

 private:
  void take_corrections();
  void apply(const Frame& correction);
  bool try_towards_target(const ToolLimits& limits, double cycle);
  void brake(const ToolLimits& limits, double cycle);
  void put_lead_at(const JointValues& joints);
  void move_lead(const ToolLead& lead, const arm::LocalInverse::Solution& at, double cycle);
  ToolLimits limits_at(const arm::Kinematics::Place& place, const ToolLead& lead) const;
  arm::Jacobian tool_jacobian(const arm::Kinematics::Place& place) const;
  double bend_excess() const;
  bool can_stop(const ToolLead& lead, const JointValues& joints, const ToolLimits& limits,
                double cycle);
  bool may_stand_at(const arm::LocalInverse::Solution& there);
  std::optional<arm::LocalInverse::Solution> joints_at(const Frame& tool,
                                                       const JointValues& known) {
    return inverse_.solve(tool * tool_from_flange_, known);
  }
  void report();

  const arm::ArmModel model_;
  const JointValues start_;
  const Frame flange_from_tool_, tool_from_flange_;
  const CorrectionAxes axes_;
  const FollowLimits limits_;
  CorrectionSource& source_;
  arm::Kinematics forward_;
  arm::LocalInverse inverse_;

  Frame origin_;  // tool at the start
  Frame target_;  // the corrections have brought the tool here
  ToolLead lead_;
  arm::LocalInverse::Solution lead_at_;  // at the pose of lead_
  /// How the lead moved in the last cycle.
  struct LeadChange {
    JointValues speeds, accelerations;                   // rad/s, rad/s²
    arm::PoseStep acceleration = arm::PoseStep::Zero();  // of the tool, m/s² and rad/s²
  };
  LeadChange lead_change_;
  JointLimiter joints_;  // at lead_at_, unless a joint cannot follow
  FollowState state_;
  bool stopping_ = false;
  bool expired_ = false;
};

}  // namespace robcl::motion
