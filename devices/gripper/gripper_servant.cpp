#include "devices/gripper/gripper_servant.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace devices {
namespace {

using namespace std::chrono_literals;

constexpr auto beat = 10ms;              // period at which the jaws are polled
constexpr auto world_takes_notice = 2s;  // longest delay until the world shows a change

/// Makes an exception of the type `Exception`, which is robcl::WidthOutOfRange or
/// robcl::ForceOutOfRange, from `refused`.
template <class Exception>
gecos::Fault fault(const SimulatedGripper::OutOfRange& refused) {
  return Exception{refused.value, refused.lower, refused.upper};
}

gecos::Fault as_fault(const gecos::Failure& failure) {
  const bool nobody = failure.detail == gecos::Detail::NoServer;
  return gecos::Fault::failed((nobody ? "the simulated world is not online: " : "") + failure.text);
}

}  // namespace

GripperServant::GripperServant(gecos::Lab& lab, std::string name, std::string world,
                               const std::string& carrier, const robcl::Frame& base_from_grip_point,
                               const SimulatedGripper::Settings& settings)
    : name_(std::move(name)),
      world_(lab, std::move(world)),
      mounting_(lab, carrier, robcl::Frame()),
      base_from_grip_point_(base_from_grip_point),
      gripper_(settings) {}

void GripperServant::publish() {
  mounting_.carrier().tick();
  if (const auto now = jaws()) publish_jaws(*now);
}

gecos::Result<void> GripperServant::mount(const std::string& carrier, const robcl::Frame& offset) {
  if (gripper_.state().moving) {
    return tl::unexpected(
        robcl::MountRefused{"the jaws are moving; mount the gripper when they have stopped"});
  }
  return mounting_.mount(carrier, offset);
}

gecos::Result<robcl::GripperState> GripperServant::jaws() {
  const SimulatedGripper::State now = gripper_.state();
  return robcl::GripperState{now.width, now.force, now.moving, now.holding, now.held};
}

gecos::Result<robcl::Frame> GripperServant::grip_point() {
  const auto world_from_base = mounting_.base();
  if (!world_from_base) return tl::unexpected(world_from_base.error());
  return *world_from_base * base_from_grip_point_;
}

/// Returns the body that the jaws would touch if they closed now; nullopt if there is no such body.
gecos::Result<std::optional<SimulatedGripper::Contact>> GripperServant::contact() {
  if (world_.name().empty()) return std::nullopt;
  const auto point = grip_point();
  if (!point) return tl::unexpected(point.error());
  const auto met = world_.call([&](const robcl::World& world) {
    return world.between(*point, gripper_.state().width).get();
  });
  if (!met) return tl::unexpected(as_fault(met.error()));
  if (!met->hit) return std::nullopt;
  return SimulatedGripper::Contact{met->width, met->body_name};
}

gecos::Result<void> GripperServant::let_jaws_move(Run& run) {
  const double start = gripper_.state().width;
  const double most = gripper_.settings().max_width;
  for (;;) {
    const auto now = jaws();
    run.progress(std::min(1.0, std::abs(now->width - start) / most), *now);
    if (!now->moving) return {};
    if (run.wait_interrupted(beat)) {
      gripper_.halt();
      return tl::unexpected(gecos::Fault::interrupted());
    }
  }
}

/// Waits until the simulated world reports that this gripper holds, or no longer holds, the body
/// `body`. Without this wait, the next motion of the arm could start before the body is attached or
/// released.
gecos::Result<void> GripperServant::wait_for_world(const std::string& body, WorldShows what,
                                                   Run& run) {
  const auto deadline = std::chrono::steady_clock::now() + world_takes_notice;
  while (std::chrono::steady_clock::now() < deadline) {
    const auto found =
        world_.call([&](const robcl::World& world) { return world.find(body).get(); });
    if (!found) return tl::unexpected(as_fault(found.error()));
    const bool held = std::ranges::count(found->holders, name_) > 0;
    if (found->fixed || held == (what == WorldShows::Held)) return {};
    if (run.wait_interrupted(beat)) return tl::unexpected(gecos::Fault::interrupted());
  }
  return tl::unexpected(gecos::Fault::failed(
      "the world '" + world_.name() + "' does not show that the gripper '" + name_ + "' " +
      (what == WorldShows::Released ? "released" : "holds") + " the body '" + body +
      "': check that the option --grippers of robcl-world names this gripper"));
}

gecos::Result<void> GripperServant::open(double width, Run& run) {
  const SimulatedGripper::State before = gripper_.state();
  std::optional<SimulatedGripper::Contact> met;
  if (width < before.width) {
    auto asked = contact();
    if (!asked) return tl::unexpected(asked.error());
    met = std::move(*asked);
  }
  if (const auto opening = gripper_.open(width, met); !opening) {
    return tl::unexpected(fault<robcl::WidthOutOfRange>(opening.error()));
  }
  if (auto moved = let_jaws_move(run); !moved) return moved;
  if (!before.holding || world_.name().empty()) return {};
  return wait_for_world(before.held, WorldShows::Released, run);
}

gecos::Result<void> GripperServant::close(double force, Run& run) {
  auto met = contact();
  if (!met) return tl::unexpected(met.error());
  if (const auto closing = gripper_.close(force, *met); !closing) {
    return tl::unexpected(fault<robcl::ForceOutOfRange>(closing.error()));
  }
  if (auto moved = let_jaws_move(run); !moved) return moved;
  const SimulatedGripper::State now = gripper_.state();
  if (!now.holding || world_.name().empty()) return {};
  return wait_for_world(now.held, WorldShows::Held, run);
}

}  // namespace devices
