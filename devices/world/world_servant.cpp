#include "devices/world/world_servant.hpp"

#include <utility>

namespace devices {
namespace {

robcl::Body on_wire(const SimulatedBody& body) {
  return {body.name,
          body.box.pose,
          {body.box.size.x(), body.box.size.y(), body.box.size.z()},
          body.fixed,
          body.holders};
}

}  // namespace

WorldServant::WorldServant(SimulatedWorld& world, std::function<void()> catch_up,
                           double clock_speed)
    : world_(world), catch_up_(std::move(catch_up)), clock_speed_(clock_speed) {}

robcl::UnknownBody WorldServant::unknown(const std::string& name) const {
  robcl::UnknownBody exception{name, {}};
  for (const SimulatedBody& body : world_.bodies()) exception.known.push_back(body.name);
  return exception;
}

gecos::Result<std::vector<robcl::Body>> WorldServant::bodies() {
  catch_up_();
  std::vector<robcl::Body> all;
  for (const SimulatedBody& body : world_.bodies()) all.push_back(on_wire(body));
  return all;
}

gecos::Result<robcl::Body> WorldServant::find(const std::string& name) {
  catch_up_();
  const auto body = world_.find(name);
  if (!body) return tl::unexpected(unknown(name));
  return on_wire(*body);
}

gecos::Result<robcl::RayHit> WorldServant::cast(const robcl::Frame& origin, double reach) {
  if (!(reach >= 0))
    return tl::unexpected(gecos::Fault::bad_parameter("reach must be 0 m or more"));
  catch_up_();
  const auto hit = world_.cast(origin, reach);
  if (!hit) return robcl::RayHit{};
  return robcl::RayHit{true, hit->range, hit->body};
}

gecos::Result<robcl::Contact> WorldServant::between(const robcl::Frame& jaws, double opening) {
  if (!(opening >= 0)) {
    return tl::unexpected(gecos::Fault::bad_parameter("opening must be 0 m or more"));
  }
  catch_up_();
  const auto contact = world_.between(jaws, opening);
  if (!contact) return robcl::Contact{};
  return robcl::Contact{true, contact->width, contact->body};
}

gecos::Result<void> WorldServant::place(const std::string& name, const robcl::Frame& pose) {
  catch_up_();
  const auto placed = world_.place(name, pose);
  if (placed) return {};
  switch (placed.error()) {
    case SimulatedWorld::PlaceProblem::Unknown:
      return tl::unexpected(unknown(name));
    case SimulatedWorld::PlaceProblem::Fixed:
      return tl::unexpected(
          gecos::Fault::rejected("the body '" + name + "' is fixed and cannot be placed"));
    case SimulatedWorld::PlaceProblem::Held:
      break;
  }
  return tl::unexpected(
      gecos::Fault::rejected("a gripper holds the body '" + name + "': open the gripper first"));
}

}  // namespace devices
