// Plans random moves of an arm and prints them for beside_planners.py: one JSON object per line,
// the limits first.
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
using robcl::motion::Plan;

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
  std::cout << "}\n";
}

void print_joint_move(const JointValues& from, const JointValues& to, const Plan& plan) {
  std::cout << "{\"duration\": " << plan.law.duration() << ", ";
  print("from", from);
  std::cout << ", ";
  print("to", to);
  std::cout << "}\n";
}

/// Prints the path of the joints, too, which the other planners get.
void print_line(const robcl::Frame& start, const robcl::Frame& goal, const Plan& plan) {
  std::cout << "{\"duration\": " << plan.law.duration() << ", ";
  print("places", plan.path.places());
  std::cout << ", \"length\": " << distance(start, goal) << ", \"turn\": " << angle(start, goal)
            << ", ";
  std::vector<JointValues> joints;
  for (std::size_t i = 0; i <= plan.path.intervals(); ++i) joints.push_back(plan.path.knot(i));
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
  robcl::motion::Planner planner(arm->model, arm->tool_limits);
  std::mt19937 engine(1);
  std::cout << std::setprecision(17);
  print_limits(*arm);
  for (int lines = 0; lines < wanted;) {
    const JointValues from = random_joints(arm->model, engine);
    const JointValues to = random_joints(arm->model, engine);
    const auto start = planner.base_from_tool(from, {}), goal = planner.base_from_tool(to, {});
    const auto line = planner.straight(from, goal, {}, {});
    if (!line) continue;
    ++lines;
    print_line(start, goal, *line);
    print_joint_move(from, to, planner.joints(from, to, {}).value());
  }
}
