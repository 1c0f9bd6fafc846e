// Solves random poses of an arm with a spherical wrist by the closed form and by KDL's solver, and
// prints a JSON object for beside_solvers.py: the poses, and the times of each solve.
//
//   solve_poses ARM.toml COUNT

#include <chrono>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <kdl/chainiksolverpos_lma.hpp>
#include <random>
#include <vector>

#include "devices/arm/arm_file.hpp"
#include "motion/moves.hpp"
#include "robcl/arm/kinematics.hpp"
#include "robcl/arm/spherical_wrist.hpp"

namespace {

using benchmarks::JointValues;
using benchmarks::print;

/// Solves, and remembers how long that took and how often it succeeded.
class Solver {
 public:
  template <class Solve>
  void solve(Solve solve) {
    const auto begun = std::chrono::steady_clock::now();
    const bool solved = solve();
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begun;
    times_.push_back(took.count());
    solved_ += solved ? 1 : 0;
  }
  void print(const char* name) const {
    std::cout << '"' << name << "\": {\"solved\": " << solved_ << ", ";
    benchmarks::print("us", times_);
    std::cout << '}';
  }

 private:
  std::vector<double> times_;
  int solved_ = 0;
};

Eigen::Matrix<double, 6, 1> weights() {
  Eigen::Matrix<double, 6, 1> each;
  each << 1, 1, 1, 0.1, 0.1, 0.1;
  return each;
}

}  // namespace

int main(int count, char** words) {
  if (count != 3) {
    std::cerr << "usage: solve_poses ARM.toml COUNT\n";
    return 2;
  }
  const auto arm = devices::read_arm(words[1]);
  if (!arm) {
    std::cerr << "solve_poses: " << to_string(arm.error()) << '\n';
    return 2;
  }
  const auto closed_form = robcl::arm::SphericalWristInverse::for_arm(arm->model);
  if (!closed_form) {
    std::cerr << "solve_poses: " << arm->description << " has no spherical wrist\n";
    return 2;
  }
  robcl::arm::Kinematics forward(arm->model);
  const KDL::Chain chain = arm->model.chain();
  KDL::ChainIkSolverPos_LMA kdl(chain, weights(), 1e-8, 500);
  std::mt19937 engine(1);
  const auto anywhere = [&] { return benchmarks::random_joints(arm->model, engine); };
  Solver one, all, by_kdl;
  std::vector<JointValues> poses, references;
  for (int i = std::atoi(words[2]); i > 0; --i) {
    poses.push_back(anywhere());
    references.push_back(anywhere());
    const robcl::Frame pose = forward.base_from_flange(poses.back());
    const auto wanted = closed_form->configuration(poses.back());
    one.solve([&] { return closed_form->solve(pose, references.back(), wanted).has_value(); });
    all.solve([&] { return closed_form->all(pose, references.back()).count > 0; });
    KDL::JntArray from(static_cast<unsigned>(arm->model.axes())), answer(from.rows());
    from.data = references.back();
    const KDL::Frame goal = robcl::arm::to_kdl(pose);
    by_kdl.solve([&] {
      return kdl.CartToJnt(from, goal, answer) == KDL::SolverI::E_NOERROR &&
             near(forward.base_from_flange(answer.data), pose, 1e-6, 1e-5);
    });
  }
  std::cout << std::setprecision(17) << '{';
  print("poses", poses);
  std::cout << ", ";
  print("references", references);
  std::cout << std::setprecision(5) << ", ";
  one.print("one");
  std::cout << ", ";
  all.print("all");
  std::cout << ", ";
  by_kdl.print("kdl");
  std::cout << "}\n";
}
