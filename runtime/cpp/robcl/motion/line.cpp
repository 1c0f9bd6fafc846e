#include "robcl/motion/line.hpp"

#include <cmath>
#include <iomanip>
#include <sstream>

namespace robcl::motion {
namespace {

Eigen::Vector3d turn_between(const Frame& from, const Frame& to) {
  Eigen::Quaterniond turn = from.orientation().conjugate() * to.orientation();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  if (sine == 0) return Eigen::Vector3d::Zero();
  return turn.vec() * (2 * std::atan2(sine, turn.w()) / sine);
}

}  // namespace

Line::Line(const Frame& start, const Frame& goal)
    : start_(start), way_(goal.position() - start.position()), turn_(turn_between(start, goal)) {}

Frame Line::at(double part) const {
  const double all = turn();
  const Eigen::Vector3d axis = all > 0 ? Eigen::Vector3d(turn_ / all) : Eigen::Vector3d::UnitX();
  return Frame(start_.position() + part * way_,
               start_.orientation() * Eigen::AngleAxisd(part * all, axis));
}

std::string Line::place(double part) const {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  if (length() > 0) {
    text << in_mm(length() * part) << " mm along the line";
  } else {
    text << in_deg(turn() * part) << " deg into the turn";
  }
  return text.str();
}

}  // namespace robcl::motion
