#include "devices/world/simulated_world.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace devices {

using robcl::translate;

SimulatedWorld::SimulatedWorld(double floor, std::vector<SimulatedBody> bodies)
    : floor_(floor), bodies_(std::move(bodies)) {
  std::set<std::string> names;
  for (const SimulatedBody& body : bodies_) {
    if (!names.insert(body.name).second) {
      throw std::invalid_argument("two bodies have the name '" + body.name +
                                  "': give each body a different name");
    }
  }
}

std::vector<SimulatedBody> SimulatedWorld::bodies() const {
  const gecos::MutexLock lock(guard_);
  return bodies_;
}

std::optional<SimulatedBody> SimulatedWorld::find(std::string_view name) const {
  const gecos::MutexLock lock(guard_);
  for (const SimulatedBody& body : bodies_) {
    if (body.name == name) return body;
  }
  return std::nullopt;
}

SimulatedBody* SimulatedWorld::look_up(std::string_view name) {
  const auto found = std::find_if(bodies_.begin(), bodies_.end(),
                                  [&](const SimulatedBody& body) { return body.name == name; });
  return found == bodies_.end() ? nullptr : &*found;
}

std::optional<SimulatedWorld::Hit> SimulatedWorld::cast(const Frame& origin, double reach) const {
  const gecos::MutexLock lock(guard_);
  std::optional<Hit> first;
  for (const SimulatedBody& body : bodies_) {
    const auto range = ray_hit(origin, reach, body.box);
    if (range && (!first || *range < first->range)) first = Hit{*range, body.name};
  }
  return first;
}

std::optional<SimulatedWorld::Contact> SimulatedWorld::between(const Frame& jaws,
                                                               double opening) const {
  const gecos::MutexLock lock(guard_);
  std::optional<Contact> thickest;
  for (const SimulatedBody& body : bodies_) {
    const auto part = between_jaws(jaws, {pad_across, pad_along}, opening, body.box);
    if (!part) continue;
    const double width = part->upper - part->lower;
    if (!thickest || width > thickest->width) thickest = Contact{width, body.name};
  }
  return thickest;
}

tl::expected<void, SimulatedWorld::PlaceProblem> SimulatedWorld::place(std::string_view name,
                                                                       const Frame& pose) {
  const gecos::MutexLock lock(guard_);
  SimulatedBody* const body = look_up(name);
  if (!body) return tl::unexpected(PlaceProblem::Unknown);
  if (body->fixed) return tl::unexpected(PlaceProblem::Fixed);
  if (!body->holders.empty()) return tl::unexpected(PlaceProblem::Held);
  body->box.pose = pose;
  return {};
}

void SimulatedWorld::track(const std::string& gripper, const std::string& held,
                           const Frame& carrier) {
  const gecos::MutexLock lock(guard_);
  SimulatedBody* const body = held.empty() ? nullptr : look_up(held);
  const bool holds = body && std::ranges::count(body->holders, gripper) > 0;
  if (!holds) release(gripper);
  if (!body || body->fixed) return;
  if (holds && body->holders.back() == gripper) {
    body->box.pose = carrier * carrier_from_body_[gripper];
    return;
  }
  if (!holds) body->holders.push_back(gripper);
  carrier_from_body_[gripper] = carrier.inverse() * body->box.pose;
}

void SimulatedWorld::release(const std::string& gripper) {
  if (carrier_from_body_.erase(gripper) == 0) return;
  for (SimulatedBody& body : bodies_) {
    if (std::erase(body.holders, gripper) > 0 && body.holders.empty()) fall(body);
  }
}

void SimulatedWorld::fall(SimulatedBody& falling) {
  double lowest = falling.box.corners()[0].z();
  for (const Eigen::Vector3d& corner : falling.box.corners()) lowest = std::min(lowest, corner.z());
  double height = lowest - floor_;
  for (const SimulatedBody& body : bodies_) {
    if (&body == &falling) continue;
    if (const auto onto = fall_onto(falling.box, body.box)) height = std::min(height, *onto);
  }
  falling.box.pose = translate(0, 0, -std::max(height, 0.0)) * falling.box.pose;
}

double demo_floor() { return robcl::mm(-750); }

std::vector<SimulatedBody> demo_bodies() {
  using namespace robcl::literals;
  return {{"TABLE", {translate(300_mm, 0, -375_mm), {1.6, 1.6, 0.75}}, true, {}},
          {"BLOCK", {translate(500_mm, 200_mm, 50_mm), {0.06, 0.06, 0.1}}, false, {}}};
}

}  // namespace devices
