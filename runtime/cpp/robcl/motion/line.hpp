#pragma once

#include <string>

#include "robcl/frames/frame.hpp"

namespace robcl::motion {

/// A straight way between two frames: the position goes along a line while the orientation turns
/// evenly about one axis, the short way round.
class Line {
 public:
  Line(const Frame& start, const Frame& goal);

  double length() const { return way_.norm(); }  ///< m
  double turn() const { return turn_.norm(); }   ///< rad
  /// `part` of it done, 0 to 1.
  Frame at(double part) const;
  /// "120.0 mm along the line", for messages.
  std::string place(double part) const;

 private:
  Frame start_;
  Eigen::Vector3d way_;
  Eigen::Vector3d turn_;  // axis times angle, seen from the start
};

}  // namespace robcl::motion
