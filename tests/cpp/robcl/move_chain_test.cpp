// Moves that go over into each other.
#include "robcl/motion/move_chain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "allocations.hpp"
#include "arms.hpp"
#include "moving.hpp"
#include "robcl/motion/playback.hpp"
#include "set_points.hpp"

namespace robcl::motion {
namespace {

constexpr double cycle = 0.004;                             // s
const JointValues ready = joints({0, -20, 110, 0, 90, 0});  // tool down in front of the arm

/// A chain of moves, and the control loop that moves the arm by it.
class Chained {
 public:
  Chained(Planner& planner, Move first, double period = cycle)
      : planner_(planner),
        period_(period),
        chain_(planner, std::move(first)),
        playback_(chain_.plan()),
        set_points_(2, chain_.plan().start()) {}

  const MoveChain& chain() const { return chain_; }
  Playback& playback() { return playback_; }
  const std::vector<JointValues>& set_points() const { return set_points_; }  ///< since a rest
  void expect_within_limits(const arm::ArmModel& model) const {
    for (const auto& until_rest : until_rests_) {
      SCOPED_TRACE("before a rest");
      motion::expect_within_limits(model, until_rest, {}, period_);
    }
    motion::expect_within_limits(model, set_points_, {}, period_);
  }

  std::optional<MoveChain::Corner> extend(const Move& next) {
    const auto corner = chain_.extend(next, playback_.elapsed() + 0.02);
    if (corner) playback_.append(chain_.plan(), chain_.begins());
    return corner;
  }
  std::optional<std::vector<MoveChain::Corner>> extend(const std::vector<Move>& next) {
    auto corners = chain_.extend(next, playback_.elapsed() + 0.02);
    if (corners) playback_.append(chain_.plan(), chain_.begins());
    return corners;
  }
  std::optional<MoveChain::Corner> straight_to(const Frame& goal, const Pace& pace = {}) {
    const auto next = planner_.straight_move(chain_.goal(), goal, {}, pace);
    EXPECT_TRUE(next) << to_string(next.error());
    return next ? extend(*next) : std::nullopt;
  }
  void step() { set_points_.push_back(playback_.advance(period_)); }
  /// Does what the control loop does when the arm has come to rest because it got no set points.
  void rest() {
    const JointValues before = set_points_.back();
    playback_.rest();
    until_rests_.push_back(std::move(set_points_));
    set_points_.assign(2, playback_.advance(0));
    EXPECT_LT((set_points_.back() - before).cwiseAbs().maxCoeff(), 1e-9) << "moves at once";
  }
  void run_until(double time) {
    while (playback_.elapsed() < time && !playback_.standing()) step();
  }
  void run() {
    while (!playback_.standing()) step();
    step(), step();
  }

  double duration() const { return static_cast<double>(set_points_.size() - 4) * period_; }
  /// Returns how near the tool came to `place`, in m.
  double nearest_to(const Frame& place) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const JointValues& at : set_points_) {
      nearest = std::min(nearest, distance(planner_.base_from_tool(at, {}), place));
    }
    return nearest;
  }
  /// Returns the least speed of the joints while the motion is between two fractions of its set
  /// points, in rad/s.
  double slowest_between(double first, double last) const {
    const auto count = static_cast<double>(set_points_.size());
    double slowest = std::numeric_limits<double>::infinity();
    for (auto k = static_cast<std::size_t>(first * count); static_cast<double>(k) < last * count;
         ++k) {
      slowest = std::min(slowest, (set_points_[k] - set_points_[k - 1]).norm() / period_);
    }
    return slowest;
  }

  /// Returns in how many cycles between two fractions the joints are slower than .001 rad/s.
  int slow_cycles(double first, double last) const {
    const auto count = static_cast<double>(set_points_.size());
    int slow = 0;
    for (auto k = static_cast<std::size_t>(first * count); static_cast<double>(k) < last * count;
         ++k) {
      if ((set_points_[k] - set_points_[k - 1]).norm() < 0.001 * period_) ++slow;
    }
    return slow;
  }

 private:
  Planner& planner_;
  const double period_;
  MoveChain chain_;
  Playback playback_;
  std::vector<JointValues> set_points_;
  std::vector<std::vector<JointValues>> until_rests_;
};

/// The parts of a chain that are straight lines of the tool.
class LineParts {
 public:
  LineParts(Planner& planner, Move first) : planner_(planner), last_(std::move(first)) {}

  /// Notes that the chain goes over into `next`.
  void extend(const Move& next, const MoveChain::Corner& corner) {
    parts_.push_back(last_part(corner.begins));
    begin_ = corner.ends;
    start_ += last_.duration();
    last_ = next;
  }

  /// Checks that the tool is on its lines, and that it keeps its accelerations there.
  void expect_kept(const Plan& plan) {
    parts_.push_back(last_part(plan.path.end()));
    expect_on_lines(plan.path);
    expect_accelerations(plan);
    parts_.pop_back();
  }

 private:
  /// The part of a move between its corners, and the move itself.
  struct Part {
    double begin, end;       ///< s
    double start, duration;  ///< s
    std::optional<Line> line;
    ToolLimits limits;
  };
  Part last_part(double end) const {
    return {begin_, end, start_, last_.duration(), last_.line, scaled({}, last_.pace)};
  }
  /// Returns the line on which the tool is between two places.
  const Part* line_at(double from, double to) const {
    constexpr double rounding = 1e-9;
    const auto contains = [&](const Part& part) {
      return part.line && part.begin - rounding <= from && to <= part.end + rounding;
    };
    const auto found = std::ranges::find_if(parts_, contains);
    return found == parts_.end() ? nullptr : &*found;
  }

  void expect_on_lines(const Path& path) {
    for (std::size_t i = 0; i < path.intervals(); ++i) {
      const Part* const part = line_at(path.place(i), path.place(i + 1));
      if (part == nullptr) continue;
      for (const double piece : {0.0, 0.25, 0.5, 0.75}) {
        const double s = path.place(i) + path.step(i) * piece;
        const Frame tool = planner_.base_from_tool(path.position(s), {});
        const double along = std::clamp((s - part->start) / part->duration, 0.0, 1.0);
        ASSERT_LE(distance(tool, part->line->at(along)), 5e-5) << "m from the line at " << s;
      }
    }
  }
  void expect_accelerations(const Plan& plan) {
    constexpr double step = 0.001;  // s
    std::array<double, 3> places{};
    std::array<Frame, 3> tools;
    for (int k = 0; k * step < plan.law.duration(); ++k) {
      std::ranges::rotate(places, places.begin() + 1);
      std::ranges::rotate(tools, tools.begin() + 1);
      places[2] = plan.law.at(k * step).s;
      tools[2] = planner_.base_from_tool(plan.path.position(places[2]), {});
      const Part* const part = line_at(places[0], places[2]);
      if (k < 2 || part == nullptr) continue;
      const auto& [before, now, after] = tools;
      const Eigen::Vector3d way = after.position() - 2 * now.position() + before.position();
      const Eigen::Vector3d turn = turn_between(now, after) + turn_between(now, before);
      const ToolLimits& limits = part->limits;
      ASSERT_LE(way.norm() / (step * step), limits.acceleration * slack) << "at " << places[1];
      ASSERT_LE(turn.norm() / (step * step), limits.turn_acceleration * slack)
          << "at " << places[1];
    }
  }
  static Eigen::Vector3d turn_between(const Frame& from, const Frame& to) {
    return rotation_vector(from.orientation().conjugate() * to.orientation());
  }

  Planner& planner_;
  Move last_;
  double begin_ = 0;  // s where the arm is on the path of the last move
  double start_ = 0;  // s at the start of the last move
  std::vector<Part> parts_;
};

/// The parameter is the time in s in which an acceleration may rise to its limit.
class MoveChains : public ::testing::TestWithParam<double> {
 protected:
  Move straight(const JointValues& from, const Frame& goal, const Pace& pace = {}) {
    auto move = planner_.straight_move(from, goal, {}, pace);
    if (!move) throw std::runtime_error(to_string(move.error()));
    return *std::move(move);
  }
  Move joint(const JointValues& from, const JointValues& to, const Pace& pace = {}) {
    return *planner_.joint_move(from, to, pace);
  }
  void expect_within_limits(const Chained& chained, double period = cycle) {
    motion::expect_within_limits(model_, chained.set_points(), {}, period);
  }

  const arm::ArmModel model_ = rx90();
  Planner planner_{model_, {}, Smoothing::over(GetParam(), cycle)};
  const Frame start_ = planner_.base_from_tool(ready, {});
};

INSTANTIATE_TEST_SUITE_P(OfJerk, MoveChains, ::testing::Values(0, 0.03),
                         [](const auto& rise) { return rise.param > 0 ? "limited" : "unlimited"; });

TEST_P(MoveChains, FiftyShortLinesTakeTheTimeOfOneLongLine) {
  const auto along = [&](double part) { return start_ * translate(0, 0, -0.2 * part); };
  for (const double period : {0.001, 0.004}) {
    SCOPED_TRACE("period " + std::to_string(period));
    Planner planner(model_, {}, Smoothing::over(GetParam(), period));
    Chained chained(planner, straight(ready, along(0.02)), period);
    for (int i = 2; i <= 50; ++i) {
      const auto corner = chained.straight_to(along(i / 50.0));
      ASSERT_TRUE(corner) << "line " << i;
      EXPECT_LT(corner->distance, 1e-6);
      chained.step();
    }
    chained.run();
    expect_within_limits(chained, period);
    const auto one = planner.straight(ready, along(1), {}, {});
    EXPECT_LE(chained.duration(), 1.05 * one->duration());
    expect_on_line(flanges_at(model_, chained.set_points()), start_.position(),
                   along(1).position());
  }
}

TEST_P(MoveChains, MovesThatAreAddedTogetherGoLikeThoseThatAreAddedOneByOne) {
  const std::vector<Frame> goals = {
      start_ * translate(0, 0.1, 0), start_ * translate(0, 0.1, -0.05),
      start_ * translate(0, 0.1, -0.052) * Frame::from_euler_zyz(0, 0, 0, 0, -0.5, 0.3),
      start_ * translate(0.1, 0.1, -0.05), start_};
  const Move first = straight(ready, start_ * translate(0, 0.01, 0));
  Chained one_by_one(planner_, first), together(planner_, first);
  std::vector<Move> moves;
  std::vector<MoveChain::Corner> corners;
  for (const Frame& goal : goals) {
    moves.push_back(straight(one_by_one.chain().goal(), goal));
    const auto corner = one_by_one.extend(moves.back());
    ASSERT_TRUE(corner);
    corners.push_back(*corner);
  }
  MoveChain chain(planner_, first);
  const auto same = chain.extend(moves, 0.02);
  ASSERT_TRUE(same);
  ASSERT_EQ(same->size(), corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_NEAR((*same)[i].begins, corners[i].begins, 1e-9);
    EXPECT_NEAR((*same)[i].ends, corners[i].ends, 1e-9);
    EXPECT_NEAR((*same)[i].distance, corners[i].distance, 1e-5);
    EXPECT_NEAR((*same)[i].angle, corners[i].angle, 1e-4);
  }
  ASSERT_TRUE(together.extend(moves));
  one_by_one.run();
  together.run();
  expect_within_limits(together);
  EXPECT_NEAR(together.duration(), one_by_one.duration(), 0.01 * one_by_one.duration());
  EXPECT_EQ(together.set_points().back(), one_by_one.set_points().back());
}

TEST_P(MoveChains, OneMoveThatCannotFollowLeavesTheChainAsItIs) {
  Chained chained(planner_, straight(ready, start_ * translate(0, 0.1, 0)));
  const double ends = chained.chain().ends();
  const JointValues goal = chained.chain().goal();
  const Move next = straight(goal, start_ * translate(0, 0.1, -0.05));
  const Move stays = straight(next.goal(), start_ * translate(0, 0.1, -0.05));
  ASSERT_TRUE(stays.stands);
  EXPECT_FALSE(chained.extend(std::vector{next, stays}));
  EXPECT_EQ(chained.chain().ends(), ends);
  EXPECT_EQ(chained.chain().goal(), goal);
  EXPECT_TRUE(chained.extend(next));
}

TEST_P(MoveChains, ACornerIsMissedByTheDistanceThatIsToldBefore) {
  const ToolLimits limits{.speed = 0.25, .acceleration = 1};
  const Frame corner = start_ * translate(0.15, 0, 0), goal = corner * translate(0, 0.15, 0);
  for (const double period : {0.001, 0.004}) {
    SCOPED_TRACE("period " + std::to_string(period));
    Planner planner(model_, limits, Smoothing::over(GetParam(), period));
    Chained chained(planner, *planner.straight_move(ready, corner, {}, {}), period);
    const auto told = chained.straight_to(goal);
    ASSERT_TRUE(told);
    EXPECT_NEAR(told->distance, 0.01105, 0.00001);  // |w - u|·v²/8a
    chained.run();
    expect_within_limits(chained, period);
    EXPECT_NEAR(chained.nearest_to(corner), told->distance, 1e-4);
    EXPECT_GT(chained.slowest_between(0.2, 0.8), 0.05);
    EXPECT_LT(chained.nearest_to(goal), 1e-6);
    // Both lines at full speed: the way of 0.3 m, and once the time to accelerate.
    EXPECT_NEAR(chained.duration(), 0.3 / 0.25 + 0.25 + GetParam(), 0.02);
  }
}

/// Moves the arm along lines and by a joint move that go over into each other, with a limit of jerk
/// and a set point in each `period`, in s. Returns the greatest difference between the
/// accelerations of a joint in two successive periods, in rad/s².
double greatest_change_of_acceleration(double period) {
  const arm::ArmModel model = rx90();
  Planner planner(model, {}, Smoothing::over(0.03, period));
  const Frame start = planner.base_from_tool(ready, {});
  const Frame corner = start * translate(0.15, 0, 0);
  Chained chained(planner, *planner.straight_move(ready, corner, {}, {}), period);
  EXPECT_TRUE(chained.straight_to(corner * translate(0, 0.15, 0)));
  EXPECT_TRUE(chained.straight_to(corner * translate(0, 0.02, 0)));  // back, on the same line
  const auto turned = planner.joint_move(chained.chain().goal(), ready, {});
  EXPECT_TRUE(turned && chained.extend(*turned));
  chained.run();
  const auto& at = chained.set_points();
  double greatest = 0;
  for (std::size_t k = 3; k < at.size(); ++k) {
    const JointValues change = at[k] - 3 * at[k - 1] + 3 * at[k - 2] - at[k - 3];
    greatest = std::max(greatest, change.cwiseAbs().maxCoeff() / (period * period));
  }
  return greatest;
}

TEST(MoveChain, ACornerOfSevenJointsTakesLessTimeThanAStop) {
  const arm::ArmModel model = seven_axes();
  RandomJoints random(model, 20);
  int tried = 0;
  for (int i = 0; i < 200; ++i) {
    const JointValues from = 0.7 * random();
    for (const double rise : {0.0, 0.03}) {
      Planner planner(model, {}, Smoothing::over(rise, cycle));
      const Frame via = planner.base_from_tool(from, {}) * translate(0.15, 0, 0);
      const auto first = planner.straight_move(from, via, {}, {});
      if (!first) continue;
      const auto next = planner.straight_move(first->goal(), via * translate(0, 0.15, 0), {}, {});
      if (!next) continue;
      ++tried;
      MoveChain chain(planner, *first);
      ASSERT_TRUE(chain.extend(*next, 0.02)) << "from position " << i;
      const double with_stop = planner.plan(*first).duration() + planner.plan(*next).duration();
      ASSERT_LT(chain.ends(), 0.95 * with_stop) << "from position " << i;
    }
  }
  EXPECT_GT(tried, 50);
}

/// The rotation vector of half a turn has two possible directions.
TEST(MoveChain, HalfATurnGoesOverIntoTheNextMoveLikeALittleLess) {
  const arm::ArmModel model = rx90();
  Planner planner(model, {});
  RandomJoints random(model, 23);
  int followed = 0;
  for (int i = 0; i < 300 && followed < 40; ++i) {
    JointValues from = 0.6 * random();
    from[5] = 0;
    const Frame start = planner.base_from_tool(from, {});
    const Eigen::Vector3d axis(0.1 * std::sin(i), 0.1 * std::cos(i), 1);  // about that of joint 6
    const auto moves_by = [&](double angle) -> std::optional<std::pair<Move, Move>> {
      const Frame turned = start * Frame::from_axis_angle(0, 0, 0, axis, angle);
      auto first = planner.straight_move(from, turned, {}, {});
      if (!first) return std::nullopt;
      const Frame goal = turned * translate(0.1, 0, 0);
      auto next = planner.straight_move(first->goal(), goal, {}, {});
      if (!next) return std::nullopt;
      return std::pair{*std::move(first), *std::move(next)};
    };
    const auto half = moves_by(180_deg);
    if (!half) continue;
    const Move& first = half->first;
    const Frame begun = start.inverse() * first.line->at(0.1);
    EXPECT_LT((begun.rotation_vector() - 0.1 * first.line->rotation()).norm(), 1e-9);
    const double side = begun.rotation_vector().z() > 0 ? 1 : -1;
    const auto less = moves_by(side * 179.99_deg);
    if (!less) continue;
    MoveChain chain(planner, first), other(planner, less->first);
    const auto corner = chain.extend(half->second, 0.02);
    const auto expected = other.extend(less->second, 0.02);
    ASSERT_EQ(corner.has_value(), expected.has_value()) << "from position " << i;
    if (!corner) continue;
    ++followed;
    EXPECT_NEAR(corner->angle, expected->angle, 1e-3);
    EXPECT_NEAR(corner->distance, expected->distance, 1e-4);
    EXPECT_NEAR(chain.ends(), other.ends(), 1e-2);
  }
  EXPECT_GE(followed, 30);
}

TEST_P(MoveChains, AChainBeginsBeyondALimitOfAJointIfItLeadsBack) {
  JointValues from = joints({0, -20, 110, 0, 120, 0}), inside = from;
  from[4] += 2.4e-5;  // one count of an encoder
  inside[4] = 100_deg;
  const Frame corner = planner_.base_from_tool(inside, {});
  Chained chained(planner_, straight(from, corner));
  ASSERT_TRUE(chained.straight_to(corner * translate(0, 0.1, 0)));
  chained.run();
  for (const JointValues& at : chained.set_points()) ASSERT_LE(at[4], from[4] + 1e-9);
}

TEST(MoveChain, RoundsACornerWithoutAJumpOfTheAcceleration) {
  // In a quarter of the time, an acceleration that rises changes by a quarter, and one that jumps
  // by as much. At a knot of the path, a small part of the change is a jump.
  EXPECT_LT(greatest_change_of_acceleration(0.00025), 0.6 * greatest_change_of_acceleration(0.001));
}

TEST_P(MoveChains, JointMovesKeepTheSpeedOfTheToolAlsoWhereTheyOverlap) {
  Pace pace;
  pace.tool_speed = 0.05;
  const JointValues via = joints({20, -20, 110, 0, 90, 0});
  Chained chained(planner_, joint(ready, via, pace));
  ASSERT_TRUE(chained.extend(joint(via, joints({40, -20, 110, 0, 90, 0}), pace)));
  ASSERT_TRUE(chained.straight_to(start_, pace));
  chained.run();
  double fastest = 0;  // m in a cycle
  std::optional<Frame> before;
  for (const JointValues& at : chained.set_points()) {
    const Frame tool = planner_.base_from_tool(at, {});
    if (before) fastest = std::max(fastest, distance(*before, tool));
    before = tool;
  }
  EXPECT_LE(fastest / cycle, 1.01 * 0.05);
}

TEST_P(MoveChains, AMoveKeepsItsAccelerationAlsoInItsCorners) {
  Pace gentle;
  gentle.acceleration = 0.2;
  const Frame above = start_ * translate(0, 0, -0.1);
  Chained chained(planner_, straight(ready, above));
  JointValues turned = chained.chain().goal();
  turned[0] += deg(60);  // joint 1 moves in this move alone
  ASSERT_TRUE(chained.extend(joint(chained.chain().goal(), turned, gentle)));
  ASSERT_TRUE(chained.straight_to(planner_.base_from_tool(turned, {}) * translate(0, 0, 0.1)));
  chained.run();
  const auto& at = chained.set_points();
  double fastest = 0;  // rad/s²
  for (std::size_t k = 2; k < at.size(); ++k) {
    const double change = at[k][0] - 2 * at[k - 1][0] + at[k - 2][0];
    fastest = std::max(fastest, std::abs(change) / (cycle * cycle));
  }
  EXPECT_LE(fastest, 1.01 * 0.2 * model_.limits()[0].acceleration);
  EXPECT_GE(fastest, 0.15 * model_.limits()[0].acceleration);
}

TEST_P(MoveChains, AShortLineBetweenLongOnesKeepsItsCorners) {
  const Frame via = start_ * translate(0.1, 0, 0), next = via * translate(0.00014, 0.00014, 0);
  const Frame goal = next * translate(0.1, 0, 0);
  const Move first = straight(ready, via);
  LineParts lines(planner_, first);
  Chained chained(planner_, first);
  for (const Frame& to : {next, goal}) {
    const Move move = straight(chained.chain().goal(), to);
    const auto corner = chained.extend(move);
    ASSERT_TRUE(corner);
    lines.extend(move, *corner);
    lines.expect_kept(chained.chain().plan());
  }
  chained.run();
  expect_within_limits(chained);
}

TEST_P(MoveChains, SlowMovesThatAreAddedTogetherFollow) {
  for (const double acceleration : {0.02, 0.15, 1.0}) {
    Pace pace;
    pace.acceleration = acceleration;
    for (const double length : {0.002, 0.02, 0.04}) {
      const auto along = [&](int i) { return start_ * translate(0, 0, -length * i); };
      Chained chained(planner_, straight(ready, along(1), pace));
      std::vector<Move> moves{straight(chained.chain().goal(), along(2), pace)};
      for (int i = 3; i <= 5; ++i) moves.push_back(straight(moves.back().goal(), along(i), pace));
      EXPECT_TRUE(chained.extend(moves)) << acceleration << ", " << length << " m";
    }
  }
}

TEST_P(MoveChains, ASlowCornerIsSharpAndRoundAllTheSame) {
  for (const double speed : {0.01, 0.05, 0.1}) {
    Pace pace;
    pace.tool_speed = speed;
    const Frame corner = start_ * translate(0.02, 0, 0), goal = corner * translate(0, 0.02, 0);
    Chained chained(planner_, straight(ready, corner, pace), 0.001);
    const auto told = chained.straight_to(goal, pace);
    ASSERT_TRUE(told);
    EXPECT_NEAR(told->distance, std::sqrt(2) * speed * speed / (8 * 3), 1e-7);
    chained.run();
    motion::expect_within_limits(model_, chained.set_points(), {}, 0.001);
    EXPECT_NEAR(chained.nearest_to(corner), told->distance, 2e-5);
    EXPECT_GT(chained.slowest_between(0.2, 0.8), 0.1 * speed);
  }
}

TEST_P(MoveChains, ACornerOfASlowLineAndAJointMoveIsAsFarAsTold) {
  for (const double speed : {0.05, 0.1, 0.3}) {
    Pace pace;
    pace.tool_speed = speed;
    const Frame corner = start_ * translate(0, 0, -0.1);
    Chained chained(planner_, straight(ready, corner, pace), 0.001);
    JointValues beside = chained.chain().goal();
    beside[0] += 0.4;
    const auto told = chained.extend(joint(chained.chain().goal(), beside));
    ASSERT_TRUE(told);
    chained.run();
    const double seen = chained.nearest_to(corner);
    EXPECT_NEAR(told->distance, seen, 0.01 * seen) << speed;
  }
}

TEST_P(MoveChains, TurnsInPlaceReversalsAndJointMovesAreRoundedToo) {
  const Frame away = start_ * translate(0, 0.1, -0.05);
  const Frame turned = away * Frame::from_euler_zyz(0, 0, 0, 0, -0.5, 0.3);
  Chained chained(planner_, joint(joints({20, -30, 100, 10, 80, 0}), ready));
  const auto follow = [&](const Move& next) {
    const auto corner = chained.extend(next);
    ASSERT_TRUE(corner);
    EXPECT_GT(chained.chain().time_at(corner->ends), chained.chain().time_at(corner->begins));
  };
  follow(straight(ready, away));
  follow(straight(chained.chain().goal(), turned));
  follow(straight(chained.chain().goal(), start_));
  follow(straight(chained.chain().goal(), turned));  // a reversal
  follow(joint(chained.chain().goal(), joints({-20, -30, 100, 10, 80, 0})));
  follow(joint(chained.chain().goal(), ready));
  chained.run();
  expect_within_limits(chained);
  EXPECT_LE(chained.slow_cycles(0.1, 0.9), 1) << "only where it turns back";
  EXPECT_EQ(chained.set_points().back(), ready);
}

TEST_P(MoveChains, MovesThatComeInOneMomentAllFollowAtAnyOverride) {
  const auto along = [&](double part) { return start_ * translate(0, 0, -0.2 * part); };
  for (const double factor : {1.0, 0.6, 0.1}) {
    Chained chained(planner_, straight(ready, along(0.05)));
    chained.playback().set_override(factor);
    for (int i = 2; i <= 20; ++i) {
      ASSERT_TRUE(chained.straight_to(along(i / 20.0))) << "line " << i;
      if (i == 4) chained.step();
    }
    chained.run();
    expect_within_limits(chained);
    EXPECT_LT(chained.nearest_to(along(1)), 1e-9);
    const auto one = planner_.straight(ready, along(1), {}, {});
    EXPECT_LE(chained.duration(), 1.1 * one->duration() / factor);
  }
}

TEST_P(MoveChains, AMoveThatComesAfterTheArmBrakesDoesNotFollow) {
  Chained chained(planner_, straight(ready, start_ * translate(0, 0.1, 0)));
  chained.run_until(0.8 * chained.chain().ends());
  EXPECT_FALSE(chained.straight_to(start_));
  chained.run();
  expect_within_limits(chained);
  EXPECT_LT(distance(planner_.base_from_tool(chained.set_points().back(), {}),
                     start_ * translate(0, 0.1, 0)),
            1e-9);
}

TEST_P(MoveChains, AMoveThatTheControlLoopSeesTooLateIsLeftOut) {
  MoveChain chain(planner_, joint(ready, joints({20, -20, 110, 0, 90, 0})));
  Playback playback(chain.plan());
  ASSERT_TRUE(chain.extend(joint(chain.goal(), joints({20, -40, 110, 0, 90, 0})), 0.02));
  while (playback.elapsed() < 0.1) playback.advance(cycle);
  playback.append(chain.plan(), chain.begins());
  JointValues last;
  while (!playback.standing()) last = playback.advance(cycle);
  EXPECT_LT((last - joints({20, -20, 110, 0, 90, 0})).norm(), 1e-9);
}

TEST_P(MoveChains, GoingOverAllocatesNothingInTheControlLoop) {
  Chained chained(planner_, joint(ready, joints({20, -20, 110, 0, 90, 0})));
  ASSERT_TRUE(chained.extend(joint(chained.chain().goal(), joints({20, -40, 110, 0, 90, 0}))));
  CountAllocations allocations;
  JointValues sum = ready;
  while (!chained.playback().standing()) sum += chained.playback().advance(cycle);
  EXPECT_EQ(allocations.so_far(), 0);
  EXPECT_TRUE(sum.allFinite());
}

/// Chains of random moves; MOTION_MOVES says how many of each arm with a limit of jerk. There are a
/// fifth as many without.
class RandomChains : public ::testing::TestWithParam<Moving> {
 protected:
  /// `small`: as a program makes that follows a curve.
  std::optional<Move> random_move(const JointValues& from, RandomJoints& random,
                                  std::mt19937& engine, bool small) {
    const double part = small ? std::pow(10, std::uniform_real_distribution(-4.0, -2.0)(engine))
                              : std::uniform_real_distribution(0.02, 0.4)(engine);
    const JointValues to = from + part * (random() - from);
    Pace pace;
    pace.speed = std::uniform_real_distribution(0.2, 1.0)(engine);
    pace.acceleration = std::uniform_real_distribution(0.05, 1.0)(engine);
    const bool straight = engine() % 2 == 0;
    auto move = straight ? planner_.straight_move(from, planner_.base_from_tool(to, {}), {}, pace)
                         : planner_.joint_move(from, to, pace);
    if (!move) return std::nullopt;
    return *std::move(move);
  }

  void try_chains(bool small);

  const int moves = moves_to_try(GetParam());
  const arm::ArmModel model_ = GetParam().model();
  Planner planner_{model_, ToolLimits{}};
};
INSTANTIATE_TEST_SUITE_P(OfArms, RandomChains, ::testing::ValuesIn(all_moving),
                         [](const auto& moving) { return moving.param.name; });

void RandomChains::try_chains(bool small) {
  RandomJoints random(model_, 18);
  std::mt19937 engine(18);
  constexpr std::array factors{0.0, 0.1, 0.5, 0.9, 1.0};
  const auto sometimes = [&](int one_in) { return engine() % static_cast<unsigned>(one_in) == 0; };
  int followed = 0, refused = 0;
  for (int made = 0; made < moves;) {
    const double period = made % 2 == 0 ? 0.001 : 0.004;
    const bool overridden = made % 3 == 0;
    const bool held_up = sometimes(3);
    auto first = random_move(random(), random, engine, false);
    if (!first) continue;
    Planner planner(model_, {}, Smoothing::over(GetParam().rise, period));
    double one_by_one = planner.plan(*first).duration();  // s
    LineParts lines(planner, *first);
    Chained chained(planner, *std::move(first), period);
    SCOPED_TRACE("chain after move " + std::to_string(made));
    for (int i = 0; i < 5; ++i, ++made) {
      std::vector<Move> together;
      do {
        const JointValues& from =
            together.empty() ? chained.chain().goal() : together.back().goal();
        auto next = random_move(from, random, engine, small && sometimes(2));
        if (next) together.push_back(*std::move(next));
      } while (sometimes(3));
      if (together.empty()) continue;
      const auto corners = chained.extend(together);
      const bool follow = corners.has_value();
      (follow ? followed : refused) += static_cast<int>(together.size());
      for (std::size_t k = 0; follow && k < together.size(); ++k) {
        lines.extend(together[k], (*corners)[k]);
      }
      ASSERT_NO_FATAL_FAILURE(lines.expect_kept(chained.chain().plan()));
      for (const Move& next : together) one_by_one += follow ? planner.plan(next).duration() : 0;
      const auto cycles = std::exponential_distribution<double>(20)(engine) / period;
      for (double k = 0; k < cycles; ++k) {
        if (overridden && sometimes(100)) {
          chained.playback().set_override(factors[engine() % factors.size()]);
        }
        if (held_up && sometimes(100)) chained.rest();
        chained.step();
      }
    }
    const bool stopped = sometimes(2);
    if (stopped) chained.playback().stop();
    chained.playback().set_override(1);
    chained.run();
    SCOPED_TRACE("chain until move " + std::to_string(made) + " at a period of " +
                 std::to_string(period) + (overridden ? ", overridden" : "") +
                 (held_up ? ", held up" : "") + (stopped ? ", stopped" : ""));
    // Only a move that adds much more than its duration is compared with a stop.
    ASSERT_LE(chained.chain().ends(), 1.5 * one_by_one + 0.5) << "slower than with stops";
    ASSERT_NO_FATAL_FAILURE(chained.expect_within_limits(model_));
    if (stopped) continue;
    ASSERT_EQ(chained.set_points().back(), chained.chain().goal());
  }
  EXPECT_GT(followed, moves / 2);
  RecordProperty("refused", refused);
}

TEST_P(RandomChains, KeepAllLimitsAtAnyTimeOverriddenHeldUpAndStopped) { try_chains(false); }

TEST_P(RandomChains, OfSmallMovesKeepAllLimitsAtAnyTimeOverriddenHeldUpAndStopped) {
  try_chains(true);
}

}  // namespace
}  // namespace robcl::motion
