#include "robcl/motion/line_path.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <variant>

#include "robcl/arm/local_inverse.hpp"
#include "robcl/motion/pose_walk.hpp"

namespace robcl::motion {
namespace {

using arm::Failure;
using arm::JointLimit;
using arm::OutOfReach;
using arm::Singular;

constexpr double joint_jump = 0.1;  // rad per joint between the closest knots; else the line fails
constexpr std::size_t most_parts = 8;  // of an interval, where joints turn fast
/// If the tool is further than this distance, in m, from its line, the path is made again with more
/// knots, at most `finest` times.
constexpr double near_line = mm(0.04);
constexpr int finest = 2;
constexpr std::size_t fewest = 50, most = 4000;

Failure with_place(Failure failure, const arm::PlaceOnLine& where) {
  if (auto* reach = std::get_if<OutOfReach>(&failure)) {
    reach->reason = to_string(where) + ": " + reach->reason;
  } else if (auto* limit = std::get_if<JointLimit>(&failure)) {
    limit->place = where;
  }
  return failure;
}

/// Returns `failure` with the limits of the joint in `model`.
Failure with_limits_of(const arm::ArmModel& model, Failure failure) {
  if (auto* limit = std::get_if<JointLimit>(&failure)) {
    const arm::JointLimits& limits = model.limits()[limit->axis - 1];
    limit->lower = limits.lower;
    limit->upper = limits.upper;
  }
  return failure;
}

Singular leaves_line(const arm::PlaceOnLine& where, double away) {
  std::ostringstream text;
  text << to_string(where)
       << ": the joints would have to turn so fast that the tool leaves its line"
       << " by " << std::fixed << std::setprecision(3) << in_mm(away)
       << " mm; avoid the singularity or use a joint move";
  return Singular{text.str()};
}

/// By how much a joint turns, in rad.
struct Turn {
  Eigen::Index axis = 0;
  double angle = 0;
};

/// Computes the joint positions for the places on a line, one place after the other.
class LineWalk {
 public:
  /// `finer`: the number of times that the usual distance between knots is halved.
  LineWalk(const arm::ArmModel& model, arm::InverseKinematics& inverse, const Line& line,
           const Frame& tool_from_flange, const JointValues& from, int finer)
      : model_(model),
        walk_(model, inverse, from),
        line_(line),
        tool_from_flange_(tool_from_flange),
        furthest_(std::ldexp(joint_step, -finer)),
        most_parts_(most_parts << finer) {}

  /// Returns by how much a joint may turn between two knots, in rad.
  double furthest() const { return furthest_; }

  /// Walks from the fraction `start` of the line to its fraction `end`. Adds to `knots` as many
  /// knots as this part of the line needs. Where a joint turns fast, the knots are closer together.
  tl::expected<void, Failure> walk(double start, double end, double duration, Path::Knots& knots) {
    const PoseWalk::Place begin = walk_.at();
    for (std::size_t parts = 1;; parts *= 2) {
      const double each = (end - start) / static_cast<double>(parts);
      const bool closest = parts == most_parts_;
      const std::size_t known = knots.places.size();
      std::size_t done = 0;
      for (; done < parts; ++done) {
        const bool last = done + 1 == parts;
        const double part = last ? end : start + static_cast<double>(done + 1) * each;
        const JointValues before = walk_.at().joints;
        const auto turn = step_to(part);
        if (!turn) return tl::unexpected(turn.error());
        if (turn->angle > (closest ? joint_jump : furthest_)) {
          if (closest) return tl::unexpected(why_so_far(before, *turn, part, each));
          break;
        }
        knots.add(part * duration, walk_.at().joints);
      }
      if (done == parts) return {};
      walk_.return_to(begin);
      knots.places.resize(known);
      knots.joints.resize(known);
    }
  }

 private:
  /// Steps to the fraction `part` of the line. Returns the joint that turns most on this step. If a
  /// joint would have to turn very far on this step, and to a position beyond its limit, returns
  /// this joint and not the failure JointLimit, because the cause is a singularity.
  tl::expected<Turn, Failure> step_to(double part) {
    const JointValues before = walk_.at().joints;
    const auto failure = walk_.step_to(line_.at(part) * tool_from_flange_);
    Turn turn;
    if (!failure) {
      turn.angle = (walk_.at().joints - before).cwiseAbs().maxCoeff(&turn.axis);
      return turn;
    }
    if (const auto* limit = std::get_if<JointLimit>(&*failure)) {
      turn.axis = static_cast<Eigen::Index>(limit->axis) - 1;
      const double from = before[turn.axis];
      turn.angle = std::abs(arm::nearest_angle(limit->value, from) - from);
      if (turn.angle > joint_jump) return turn;
    }
    return tl::unexpected(with_place(*failure, line_.place(part)));
  }

  /// Returns why the joint positions at the fraction `part` of the line are so far from `before`.
  /// The cause is the limit of a joint if the solution next to `before` is outside the limits of
  /// the joints: a solver without configurations then returns a distant solution. Otherwise the
  /// cause is a singularity.
  Failure why_so_far(const JointValues& before, const Turn& turn, double part, double each) const {
    const arm::LocalInverse near(model_);
    const auto next = near.solve(line_.at(part) * tool_from_flange_, near.at(before));
    if (next && (next->joints - before).cwiseAbs().maxCoeff() <= joint_jump) {
      if (auto outside = arm::first_outside(model_, next->joints)) {
        outside->configuration = walk_.at().kept;
        return with_place(*outside, line_.place(part));
      }
    }
    return too_fast(turn, part, each);
  }

  Singular too_fast(const Turn& turn, double part, double each) const {
    std::ostringstream text;
    text << to_string(line_.place(part)) << ": joint " << turn.axis + 1 << " would have to turn "
         << std::fixed << std::setprecision(1) << in_deg(turn.angle) << " deg within "
         << std::setprecision(2);
    if (line_.length() > 0) {
      text << in_mm(line_.length() * each) << " mm";
    } else {
      text << in_deg(line_.turn() * each) << " deg";
    }
    text << "; avoid the singularity or use a joint move";
    return Singular{text.str()};
  }

  const arm::ArmModel& model_;
  PoseWalk walk_;
  const Line& line_;
  const Frame tool_from_flange_;
  const double furthest_;
  const std::size_t most_parts_;
};

/// Makes a path of the joints that puts the tool on its line at each knot of the path. `model` has
/// the limits of the joints; those of `walk` may be wider.
tl::expected<Path, Failure> path_of(LineWalk& walk, const arm::ArmModel& model,
                                    arm::InverseKinematics& inverse, const JointValues& from,
                                    const LineOnPath& way) {
  const Line& line = way.line;
  const double steps = std::ceil(std::max(line.length() / line_step, line.turn() / turn_step));
  const auto intervals = std::clamp(static_cast<std::size_t>(std::max(steps, 1.0)), fewest, most);
  Path::Knots knots;
  knots.add(0, from);
  const auto part = [&](std::size_t i) {
    return static_cast<double>(i) / static_cast<double>(intervals);
  };
  for (std::size_t i = 0; i < intervals; ++i) {
    if (auto walked = walk.walk(part(i), part(i + 1), way.duration, knots); !walked) {
      return tl::unexpected(with_limits_of(model, walked.error()));
    }
  }
  Path path(std::move(knots));
  if (auto outside = first_outside(model, path)) {
    outside->limit.configuration = inverse.configuration(path.position(outside->s));
    return tl::unexpected(with_place(outside->limit, line.place(outside->s / way.duration)));
  }
  return path;
}

/// Makes the path of path_of_line(). `model` has the limits of the joints; those of `walked`, which
/// are also the limits of `inverse`, may be wider.
tl::expected<LinePath, Failure> path_within(const arm::ArmModel& model, const arm::ArmModel& walked,
                                            const arm::Kinematics& forward,
                                            arm::InverseKinematics& inverse,
                                            const JointValues& from, const LineOnPath& line) {
  const Frame tool_from_flange = line.flange_from_tool.inverse();
  for (int finer = 0;; ++finer) {
    LineWalk walk(walked, inverse, line.line, tool_from_flange, from, finer);
    auto path = path_of(walk, model, inverse, from, line);
    if (!path) return tl::unexpected(path.error());
    std::vector<WayAndTurn> bends, faster;
    double furthest = 0, where = 0;  // m and s
    for (std::size_t i = 0; i < path->intervals(); ++i) {
      const LineDeviation deviation = deviation_in(*path, i, line, forward);
      bends.push_back(deviation.bend(path->step(i)));
      faster.push_back(deviation.faster);
      if (deviation.furthest() <= furthest) continue;
      furthest = deviation.furthest();
      where = path->place(i);
    }
    if (furthest <= (finer < finest ? near_line : line_tolerance)) {
      return LinePath{*std::move(path), walk.furthest(), std::move(bends), std::move(faster)};
    }
    if (finer == finest) {
      return tl::unexpected(leaves_line(line.line.place(where / line.duration), furthest));
    }
  }
}

}  // namespace

tl::expected<LinePath, Failure> path_of_line(const arm::ArmModel& model,
                                             const arm::Kinematics& forward,
                                             arm::InverseKinematics& inverse,
                                             const JointValues& from, const LineOnPath& line) {
  if (!arm::first_outside(model, from)) {
    return path_within(model, model, forward, inverse, from, line);
  }
  // The solvers find only joint positions inside the limits of their model. The path is found with
  // wider limits, and path_of() then checks it with those of `model`.
  const arm::ArmModel wider = model.with_travel_to(from);
  const auto inverse_of_wider = arm::make_inverse(wider);
  return path_within(model, wider, forward, *inverse_of_wider, from, line);
}

}  // namespace robcl::motion
