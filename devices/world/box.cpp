#include "devices/world/box.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace devices {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double touching = 1e-3;  // m by which boxes may overlap and still count as touching

/// The twelve edges of a box. An edge is a pair of corner numbers that differ in bit i, where i is
/// the axis of the edge.
constexpr std::array<std::array<std::size_t, 2>, 12> edges = {{{0, 1},
                                                               {2, 3},
                                                               {4, 5},
                                                               {6, 7},
                                                               {0, 2},
                                                               {1, 3},
                                                               {4, 6},
                                                               {5, 7},
                                                               {0, 4},
                                                               {1, 5},
                                                               {2, 6},
                                                               {3, 7}}};

/// Returns the two positions on a line at which the line enters and leaves the box, as multiples of
/// `direction` from `origin`; nullopt if the line misses the box.
std::optional<std::array<double, 2>> through(const Box& box, const Vector3d& origin,
                                             const Vector3d& direction) {
  const Eigen::Quaterniond to_box = box.pose.orientation().conjugate();
  const Vector3d from = to_box * (origin - box.pose.position());
  const Vector3d along = to_box * direction;
  double enter = -infinite, leave = infinite;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double half = box.size[i] / 2;
    if (std::abs(along[i]) < 1e-12) {
      if (std::abs(from[i]) > half) return std::nullopt;
      continue;
    }
    const double one = (-half - from[i]) / along[i], other = (half - from[i]) / along[i];
    enter = std::max(enter, std::min(one, other));
    leave = std::min(leave, std::max(one, other));
  }
  if (enter > leave) return std::nullopt;
  return std::array<double, 2>{enter, leave};
}

/// Returns the part of a convex polygon whose points p satisfy sign·p[axis] <= limit. This is the
/// algorithm of Sutherland and Hodgman.
std::vector<Vector3d> clipped(const std::vector<Vector3d>& polygon, Eigen::Index axis, double sign,
                              double limit) {
  std::vector<Vector3d> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& from = polygon[i];
    const Vector3d& to = polygon[(i + 1) % polygon.size()];
    const double before = sign * from[axis] - limit, after = sign * to[axis] - limit;
    if (before <= 0) kept.push_back(from);
    if ((before < 0 && after > 0) || (before > 0 && after < 0)) {
      kept.push_back(from + (to - from) * (before / (before - after)));
    }
  }
  return kept;
}

/// Returns the height of edge a, from a0 to a1, above edge b, from b0 to b1, at the point where the
/// two edges cross when seen from above; nullopt if they do not cross.
std::optional<double> height_over(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                                  const Vector3d& b1) {
  const Vector2d a = (a1 - a0).head<2>(), b = (b1 - b0).head<2>(), from = (b0 - a0).head<2>();
  const double cross = a.x() * b.y() - a.y() * b.x();
  if (std::abs(cross) < 1e-15)
    return std::nullopt;  // parallel edges: fall_onto tests their corners
  const double s = (from.x() * b.y() - from.y() * b.x()) / cross;
  const double t = (from.x() * a.y() - from.y() * a.x()) / cross;
  if (s < 0 || s > 1 || t < 0 || t > 1) return std::nullopt;
  return a0.z() + s * (a1 - a0).z() - b0.z() - t * (b1 - b0).z();
}

}  // namespace

std::array<Vector3d, 8> Box::corners() const {
  std::array<Vector3d, 8> all;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vector3d half(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    all[i] = pose.transform(half.cwiseProduct(size));
  }
  return all;
}

std::optional<double> ray_hit(const Frame& ray, double reach, const Box& box) {
  const Vector3d direction = ray.rotation().col(2);
  const auto hit = through(box, ray.position(), direction);
  if (!hit) return std::nullopt;
  const auto [enter, leave] = *hit;
  if (leave < 0 || enter > reach) return std::nullopt;
  return std::max(enter, 0.0);
}

std::optional<Between> between_jaws(const Frame& jaws, const Vector2d& pad, double opening,
                                    const Box& box) {
  const Frame jaws_from_world = jaws.inverse();
  const auto corners = box.corners();
  constexpr std::array<std::array<std::size_t, 4>, 6> faces = {
      {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}}};
  Between found{infinite, -infinite};
  for (const auto& face : faces) {
    std::vector<Vector3d> polygon;
    for (const std::size_t corner : face)
      polygon.push_back(jaws_from_world.transform(corners[corner]));
    for (const double sign : {1.0, -1.0}) {
      polygon = clipped(polygon, 0, sign, pad.x() / 2);
      polygon = clipped(polygon, 1, sign, opening / 2);
      polygon = clipped(polygon, 2, sign, pad.y() / 2);
    }
    for (const Vector3d& point : polygon) {
      found.lower = std::min(found.lower, point.y());
      found.upper = std::max(found.upper, point.y());
    }
  }
  if (found.lower <= found.upper) return found;
  // No face of the box is between the jaws. The box is outside, or it fills the whole space between
  // the jaws.
  const Vector3d middle = box.pose.inverse().transform(jaws.position());
  if ((middle.cwiseAbs() - box.size / 2).maxCoeff() > 0) return std::nullopt;
  return Between{-opening / 2, opening / 2};
}

std::optional<double> fall_onto(const Box& upper, const Box& lower) {
  // The fall ends when a corner of one box meets a face of the other box, or when an edge of one
  // box meets an edge of the other box.
  double fall = infinite;
  const auto meet = [&fall](double height) {
    if (height >= -touching) fall = std::min(fall, std::max(height, 0.0));
  };
  const auto above = upper.corners(), below = lower.corners();
  for (const Vector3d& corner : above) {
    if (const auto hit = through(lower, corner, -Vector3d::UnitZ())) meet((*hit)[0]);
  }
  for (const Vector3d& corner : below) {
    if (const auto hit = through(upper, corner, Vector3d::UnitZ())) meet((*hit)[0]);
  }
  for (const auto& a : edges) {
    for (const auto& b : edges) {
      if (const auto height = height_over(above[a[0]], above[a[1]], below[b[0]], below[b[1]])) {
        meet(*height);
      }
    }
  }
  if (fall == infinite) return std::nullopt;
  return fall;
}

}  // namespace devices
