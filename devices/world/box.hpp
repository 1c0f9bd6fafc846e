// Geometry of boxes: intersection with a ray or with jaws, and the fall of one box onto another.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "robcl/frames/frame.hpp"

namespace devices {

using robcl::Frame;

/// A box. `pose` is the frame of the box's centre; `size` has the lengths in m along the axes of
/// that frame.
struct Box {
  Frame pose;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();

  std::array<Eigen::Vector3d, 8> corners() const;
};

/// Returns the distance in m from the origin of `ray` to the box, along the z axis of `ray`; 0 if
/// the ray starts inside the box. Returns nullopt if the ray misses the box, or if the box is
/// further away than `reach`.
std::optional<double> ray_hit(const Frame& ray, double reach, const Box& box);

/// The part of a box that lies between two jaws.
struct Between {
  double lower = 0, upper = 0;  ///< limits of the part along the jaws' y axis, m
};

/// Returns the part of the box that lies between the two jaws of a gripper. The space between the
/// jaws is |x| <= pad[0]/2, |y| <= opening/2 and |z| <= pad[1]/2, seen from the frame `jaws`.
/// Returns nullopt if no part of the box lies in this space.
std::optional<Between> between_jaws(const Frame& jaws, const Eigen::Vector2d& pad, double opening,
                                    const Box& box);

/// Returns the distance in m that the box `upper` can fall until it touches the box `lower`; 0 if
/// the boxes touch. Returns nullopt if `upper` falls past `lower`, or is not above `lower`.
std::optional<double> fall_onto(const Box& upper, const Box& lower);

}  // namespace devices
