// The hand-over of the paper (Fig. 4): robot A gives a block to robot B in the air, and takes it
// back.

#include <iomanip>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/gripper_client.hpp"
#include "robcl/manipulator_client.hpp"
#include "robcl/world_client.hpp"

using namespace robcl::literals;
using robcl::Frame;

namespace {

// Where the robots stand, in the world: they face each other.
const Frame base_a;
const Frame base_b = Frame::from_euler_zyz(1500_mm, 0, 0, 180_deg, 0_deg, 0_deg);

// Tool frames. A tool approaches along its z axis. T, where the block is handed over, is A's: its
// z axis points to B. B's is T * D: the same place, face to face.
const Frame block = Frame::from_euler_zyz(500_mm, 200_mm, 50_mm, 0_deg, 180_deg, 0_deg);
const Frame T = Frame::from_euler_zyz(750_mm, 0, 600_mm, 0_deg, 90_deg, 0_deg);
const Frame D = Frame::from_euler_zyz(0, 0, 0, 0_deg, 180_deg, 0_deg);
const Frame in_front = robcl::translate(0, 0, -150_mm);

const robcl::Trajectory straight{.speed = 0.5, .path = robcl::PathType::STRAIGHT};

template <class Result>
auto value(Result result) {
  if (!result) {
    std::ostringstream why;
    why << result.error();
    throw std::runtime_error(why.str());
  }
  if constexpr (!std::is_void_v<typename Result::value_type>) return *std::move(result);
}

/// Waits for a command; throws the reason if the command fails.
template <class Command>
auto done(const Command& command) {
  return value(command.get());
}

/// An arm with its gripper, and the status to command both.
struct Robot {
  Robot(gecos::Lab& lab, const std::string& name)
      : arm(value(lab.create<robcl::Manipulator>(name))),
        gripper(value(lab.create<robcl::Gripper>("GRIPPER_" + name))) {}

  /// Moves to a place 150 mm in front of `tool`, then straight to `tool`.
  void approach(const Frame& tool) const {
    done(arm.move(tool * in_front));
    done(arm.move(tool, straight));
  }
  void retreat(const Frame& tool) const { done(arm.move(tool * in_front, straight)); }
  void grip() const { done(gripper.close(30)); }
  void release() const { done(gripper.open(100_mm)); }

  robcl::Manipulator arm;
  robcl::Gripper gripper;
  gecos::Lease arm_lease = value(gecos::actor(arm));
  gecos::Lease gripper_lease = value(gecos::actor(gripper));
};

/// Both arms are at the block, `giver` holds it.
void hand_over(const Robot& giver, const Robot& taker, const robcl::World& world,
               const Frame& meeting) {
  const Frame before = done(world.find("BLOCK")).pose;
  taker.grip();
  std::string both;
  for (const auto& name : done(world.find("BLOCK")).holders) {
    both += (both.empty() ? "" : " and ") + name;
  }
  giver.release();
  const robcl::Body after = done(world.find("BLOCK"));
  std::cout << both << " held it, now";
  for (const auto& name : after.holders) std::cout << ' ' << name;
  std::cout << "; the block has moved by " << std::fixed << std::setprecision(2)
            << robcl::in_mm(distance(before, after.pose)) << " mm" << std::endl;
  giver.retreat(meeting);
}

void give_and_take() {
  gecos::Lab lab;
  const auto world = value(lab.create<robcl::World>("WORLD"));
  const Robot a(lab, "A"), b(lab, "B");
  done(a.arm.mount("", base_a));
  done(b.arm.mount("", base_b));
  a.release();
  b.release();

  a.approach(block);
  a.grip();
  a.retreat(block);

  done(a.arm.move(T));
  b.approach(T * D);
  hand_over(a, b, world, T);

  a.approach(T);
  hand_over(b, a, world, T * D);

  a.retreat(T);
  a.approach(block);
  a.release();
  a.retreat(block);
  std::cout << "A has put the block back" << std::endl;
}

}  // namespace

int main() {
  try {
    give_and_take();
  } catch (const std::runtime_error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
