// Sensor-guided motion: a program moves the target of the tool by corrections while the tool moves.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/motion/arm_lead.hpp"
#include "robcl/motion/joint_limiter.hpp"
#include "robcl/motion/pace.hpp"
#include "robcl/motion/trajectory_generator.hpp"

namespace robcl::motion {

/// The axes along which a correction moves and turns the tool.
enum class CorrectionAxes {
  Tool,  ///< the axes of the tool: pose · correction
  Base   ///< the axes of the arm's base, about the origin of the tool
};

struct FollowLimits {
  ToolLimits tool{};
  /// All corrections together may move the target of the tool by at most this distance and angle
  /// from its place at the start, in m and rad.
  double distance = 0.5;
  double angle = deg(90);  ///< below pi
};

/// The effects of the corrections so far.
struct FollowState {
  std::uint64_t applied = 0;  ///< corrections that have moved the target of the tool
  std::uint64_t dropped = 0;  ///< corrections beyond FollowLimits::distance or angle
  double distance_left = 0;   ///< m, from the tool to its target
  double angle_left = 0;      ///< rad, the same
  Hold hold{};                ///< why the arm does not move to the target
};

/// The source of the corrections of a Following. The control loop calls these functions once per
/// cycle or more often: they must neither allocate memory nor wait.
class CorrectionSource {
 public:
  virtual ~CorrectionSource() = default;
  /// Returns the oldest correction that was not returned yet; nullopt if there is none.
  virtual std::optional<Frame> next() = 0;
  /// Returns whether the time since the last correction is longer than the source allows.
  virtual bool expired() = 0;
  /// Receives the state at the end of each cycle.
  virtual void report(const FollowState& state) = 0;
};

/// Moves the tool to a target that corrections shift. In each cycle, all waiting corrections are
/// applied to the target in order. The tool moves to the target within its limits of speed and
/// acceleration, over several cycles if necessary, and stops when it has reached the target.
/// Without a correction the target does not move. If no correction comes for too long, the motion
/// brakes and ends.
///
/// The arm keeps its configuration. It stops before a joint limit, the end of its reach or a
/// singularity, and moves again when the target has come back. The joints keep their limits in
/// every case.
class Following final : public TrajectoryGenerator {
 public:
  /// @pre the arm stands at `start`, inside its limits, and `source` is not null.
  Following(const arm::ArmModel& model, const JointValues& start, const Frame& flange_from_tool,
            CorrectionAxes axes, const FollowLimits& limits,
            std::shared_ptr<CorrectionSource> source);

  const JointValues& start() const override { return start_; }
  JointValues advance(double seconds) override;
  /// Scales the limits of the tool's speed.
  void set_override(double factor) override { override_ = factor; }
  void stop() override { stopping_ = true; }
  void rest() override;
  bool standing() const override {
    return stopping_ && lead_.at_rest() && joints_.at_rest() && joints_.at_target();
  }
  bool stopping() const override { return stopping_; }
  /// A Following has no duration: its fraction and remaining time are always 0.
  double fraction() const override { return 0; }
  double remaining() const override { return 0; }

  /// Returns whether the motion ended because its source expired.
  bool expired() const { return expired_; }

 private:
  void take_corrections();
  void apply(const Frame& correction);
  void report(const Hold& hold);

  const JointValues start_;
  const CorrectionAxes axes_;
  const FollowLimits limits_;
  const std::shared_ptr<CorrectionSource> source_;

  ArmLead lead_;
  const Frame origin_;   // tool at the start
  Frame target_;         // the corrections have brought the tool here
  JointLimiter joints_;  // at the lead, unless a joint cannot follow
  FollowState state_;
  double override_ = 1;
  bool stopping_ = false;
  bool expired_ = false;
};

}  // namespace robcl::motion
