// Geometry of boxes: intersection with a ray or with jaws, and the fall of one box onto another.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "robcl/frames/frame.hpp"

namespace devices {

using robcl::Frame;

/// A box; `pose` is in its middle, `size` along its own axes, m.
struct Box {
  Frame pose;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();

  std::array<Eigen::Vector3d, 8> corners() const;
};

/// Distance along the ray's z axis from its origin to the box, at most `reach`. A ray that starts
/// inside meets it at 0.
std::optional<double> ray_hit(const Frame& ray, double reach, const Box& box);

/// The part of a box that lies between two jaws.
struct Between {
  double lower = 0, upper = 0;  ///< along y of the jaws, m
};

/// The part of the box inside |x| <= pad.x/2, |y| <= opening/2, |z| <= pad.z/2 of `jaws`.
std::optional<Between> between_jaws(const Frame& jaws, const Eigen::Vector2d& pad, double opening,
                                    const Box& box);

/// How far `upper` can move straight down until it meets `lower`; nothing when it passes beside it
/// or is already level with it or below. Boxes that touch give 0.
std::optional<double> fall_onto(const Box& upper, const Box& lower);

}  // namespace devices
