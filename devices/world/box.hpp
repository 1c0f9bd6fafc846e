// Geometry of boxes: intersection with a ray or with jaws, and the fall of one box onto another.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "robcl/frames/frame.hpp"

namespace devices {

using robcl::Frame;

/// A box. `pose` is the frame of its centre, `size` the lengths along the axes of that frame, m.
struct Box {
  Frame pose;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();

  std::array<Eigen::Vector3d, 8> corners() const;
};

/// Distance from the origin of `ray`, along its z axis, to the box, at most `reach`, m; nullopt if
/// the ray misses the box. It is 0 for a ray that starts inside the box.
std::optional<double> ray_hit(const Frame& ray, double reach, const Box& box);

/// The part of a box that lies between two jaws.
struct Between {
  double lower = 0, upper = 0;  ///< limits of the part along the jaws' y axis, m
};

/// The part of the box with |x| <= pad[0]/2, |y| <= opening/2, |z| <= pad[1]/2 in the frame `jaws`;
/// nullopt if there is none.
std::optional<Between> between_jaws(const Frame& jaws, const Eigen::Vector2d& pad, double opening,
                                    const Box& box);

/// Distance that `upper` can fall until it meets `lower`, m; 0 if the boxes touch. Nullopt if
/// `upper` falls past `lower`, or is not above it.
std::optional<double> fall_onto(const Box& upper, const Box& lower);

}  // namespace devices
