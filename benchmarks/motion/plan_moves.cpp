// Plans random moves of an arm, with and without its limit of jerk, and prints them for
// beside_planners.py: one JSON object per line, the limits first.
//
//   plan_moves ARM.toml COUNT

#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <random>
#include <vector>

#include "devices/arm/arm_file.hpp"
#include "motion/moves.hpp"
#include "robcl/motion/planner.hpp"

namespace {

using benchmarks::JointValues;
using benchmarks::print;
using benchmarks::random_joints;
using robcl::motion::Planner;

constexpr double cycle = 0.001;  // s: divides the time in which accelerations rise

/// Plans the moves of an arm.
struct Planners {
  Planner without_jerk_limit, with_jerk_limit;

  /// Prints the durations of a move.
  void print_durations(const robcl::motion::Move& move) const {
    std::cout << "{\"duration\": " << without_jerk_limit.plan(move).duration()
              << ", \"with_jerk_limit\": " << with_jerk_limit.plan(move).duration() << ", ";
  }
};

void print_limits(const devices::ArmDescription& arm) {
  std::vector<double> speeds, accelerations;
  for (const auto& limits : arm.model.limits()) {
    speeds.push_back(limits.speed);
    accelerations.push_back(limits.acceleration);
  }
  std::cout << '{';
  print("speeds", speeds);
  std::cout << ", ";
  print("accelerations", accelerations);
  const auto& tool = arm.tool_limits;
  std::cout << ", ";
  print("tool", std::vector<double>{tool.speed, tool.acceleration, tool.turn_speed,
                                    tool.turn_acceleration});
  std::cout << ", \"seconds_to_full_acceleration\": " << arm.seconds_to_full_acceleration << "}\n";
}

void print_joint_move(const Planners& planners, const JointValues& from, const JointValues& to,
                      const robcl::motion::Move& move) {
  planners.print_durations(move);
  print("from", from);
  std::cout << ", ";
  print("to", to);
  std::cout << "}\n";
}

/// Prints the path of the joints, too, which the other planners get.
void print_line(const Planners& planners, const robcl::motion::Move& move) {
  planners.print_durations(move);
  print("places", move.path.places());
  std::cout << ", \"length\": " << move.line->length() << ", \"turn\": " << move.line->turn()
            << ", ";
  std::vector<JointValues> joints;
  for (std::size_t i = 0; i <= move.path.intervals(); ++i) joints.push_back(move.path.knot(i));
  print("joints", joints);
  std::cout << "}\n";
}

}  // namespace

int main(int count, char** words) {
  if (count != 3) {
    std::cerr << "usage: plan_moves ARM.toml COUNT\n";
    return 2;
  }
  const auto arm = devices::read_arm(words[1]);
  if (!arm) {
    std::cerr << "plan_moves: " << to_string(arm.error()) << '\n';
    return 2;
  }
  const int wanted = std::atoi(words[2]);
  const double rise = arm->seconds_to_full_acceleration;
  Planners planners{
      Planner(arm->model, arm->tool_limits),
      Planner(arm->model, arm->tool_limits, robcl::motion::Smoothing::over(rise, cycle))};
  Planner& planner = planners.without_jerk_limit;
  std::mt19937 engine(1);
  std::cout << std::setprecision(17);
  print_limits(*arm);
  for (int lines = 0; lines < wanted;) {
    const JointValues from = random_joints(arm->model, engine);
    const JointValues to = random_joints(arm->model, engine);
    const auto line = planner.straight_move(from, planner.base_from_tool(to, {}), {}, {});
    if (!line) continue;
    ++lines;
    print_line(planners, *line);
    print_joint_move(planners, from, to, planner.joint_move(from, to, {}).value());
  }
}
