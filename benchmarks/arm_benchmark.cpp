// How long a control cycle of an arm and the planning of a move take, how old a sample of the arm
// is when a client reads it, and how long a correction takes to the drives. README.md says how to
// read the tables.

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "benchmarks/own_directory.hpp"
#include "benchmarks/rounds.hpp"
#include "devices/arm/arm_controller.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "devices/rx90/rx90_files.hpp"
#include "devices/support/real_time.hpp"
#include "gecos/gecos.hpp"
#include "robcl/arm/spherical_wrist.hpp"
#include "robcl/motion/following.hpp"
#include "robcl/motion/planner.hpp"
#include "robcl/motion/playback.hpp"
#include "robcl/rx90_client.hpp"

namespace gecos::benchmarks {
namespace {

using namespace std::chrono_literals;
using robcl::translate;

constexpr double cycle = 0.004;  // s, of the served arm
const auto limited_jerk = robcl::motion::Smoothing::over(0.03, cycle);

class Times {
 public:
  void add(Microseconds time) { times_.push_back(time); }
  std::size_t count() const { return times_.size(); }

  void print(const char* what, const char* bar) {
    if (times_.empty()) throw std::runtime_error(std::string(what) + ": nothing was measured");
    std::sort(times_.begin(), times_.end());
    std::printf("| %s | %zu | %.1f | %.1f | %.1f | %s |\n", what, count(), at(0.5), at(0.99), at(1),
                bar);
  }

 private:
  double at(double quantile) const {
    const auto last = static_cast<double>(times_.size() - 1);
    return times_[static_cast<std::size_t>(quantile * last)].count();
  }

  std::vector<Microseconds> times_;
};

void print_head(const char* title) {
  std::printf("\n%s\n\n| | n | p50 us | p99 us | longest us | bar |\n|---|--:|--:|--:|--:|---|\n",
              title);
}

// The control cycle

robcl::arm::JointValues front() { return devices::parse_arm(devices::rx90_files).value().start; }

robcl::arm::ArmModel rx90() { return devices::parse_arm(devices::rx90_files).value().model; }

class RandomJoints {
 public:
  explicit RandomJoints(const robcl::arm::ArmModel& model) : model_(model) {}

  robcl::arm::JointValues operator()() {
    robcl::arm::JointValues joints(6);
    for (std::size_t i = 0; i < 6; ++i) {
      const auto& limits = model_.limits()[i];
      joints[static_cast<Eigen::Index>(i)] =
          std::uniform_real_distribution(limits.lower, limits.upper)(engine_);
    }
    return joints;
  }

 private:
  const robcl::arm::ArmModel& model_;
  std::mt19937 engine_{1};
};

/// A correction in each cycle, to and fro: .4 mm at .4 m/s for a cycle of 1 ms.
class ToAndFro final : public robcl::motion::CorrectionSource {
 public:
  std::optional<robcl::Frame> next() override {
    given_ = !given_;
    if (!given_) return std::nullopt;
    ++count_;
    return translate(0, count_ / 100 % 2 == 0 ? 0.0004 : -0.0004, 0);
  }
  bool expired() override { return false; }
  void report(const robcl::motion::FollowState&) override {}

 private:
  bool given_ = false;
  int count_ = 0;
};

/// How long each of `cycles` cycles takes while `generator` moves the arm; null: the arm stands.
Times cycles_with(std::shared_ptr<robcl::motion::TrajectoryGenerator> generator, int cycles) {
  devices::SimulatedDriver driver(front(), {.period = 0.001});
  devices::ArmController controller(rx90(), {}, driver);
  controller.step(0.001);
  if (generator) controller.start(std::move(generator));
  Times times;
  for (int i = 0; i < cycles; ++i) {
    const auto begun = std::chrono::steady_clock::now();
    controller.step(0.001);
    times.add(std::chrono::steady_clock::now() - begun);
  }
  return times;
}

void measure_cycles() {
  // As a control loop does.
  if (const auto missing = devices::make_real_time()) {
    std::printf("The control loop has %s.\n", missing->c_str());
  }
  print_head("A control cycle of the RX90, with simulated drives");
  constexpr int cycles = 20000;
  cycles_with(nullptr, cycles).print("the arm stands", "");
  const auto model = rx90();
  const robcl::Frame goal =
      robcl::arm::Kinematics(model).base_from_flange(front()) * translate(0, 0, 0.2);
  auto plan = robcl::motion::Planner(model, {}, limited_jerk)
                  .straight(front(), goal, robcl::Frame(), {.tool_speed = 0.02});
  cycles_with(std::make_shared<robcl::motion::Playback>(std::move(plan).value()), 9000)
      .print("straight move", "");
  cycles_with(std::make_shared<robcl::motion::Following>(
                  model, front(), robcl::Frame(), robcl::motion::CorrectionAxes::Tool,
                  robcl::motion::FollowLimits{}, std::make_shared<ToAndFro>()),
              cycles)
      .print("follow, a correction in each cycle", "p99 <= 10");
}

// The inverse

/// The closed-form inverse of the RX90, at random poses and at the stretched arm READY.
void measure_inverse() {
  print_head("The closed-form inverse of the RX90");
  const auto model = rx90();
  const auto solver = robcl::arm::SphericalWristInverse::for_arm(model);
  const robcl::arm::Kinematics forward(model);
  RandomJoints random(model);
  const auto measure = [&](const char* what, const char* bar, bool one, bool stretched) {
    constexpr int solves = 20;  // between two readings of the clock
    Times times;
    for (int i = 0; i < 20000; ++i) {
      robcl::arm::JointValues joints = random();
      if (stretched) joints << joints[0], 0, 0, 0, 0, joints[5];
      const auto pose = forward.base_from_flange(joints);
      const auto wanted = one ? solver->configuration(front()) : robcl::arm::Configuration{};
      std::size_t count = 0;
      const auto begun = std::chrono::steady_clock::now();
      for (int k = 0; k < solves; ++k) count += solver->all(pose, joints, wanted).count;
      const Microseconds all = std::chrono::steady_clock::now() - begun;
      if (count > 0) times.add(all / solves);
    }
    times.print(what, bar);
  };
  measure("one configuration", "p50 <= 1", true, false);
  measure("all eight", "p50 <= 2", false, false);
  measure("one configuration, stretched", "p50 <= 1", true, true);
  measure("all eight, stretched", "p50 <= 2", false, true);
}

// Planning

/// Plans random moves of the RX90 from anywhere to anywhere.
void measure_planning() {
  const auto model = rx90();
  robcl::motion::Planner planner(model, {}, limited_jerk);
  RandomJoints random(model);
  Times joint_moves, lines, refusals;
  while (lines.count() < 500) {
    const auto from = random(), to = random();
    const auto goal = planner.base_from_tool(to, {});
    auto begun = std::chrono::steady_clock::now();
    if (planner.joints(from, to, {})) joint_moves.add(std::chrono::steady_clock::now() - begun);
    begun = std::chrono::steady_clock::now();
    const bool possible = planner.straight(from, goal, {}, {}).has_value();
    (possible ? lines : refusals).add(std::chrono::steady_clock::now() - begun);
  }
  print_head("Planning a move of the RX90 from anywhere to anywhere");
  joint_moves.print("joint move", "p99 <= 10000");
  lines.print("straight move", "p99 <= 10000");
  refusals.print("a line that cannot be moved, refused", "p99 <= 10000");
}

// Between programs

/// The programs gecos-broker and robcl-rx90.
class ServedArm {
 public:
  ServedArm()
      : broker_([] { ::execl(GECOS_BENCHMARK_BROKER, GECOS_BENCHMARK_BROKER, nullptr); }),
        arm_([] { ::execl(GECOS_BENCHMARK_RX90, GECOS_BENCHMARK_RX90, nullptr); }) {}

 private:
  OtherProcess broker_;
  OtherProcess arm_;
};

robcl::Rx90 connect(Lab& lab) {
  const auto begun = std::chrono::steady_clock::now();
  for (;;) {
    auto created = lab.create<robcl::Rx90>("RX90");
    if (created) return *created;
    if (std::chrono::steady_clock::now() - begun > 20s) {
      throw std::runtime_error(created.error().to_string());
    }
  }
}

Times ages_of_samples(robcl::Rx90& robot, int samples) {
  auto joints = robot.joints(gecos::stream).value();
  Times ages;
  for (int i = 0; i < samples; ++i) {
    const auto sample = joints.next(1s);
    if (!sample) throw std::runtime_error("a stream of the arm ended");
    ages.add(sample->age);
  }
  return ages;
}

double commanded(const gecos::Sample<robcl::Joints>& sample) { return sample.value.position[0]; }

/// The times from the sending of a correction to the cycle whose set points move by it. The arm
/// stands before each.
Times corrections_to_set_points(robcl::Rx90& robot, int tries) {
  const auto lease = gecos::actor(robot);
  if (!lease) throw std::runtime_error(lease.error().failure.text);
  auto alter = robot.alter(gecos::writer).value();
  const auto follow = robot.follow(robcl::FollowMode::IN_TOOL);
  alter.feeds(follow);
  while (!follow.feedback() && follow.wait_for(1ms) == gecos::State::Running) {
  }
  auto stream = robot.commanded_joints(gecos::stream).value();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> phase(0, cycle);
  Times times;
  for (int i = 0; i < tries; ++i) {
    // A few cycles in which the arm comes to stand, then some part of a cycle.
    double held = 0;
    for (int standing = 0; standing < 4;) {
      const double now = commanded(stream.next(1s).value());
      standing = now == held ? standing + 1 : 0;
      held = now;
    }
    const auto at = std::chrono::steady_clock::now() + std::chrono::duration<double>(phase(random));
    while (std::chrono::steady_clock::now() < at) {
    }
    const auto sent = std::chrono::steady_clock::now();
    // Sideways, so that joint 1 turns.
    if (!alter.send(translate(0, i % 2 == 0 ? 0.0001 : -0.0001, 0))) {
      throw std::runtime_error(follow.get().error().text);
    }
    for (;;) {
      const auto sample = stream.next(1s).value();
      if (commanded(sample) == held) continue;
      times.add(std::chrono::steady_clock::now() - sample.age - sent);
      break;
    }
  }
  return times;
}

void measure_between_programs() {
  const OwnDirectory directory;
  const ServedArm served;
  Lab lab;
  auto robot = connect(lab);
  print_head("A client of robcl-rx90 over shared memory; the arm's cycle is 4 ms");
  ages_of_samples(robot, 5000).print("age of a sample when it is read", "p99 <= 500");
  corrections_to_set_points(robot, 1000).print("from a correction to the drives", "p99 <= 4100");
}

}  // namespace
}  // namespace gecos::benchmarks

int main() {
  try {
    // On a thread of its own, so that the client below has no real-time priority.
    std::thread(gecos::benchmarks::measure_cycles).join();
    gecos::benchmarks::measure_inverse();
    gecos::benchmarks::measure_planning();
    gecos::benchmarks::measure_between_programs();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "arm_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}
