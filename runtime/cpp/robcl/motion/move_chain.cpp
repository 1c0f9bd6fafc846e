#include "robcl/motion/move_chain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "robcl/motion/line_path.hpp"
#include "robcl/motion/pose_walk.hpp"

namespace robcl::motion {
namespace {

// In an overlap, a joint may use this share of its limit of acceleration. With the whole limit, a
// stop in a sharp corner exceeded the limit by up to 0.2 %.
constexpr double share_in_overlap = 0.994;
constexpr std::size_t fewest_intervals = 16, most_intervals = 4096;  // of an overlap
constexpr double same_joints = 1e-5;  // rad: joint positions that differ by less count as the same
constexpr Eigen::Index joints_for_every_pose = 6;

/// In an overlap, one motion fades out while the other fades in. The acceleration of each motion
/// rises in this share of the overlap, is then constant, and falls again in the same share at the
/// end, so that the acceleration never jumps.
constexpr double rising = 0.25;
/// The greatest second derivative of `faded_in`.
constexpr double greatest_bend = 2 / (1 - rising);

/// Returns how far the motion that fades in has come, as a share of half the overlap. `u` is the
/// share of the overlap that has passed, from 0 to 1. The slope rises from 0 to 2, and the second
/// derivative is a trapezoid. faded_in(u) - faded_in(1 - u) is 2u - 1: two motions in one direction
/// with the same speed make one motion with this speed.
double faded_in(double u) {
  if (u > 1 - rising) return 2 * u - 1 + faded_in(1 - u);
  if (u < rising) return greatest_bend * u * u * u / (6 * rising);
  const double past = u - rising;
  return greatest_bend * (squared(rising) / 6 + rising * past / 2 + squared(past) / 2);
}

/// Half the length of an overlap, as a multiple of the braking distance of the faster motion. With
/// this value, the tool passes a corner at the same distance as it would if the accelerations
/// jumped and half the overlap were as long as the braking distance.
const double overlap_per_braking_way = 0.25 / faded_in(0.5);

/// The overlap of two moves lasts from the nominal time -half to half; the corner is at 0. For the
/// nominal time `t`, `before_corner` returns a place on the path of the first move, and
/// `behind_corner` a place on the path of the next move, both as a difference of s from the corner.
/// The pose of the arm in the overlap is made from the poses at these two places.
double before_corner(double t, double half) { return -half * faded_in((half - t) / (2 * half)); }
double behind_corner(double t, double half) { return half * faded_in((half + t) / (2 * half)); }

/// Returns the share of an overlap, from 0 to 1, that lies before the knot `knot`. The overlap
/// consists of `intervals` equal intervals.
double part_of(std::size_t knot, std::size_t intervals) {
  return static_cast<double>(knot) / static_cast<double>(intervals);
}

/// The places of both motions at a knot of an overlap, as differences of s from the corner.
struct Places {
  double before, behind;
};
Places places_in(double half, std::size_t knot, std::size_t intervals) {
  const double t = half * (2 * part_of(knot, intervals) - 1);
  return {before_corner(t, half), behind_corner(t, half)};
}

/// Returns a value that rises from 0 to 1 while `part` rises from 0 to 1. The first and the second
/// derivative are 0 at both ends.
double gradual(double part) { return part * part * part * (10 + part * (6 * part - 15)); }

/// The motion of the tool on the line of a move, per unit of s: its velocity, seen from the base,
/// and its rotation about the tool's own axes.
struct Twist {
  Eigen::Vector3d way = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
};

Twist twist_of(const Move& move) {
  return {move.line->way() / move.duration(), move.line->rotation() / move.duration()};
}

Eigen::Quaterniond turned_by(const Eigen::Vector3d& rotation) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(rotation.norm(), rotation.stableNormalized()));
}

/// Returns d, half the length in s of the overlap of two moves, which have the durations `last` and
/// `next`. The value d is chosen so that the part of a move between its two overlaps is either
/// empty or at least 1/32 of the move, because the curvature of a path is not exact in very short
/// intervals.
double half_overlap(double unhindered, double last, double next) {
  double half = std::min({unhindered, last / 2, next / 2});
  for (const double duration : {last, next}) {
    if (half < duration / 2) half = std::min(half, duration * 15 / 32);
  }
  return half;
}

/// Returns the straight line that the tool follows during `move`. `start`: the place on the path
/// where the move begins. @pre `move` has a line.
LineOnPath line_of(const Move& move, double start) {
  return {*move.line, move.flange_from_tool, start, move.duration()};
}

/// Returns how far apart in s the knots of a move may be.
double furthest_apart(const Move& move) {
  double parts = 8;
  if (move.line) {
    parts = std::max({parts, move.line->length() / line_step, move.line->turn() / turn_step});
  }
  return move.duration() / parts;
}

/// Returns the least limit of (ds/dt)² that `move` has for the speed of its tool between the places
/// `from` and `to`; infinite if it has none.
double least_cap(const Move& move, double from, double to) {
  double least = infinite;
  for (std::size_t i = 0; i < move.caps.size(); ++i) {
    if (move.path.place(i + 1) > from && move.path.place(i) < to) {
      least = std::min(least, move.caps[i]);
    }
  }
  return least;
}

/// Returns how far before its goal, in s, the move must begin to brake from its full speed. At full
/// speed, ds/dt is 1; therefore this distance in s is half the time that braking takes.
double braking_way(const Move& move, const arm::ArmModel& model, const ToolLimits& limits) {
  double longest = 0;
  if (move.line) {
    const ToolLimits tool = scaled(limits, move.pace);
    const auto [way, turn] = tool_speed(move);
    longest = std::max(way / tool.acceleration, turn / tool.turn_acceleration);
  } else {
    const JointValues slope = move.path.slope(0).cwiseAbs();
    for (Eigen::Index axis = 0; axis < slope.size(); ++axis) {
      const auto& joint = model.limits()[static_cast<std::size_t>(axis)];
      longest = std::max(longest, slope[axis] / (joint.acceleration * move.pace.acceleration));
    }
  }
  return longest / 2;
}

/// Returns the least possible duration of `move` from rest to rest, with its nominal speed and
/// acceleration as the only limits. `braking` is the braking_way of the move.
double least_time_alone(const Move& move, double braking) {
  const double duration = move.duration();
  const bool reaches_full_speed = duration > 2 * braking;
  return reaches_full_speed ? duration + 2 * braking : 2 * std::sqrt(2 * braking * duration);
}

/// Returns the limits of the tool in the overlap of two straight moves, in which the velocities of
/// the tool differ by `change`. If half the overlap has the length `unhindered` and the motion has
/// the nominal speed, the overlap needs exactly the deceleration of the one move and the
/// acceleration of the other.
IntervalLimits::Tool tool_in_overlap(double fastest, double change, double half, double unhindered,
                                     double acceleration) {
  if (fastest <= 0) return {};
  const double bend = change * greatest_bend / 4;  // times half an overlap
  return {fastest, bend / half, std::max(acceleration, bend / unhindered)};
}

}  // namespace

MoveChain::MoveChain(Planner& planner, Move first)
    : planner_(planner), plan_(planner.plan(first)), last_(std::move(first)) {
  for (std::size_t i = 0; i <= last_.path.intervals(); ++i) {
    course_.knots.add(last_.path.place(i), last_.path.knot(i));
  }
  course_.limits = {limits_of(last_, planner_.tool_limits()),
                    braking_limits_of(last_, planner_.tool_limits())};
  if (last_.line) course_.lines.push_back(line_part(last_, 0, last_.duration(), 0));
}

/// Returns the part of the path, from `begin` to `end`, on which the tool moves along the line of
/// `move`. `start` is the place on the path at which the line starts.
MoveChain::LinePart MoveChain::line_part(const Move& move, double begin, double end,
                                         double start) const {
  const auto speed_of = [&](const Pace& pace) {
    const ToolLimits tool = scaled(planner_.tool_limits(), pace);
    return WayAndTurn{tool.speed, tool.turn_speed};
  };
  return {begin, end, line_of(move, start), speed_of(move.pace), speed_of(Pace{})};
}

std::optional<double> MoveChain::time_at(double s) const {
  if (s < plan_.path.begin()) return std::nullopt;
  return begins_ + plan_.law.time_at(s);
}

/// Returns the first knot that the motion passes at `time` or later. Searches from the entry of
/// plan_ to `last_place`; returns nullopt if no knot between them is passed so late.
std::optional<std::size_t> MoveChain::first_knot_after(double time, double last_place) const {
  for (std::size_t i = plan_.entry; plan_.path.place(i) <= last_place; ++i) {
    if (begins_ + plan_.law.time(i) >= time) return i;
  }
  return std::nullopt;
}

/// Consider the window of the smoothing that ends when the motion is at `knot`. Returns the last
/// knot that the motion passes no later than the beginning of this window; 0, the start of the
/// path, if there is no such knot.
std::size_t MoveChain::first_in_window_before(std::size_t knot) const {
  const double begin = plan_.law.time(knot) - planner_.smoothing().window;
  std::size_t first = knot;
  while (first > 0 && plan_.law.time(first) > begin) --first;
  return first;
}

/// Returns the part of the chain from the knot `start` to the place `end`. The place `end` becomes
/// a knot with the joint positions `at_end`. The path does not change up to the knot `entry`.
/// Behind `entry`, the path does not change where the new knot has no influence on its slopes.
MoveChain::Course MoveChain::course_between(std::size_t start, std::size_t entry, double end,
                                            const JointValues& at_end) const {
  Course course;
  course.knots.add(plan_.path.place(start), plan_.path.knot(start));
  std::size_t same = start;          // the last knot that stays the same
  constexpr double rounding = 1e-6;  // of an interval
  const std::size_t last_interval = plan_.path.intervals() - 1;
  for (std::size_t i = start; course.knots.places.back() < end; ++i) {
    // If an overlap ends at `end`, the last knot of that overlap can be slightly before `end`
    // because of rounding.
    if (i == entry && end - plan_.path.place(i) < rounding * plan_.path.step(i)) break;
    // A knot just before the end would make a very short interval, so the end replaces this knot.
    // The knots of a short corner are kept, although they are close together.
    const double step =
        std::min(plan_.path.step(i), plan_.path.step(std::min(i + 1, last_interval)));
    const bool last = i >= entry && plan_.path.place(i + 1) > end - step / 4;
    if (last) {
      course.knots.add(end, at_end);
    } else {
      course.knots.add(plan_.path.place(i + 1), plan_.path.knot(i + 1));
      same = i + 1;
    }
    course.limits.moving.push_back(course_.limits.moving[i]);
    course.limits.braking.push_back(course_.limits.braking[i]);
  }
  // A slope depends on two knots on each side.
  for (std::size_t i = start; i <= entry || i + 2 <= same; ++i) {
    course.knots.first_slopes.push_back(plan_.path.slope(i));
  }
  for (const LinePart& part : course_.lines) {
    if (part.end <= plan_.path.place(start) || part.begin >= end) continue;
    course.lines.push_back(part);
    course.lines.back().end = std::min(part.end, end);
  }
  return course;
}

/// Returns the poses of the flange in the overlap of two lines, at all knots but the first.
std::vector<Frame> MoveChain::flanges_in(const Overlap& overlap, std::size_t intervals) const {
  const Frame& flange_from_tool = overlap.next.flange_from_tool;
  const Frame tool_from_flange = flange_from_tool.inverse();
  const Frame corner = planner_.forward().base_from_flange(overlap.last.goal()) * flange_from_tool;
  const Twist one = twist_of(overlap.last), other = twist_of(overlap.next);
  std::vector<Frame> all;
  for (std::size_t i = 1; i <= intervals; ++i) {
    const auto [before, behind] = places_in(overlap.half, i, intervals);
    const Eigen::Vector3d way = one.way * before + other.way * behind;
    const Eigen::Quaterniond turn = turned_by(one.turn * before) * turned_by(other.turn * behind);
    const Frame tool(corner.position() + way, corner.orientation() * turn);
    all.push_back(tool * tool_from_flange);
  }
  return all;
}

/// Returns the joint positions in the overlap of two lines, at all knots but the first; nullopt if
/// the arm cannot follow.
std::optional<std::vector<JointValues>> MoveChain::overlap_of_lines(const Overlap& overlap,
                                                                    std::size_t intervals) {
  const auto flanges = flanges_in(overlap, intervals);
  PoseWalk walk(planner_.model(), planner_.inverse(), overlap.before);
  std::vector<JointValues> all;
  for (const Frame& flange : flanges) {
    if (walk.step_to(flange)) return std::nullopt;
    all.push_back(walk.at().joints);
  }
  const JointValues off = overlap.after - all.back();
  if (off.cwiseAbs().maxCoeff() <= same_joints) return all;
  if (planner_.model().axes() <= joints_for_every_pose) return std::nullopt;
  // An arm with more than six joints can reach the pose at the end of the overlap with its elbow at
  // another place than the next move needs. Therefore the arm moves its elbow gradually, during the
  // whole overlap, to the place that the next move needs.
  for (std::size_t i = 0; i < intervals; ++i) {
    walk.return_to({all[i] + gradual(part_of(i + 1, intervals)) * off, walk.at().kept});
    if (walk.step_to(flanges[i])) return std::nullopt;
    all[i] = walk.at().joints;
  }
  return all;
}

/// Returns the joint positions in an overlap with a joint move, at all knots but the first.
std::vector<JointValues> MoveChain::overlap_of_joints(const Overlap& overlap,
                                                      std::size_t intervals) const {
  const Move &last = overlap.last, &next = overlap.next;
  // The path of a straight move is exact only at its knots. Elsewhere, the path may differ slightly
  // from the joint positions that the inverse kinematics give.
  const JointValues off_before =
      overlap.before - last.path.position(last.duration() - overlap.half);
  const JointValues off_after = overlap.after - next.path.position(overlap.half);
  std::vector<JointValues> all;
  for (std::size_t i = 1; i <= intervals; ++i) {
    const auto [before, behind] = places_in(overlap.half, i, intervals);
    const double part = part_of(i, intervals);
    all.push_back(last.path.position(last.duration() + before) + gradual(1 - part) * off_before +
                  next.path.position(behind) + gradual(part) * off_after - last.goal());
  }
  return all;
}

/// Returns the joint positions at all knots of the overlap but the first; nullopt if a pose is
/// outside the limits of the joints, or if a joint turns too fast.
std::optional<std::vector<JointValues>> MoveChain::overlap_joints(const Overlap& overlap,
                                                                  std::size_t intervals) {
  const Move &last = overlap.last, &next = overlap.next;
  auto all = last.line && next.line ? overlap_of_lines(overlap, intervals)
                                    : overlap_of_joints(overlap, intervals);
  if (!all) return std::nullopt;
  all->back() = overlap.after;
  const double furthest = std::min(last.most_turned, next.most_turned);
  const JointValues* known = &overlap.before;
  for (const JointValues& joints : *all) {
    if ((joints - *known).cwiseAbs().maxCoeff() > furthest) return std::nullopt;
    if (arm::first_outside(planner_.model(), joints)) return std::nullopt;
    known = &joints;
  }
  return all;
}

/// Returns two sets of limits for the overlap: for the planned motion, and for a motion that brakes
/// on the path.
std::pair<IntervalLimits, IntervalLimits> MoveChain::limits_in(const Overlap& overlap) const {
  const Move &last = overlap.last, &next = overlap.next;
  const ToolLimits& full = planner_.tool_limits();
  IntervalLimits moving, braking;
  moving.speed = std::max(last.pace.speed, next.pace.speed);
  const double acceleration = std::min(last.pace.acceleration, next.pace.acceleration);
  moving.acceleration = share_in_overlap * acceleration;
  moving.cap = std::min({1.0, least_cap(last, last.duration() - overlap.half, last.duration()),
                         least_cap(next, 0, overlap.half)});
  braking.acceleration = share_in_overlap;
  if (last.line && next.line) {
    const Twist one = twist_of(last), other = twist_of(next);
    const auto tool = [&](const Eigen::Vector3d& v, const Eigen::Vector3d& w, double limit) {
      return tool_in_overlap(std::max(v.norm(), w.norm()), (w - v).norm(), overlap.half,
                             overlap.unhindered, limit);
    };
    const ToolLimits before = scaled(full, last.pace), after = scaled(full, next.pace);
    moving.way = tool(one.way, other.way, std::min(before.acceleration, after.acceleration));
    moving.turn =
        tool(one.turn, other.turn, std::min(before.turn_acceleration, after.turn_acceleration));
    braking.way = tool(one.way, other.way, full.acceleration);
    braking.turn = tool(one.turn, other.turn, full.turn_acceleration);
  }
  return {moving, braking};
}

/// Adds all knots of `overlap` but the first, which `course` already has. Returns false if the arm
/// cannot move through the overlap.
bool MoveChain::add_overlap(Course& course, const Overlap& overlap) {
  const Move &last = overlap.last, &next = overlap.next;
  const double apart = std::min(furthest_apart(last), furthest_apart(next));
  const auto wanted = static_cast<std::size_t>(std::ceil(overlap.half / apart)) * 2;
  std::size_t intervals = std::clamp(wanted, fewest_intervals, most_intervals);
  auto joints = overlap_joints(overlap, intervals);
  for (int finer = 0; !joints && finer < 2; ++finer) {
    intervals *= 2;
    joints = overlap_joints(overlap, intervals);
  }
  if (!joints) return false;

  const auto [moving, braking] = limits_in(overlap);
  for (std::size_t i = 1; i <= intervals; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(intervals);
    course.knots.add(overlap.corner + overlap.half * (2 * part - 1), (*joints)[i - 1]);
    course.limits.moving.push_back(moving);
    course.limits.braking.push_back(braking);
  }
  return true;
}

/// Adds the part of the next move behind the overlap, up to its goal or to the `following` overlap.
/// Leaves out knots that are closer together than `furthest_apart`, because the time to plan a
/// motion grows with the number of its knots.
void MoveChain::add_move(Course& course, const Overlap& overlap, const Overlap* following) const {
  const Move& next = overlap.next;
  const double end = following != nullptr ? following->begins() : overlap.goal();
  constexpr double rounding = 1e-6;  // of an interval
  const auto limits = limits_of(next, planner_.tool_limits());
  const auto braking = braking_limits_of(next, planner_.tool_limits());
  const double apart = furthest_apart(next);
  if (next.line) course.lines.push_back(line_part(next, overlap.ends(), end, overlap.corner));
  double cap = infinite;  // of the intervals since the last knot
  for (std::size_t i = 1; i <= next.path.intervals(); ++i) {
    const double place = overlap.corner + next.path.place(i);
    const double since = place - course.knots.places.back();
    const double step = next.path.step(i - 1);
    if (end - course.knots.places.back() < rounding * step) break;
    if (since <= 0) continue;
    cap = std::min(cap, limits[i - 1].cap);
    const auto turned = [&](std::size_t knot) {
      return (next.path.knot(knot) - course.knots.joints.back()).cwiseAbs().maxCoeff();
    };
    // A knot just before the following overlap would make a very short interval, so the beginning
    // of the overlap replaces this knot.
    const bool before_overlap = following != nullptr && place > end - step / 4;
    if (i < next.path.intervals() && !before_overlap) {
      const double further = since + next.path.step(i);
      if (since < step / 4 || (further <= apart && turned(i + 1) <= next.most_turned)) continue;
    }
    if (before_overlap) {
      course.knots.add(end, following->before);
    } else {
      course.knots.add(place, next.path.knot(i));
    }
    course.limits.moving.push_back(limits[i - 1]);
    course.limits.moving.back().cap = std::exchange(cap, infinite);
    course.limits.braking.push_back(braking[i - 1]);
  }
}

/// Computes by how much the tool bends away from its lines in the new intervals of `path`, and adds
/// the result to the limits of `course`. `path` is the path through the knots of `course`. The new
/// intervals can be longer than those of the moves, or have other slopes. Returns false if the tool
/// leaves a line.
bool MoveChain::keeps_to_lines(Course& course, const Path& path) const {
  const std::size_t known = course.knots.first_slopes.size();
  std::size_t i = known > 0 ? known - 1 : 0;
  for (const LinePart& part : course.lines) {
    for (; i < path.intervals(); ++i) {
      const double middle = path.place(i) + path.step(i) / 2;
      if (middle < part.begin) continue;
      if (middle > part.end) break;
      const LineDeviation deviation = deviation_in(path, i, part.line, planner_.forward());
      if (deviation.furthest() > line_tolerance) return false;
      const auto [way, turn] = deviation.bend(path.step(i));
      for (IntervalLimits* const limits : {&course.limits.moving[i], &course.limits.braking[i]}) {
        limits->way.per_x = way;
        limits->turn.per_x = turn;
      }
      lower_cap(course.limits.moving[i], part.speed, deviation.faster);
      lower_cap(course.limits.braking[i], part.braking_speed, deviation.faster);
    }
  }
  return true;
}

std::optional<Plan> MoveChain::plan_of(Course& course, const TimeLaw::Start& start) const {
  Path path(course.knots);
  if (first_outside(planner_.model(), path)) return std::nullopt;
  if (!keeps_to_lines(course, path)) return std::nullopt;
  return fastest_plan(std::move(path), planner_.model(), course.limits, planner_.smoothing(),
                      start);
}

/// Returns whether the motion would end sooner if the arm stopped between the moves. For several
/// moves, the answer is an estimate, because the moves are not planned alone: the function compares
/// with the least durations that the moves can have, and may return true although the arm would not
/// be faster with stops.
bool MoveChain::slower_than_stops(const Plan& plan, double begins,
                                  const std::vector<Overlap>& overlaps) const {
  const double added = begins + plan.law.duration() - ends();
  if (overlaps.size() == 1) {
    // Most moves prolong the motion by little more than their duration at full speed. Such moves
    // are not compared with a plan that stops, because making this plan takes time.
    constexpr double usual = 1.5, slack = 0.1;  // s
    const Move& next = overlaps.front().next;
    return added > usual * next.duration() + slack && added > planner_.plan(next).duration();
  }
  const ToolLimits& tool = planner_.tool_limits();
  double alone = 0;
  for (const Overlap& overlap : overlaps) {
    alone += least_time_alone(overlap.next, braking_way(overlap.next, planner_.model(), tool));
  }
  return added > alone;
}

/// Returns the joint positions at the place `s` of `move`. `near` are the joint positions that the
/// path has there. The path of a straight move is exact only at its knots. Therefore, for such a
/// move, the joint positions are solved again by the inverse kinematics, starting at `near`.
/// Returns nullopt if that is impossible.
std::optional<JointValues> MoveChain::joints_on(const Move& move, const JointValues& near,
                                                double s) {
  if (!move.line) return near;
  PoseWalk walk(planner_.model(), planner_.inverse(), near);
  if (walk.step_to(line_of(move, 0).at(s) * move.flange_from_tool.inverse())) return std::nullopt;
  return walk.at().joints;
}

/// Returns the overlaps of the chain with the moves `next`; nullopt if a move has no length.
std::optional<std::vector<MoveChain::Overlap>> MoveChain::overlaps_with(
    std::span<const Move> next) {
  const ToolLimits& tool = planner_.tool_limits();
  std::vector<Overlap> overlaps;
  const Move* last = &last_;
  double corner = end();
  for (const Move& move : next) {
    if (last->stands || move.stands) return std::nullopt;
    Overlap overlap{*last, move, corner};
    overlap.unhindered =
        overlap_per_braking_way * std::max(braking_way(*last, planner_.model(), tool),
                                           braking_way(move, planner_.model(), tool));
    overlap.half = half_overlap(overlap.unhindered, last->duration(), move.duration());
    const double leaves = last->duration() - overlap.half;
    const auto before = joints_on(
        *last, last == &last_ ? plan_.path.position(overlap.begins()) : last->path.position(leaves),
        leaves);
    const auto after = joints_on(move, move.path.position(overlap.half), overlap.half);
    if (!before || !after) return std::nullopt;
    overlap.before = *before;
    overlap.after = *after;
    corner = overlap.goal();
    last = &move;
    overlaps.push_back(std::move(overlap));
  }
  return overlaps;
}

/// Returns the corner of `overlap`. Searches for the place at which the tool is nearest to the
/// goal. This place is in the middle of the overlap only if both moves have the same speed.
MoveChain::Corner MoveChain::corner_of(const Plan& plan, const Overlap& overlap) const {
  const auto tool_at = [&](const JointValues& joints) {
    return planner_.base_from_tool(joints, overlap.next.flange_from_tool);
  };
  const Frame corner = tool_at(overlap.next.path.knot(0));
  const auto distance_at = [&](double s) {
    return distance(corner, tool_at(plan.path.position(s)));
  };
  constexpr int parts = 16, halvings = 10;
  constexpr double rounding = 1e-9;  // m; a pure rotation passes the corner in the middle
  double step = 2 * overlap.half / parts, nearest = overlap.corner;
  double least = distance_at(nearest);
  const auto look_at = [&](double s) {
    const double away = distance_at(s);
    if (away < least - rounding) least = away, nearest = s;
  };
  for (int i = 0; i <= parts; ++i) look_at(overlap.begins() + i * step);
  for (int i = 0; i < halvings; ++i) {
    step /= 2;
    const double middle = nearest;
    for (const double s : {middle - step, middle + step}) {
      look_at(std::clamp(s, overlap.begins(), overlap.ends()));
    }
  }
  const Frame passed = tool_at(plan.path.position(nearest));
  return {overlap.begins(), overlap.ends(), least, angle(corner, passed)};
}

std::optional<MoveChain::Corner> MoveChain::extend(const Move& next, double after) {
  const auto corners = extend(std::span(&next, 1), after);
  return corners ? std::optional(corners->front()) : std::nullopt;
}

std::optional<std::vector<MoveChain::Corner>> MoveChain::extend(std::span<const Move> next,
                                                                double after) {
  const auto overlaps = overlaps_with(next);
  if (!overlaps) return std::nullopt;
  const double begin = overlaps->front().begins();
  const auto entry = first_knot_after(after, begin);
  if (!entry) return std::nullopt;

  const std::size_t start = first_in_window_before(*entry);
  Course course = course_between(start, *entry, begin, overlaps->front().before);
  for (const Overlap& overlap : *overlaps) {
    if (!add_overlap(course, overlap)) return std::nullopt;
    add_move(course, overlap, &overlap == &overlaps->back() ? nullptr : &overlap + 1);
  }
  const auto square = [&](std::size_t knot) {
    return plan_.law.squares().begin() + static_cast<std::ptrdiff_t>(knot);
  };
  auto plan = plan_of(course, {.squares = {square(start), square(*entry + 1)}});
  if (!plan) return std::nullopt;
  const double begins = begins_ + plan_.law.time(start);
  if (slower_than_stops(*plan, begins, *overlaps)) return std::nullopt;
  std::vector<Corner> corners;
  for (const Overlap& overlap : *overlaps) corners.push_back(corner_of(*plan, overlap));
  begins_ = begins;
  course_ = std::move(course);
  plan_ = *std::move(plan);
  last_ = next.back();
  return corners;
}

}  // namespace robcl::motion
