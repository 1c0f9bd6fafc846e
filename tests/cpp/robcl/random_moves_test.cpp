// Random moves of each arm, with and without a limit of jerk: undisturbed, stopped, held up and
// overridden at any time.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "arms.hpp"
#include "moving.hpp"
#include "robcl/motion/planner.hpp"
#include "robcl/motion/playback.hpp"
#include "set_points.hpp"

namespace robcl::motion {
namespace {

using arm::ArmModel;

/// Returns the place on the path of `plan` that is nearest to `joints`.
double nearest(const Plan& plan, const JointValues& joints) {
  const auto away = [&](double at) { return (plan.path.position(at) - joints).norm(); };
  const double coarse = 1e-3 * plan.path.end();
  double s = 0;
  for (double at = s; at <= plan.path.end(); at += coarse) {
    if (away(at) < away(s)) s = at;
  }
  for (double step = coarse; step > 1e-13; step /= 2) {
    while (s + step <= plan.path.end() && away(s + step) < away(s)) s += step;
    while (s - step >= 0 && away(s - step) < away(s)) s -= step;
  }
  return s;
}

/// Straight and joint moves in turn; MOTION_MOVES says how many of each kind for each arm with a
/// limit of jerk. There are a fifth as many without.
class RandomMoves : public ::testing::TestWithParam<Moving> {
 protected:
  /// A move, planned for set points that are `period` s apart.
  struct Case {
    Plan plan;
    double period;
    bool straight;
    JointValues to;  ///< the goal; of a straight move, the tool's place there is the goal
  };

  /// Returns nothing when the move is not possible: most lines leave the reach of the arm.
  std::optional<Move> random_move(const JointValues& from, const JointValues& to, bool straight) {
    auto move = straight ? planner_.straight_move(from, planner_.base_from_tool(to, {}), {}, {})
                         : planner_.joint_move(from, to, {});
    if (!move) return std::nullopt;
    return *std::move(move);
  }

  /// Calls `check` for random moves, half of them with set points at 1 ms, the others at 4 ms.
  template <class Check>
  void for_random_moves(unsigned seed, const Check& check) {
    RandomJoints random(model_, seed);
    for (int made = 0; made < moves;) {
      const bool straight = made % 2 == 0;
      const double period = made / 2 % 2 == 0 ? 0.001 : 0.004;
      const JointValues from = random(), to = random();
      const auto move = random_move(from, to, straight);
      if (!move) continue;
      ++made;
      const Planner planner(model_, {}, Smoothing::over(GetParam().rise, period));
      const Case one{planner.plan(*move), period, straight, to};
      SCOPED_TRACE("move " + std::to_string(made) + " at a period of " + std::to_string(period));
      ASSERT_NO_FATAL_FAILURE(check(one));
    }
  }

  /// `all`: set points; at least the first two are the same, and the last two.
  void expect_within_limits(const Case& one, std::vector<JointValues> all) {
    expect_within_limits_but_jerk(one, all);
    if (HasFatalFailure() || GetParam().rise <= 0) return;
    all.insert(all.begin(), all.front());
    all.push_back(all.back());
    if (one.straight) {
      expect_limited_jerk_on_path(one, all);
    } else {
      expect_limited_jerk(model_, all, GetParam().rise, one.period);
    }
  }

  /// `all`: set points, which need not end at rest.
  void expect_within_limits_but_jerk(const Case& one, const std::vector<JointValues>& all) {
    ASSERT_NO_FATAL_FAILURE(motion::expect_within_limits(model_, all, {}, one.period));
    ASSERT_NO_FATAL_FAILURE(expect_on_path(one, all));
    if (!one.straight) return;
    const auto tools = flanges_at(model_, all);
    ASSERT_NO_FATAL_FAILURE(expect_on_line(tools, tool_at(one.plan.start()), tool_at(one.to)));
    expect_tool_within_limits(tools, {}, one.period);
  }

  void expect_on_path(const Case& one, const std::vector<JointValues>& all) {
    const Plan& plan = one.plan;
    const auto places = one.straight ? places_of(plan, all) : std::vector<double>();
    for (std::size_t k = 0; k < all.size(); ++k) {
      const double off = one.straight ? (plan.path.position(places[k]) - all[k]).norm()
                                      : off_line(all[k], plan.start(), one.to);
      ASSERT_LT(off, 1e-6) << "rad from the path in cycle " << k << " of " << all.size();
    }
  }

  /// Returns the places on the path that are nearest to the set points `all`.
  static std::vector<double> places_of(const Plan& plan, const std::vector<JointValues>& all) {
    std::vector<double> places;
    double s = nearest(plan, all.front());
    for (const JointValues& joints : all) {
      for (int i = 0; i < 4; ++i) s = nearer(plan.path, joints, s);
      places.push_back(s);
    }
    return places;
  }

  void expect_at_goal(const Case& one, const JointValues& joints) {
    if (!one.straight) {
      ASSERT_EQ(joints, one.to);
      return;
    }
    const Frame tool = planner_.base_from_tool(joints, {});
    ASSERT_TRUE(near(tool, planner_.base_from_tool(one.to, {}), 1e-9, 1e-9)) << tool;
  }
  Eigen::Vector3d tool_at(const JointValues& joints) {
    return planner_.base_from_tool(joints, {}).position();
  }

  void expect_limited_jerk_on_path(const Case& one, const std::vector<JointValues>& all) {
    const Frame start = planner_.base_from_tool(one.plan.start(), {});
    const Frame goal = planner_.base_from_tool(one.plan.goal(), {});
    const ToolLimits tool;
    const double limit =
        one.plan.path.end() * std::min(tool.acceleration / distance(start, goal),
                                       tool.turn_acceleration / angle(start, goal));
    const auto places = places_of(one.plan, all);
    const double cubed = one.period * one.period * one.period;
    for (std::size_t k = 3; k < places.size(); ++k) {
      const double third = places[k] - 3 * places[k - 1] + 3 * places[k - 2] - places[k - 3];
      ASSERT_LE(std::abs(third) / cubed, limit / GetParam().rise * slack)
          << "jerk along the path in cycle " << k << " of " << places.size();
    }
  }

  /// A step of Newton's method to the place of `joints` on the path.
  static double nearer(const Path& path, const JointValues& joints, double s) {
    const std::size_t i = path.interval_at(s);
    const double part = std::clamp((s - path.place(i)) / path.step(i), 0.0, 1.0);
    const JointValues slope = path.derivatives(i, part).slope;
    const double by = (joints - path.position(s)).dot(slope) / slope.squaredNorm();
    return std::clamp(s + by, path.begin(), path.end());
  }

  const int moves = 2 * moves_to_try(GetParam());
  const ArmModel model_ = GetParam().model();
  Planner planner_{model_, ToolLimits{}};
};
INSTANTIATE_TEST_SUITE_P(OfArms, RandomMoves, ::testing::ValuesIn(all_moving),
                         [](const auto& moving) { return moving.param.name; });

TEST_P(RandomMoves, KeepAllLimitsAndArrive) {
  for_random_moves(13, [&](const Case& one) {
    Playback playback(one.plan);
    std::vector<JointValues> all(2, one.plan.start());
    double time = 0;
    for (; !playback.standing(); time += one.period) all.push_back(playback.advance(one.period));
    all.insert(all.end(), 2, playback.advance(one.period));
    ASSERT_NO_FATAL_FAILURE(expect_within_limits(one, all));
    ASSERT_NO_FATAL_FAILURE(expect_at_goal(one, all.back()));
    ASSERT_NEAR(time, one.plan.duration(), 2 * one.period);
  });
}

TEST_P(RandomMoves, StoppedAtAnyTimeKeepAllLimits) {
  std::mt19937 engine(14);
  for_random_moves(14, [&](const Case& one) {
    const auto& [plan, period, straight, to] = one;
    const double stop_at = std::uniform_real_distribution(0.0, plan.duration())(engine);
    Playback playback(plan);
    std::vector<JointValues> all(2, plan.start());
    for (double time = 0; time < stop_at; time += period) all.push_back(playback.advance(period));
    playback.stop();
    while (!playback.standing()) all.push_back(playback.advance(period));
    all.insert(all.end(), 2, playback.advance(period));
    SCOPED_TRACE("stopped after " + std::to_string(stop_at) + " of " +
                 std::to_string(plan.duration()) + " s");
    ASSERT_NO_FATAL_FAILURE(expect_within_limits(one, all));
  });
}

TEST_P(RandomMoves, ThatWaitedAtAnyTimeGoOnFromRestOnTheirPathAndKeepAllLimits) {
  std::mt19937 engine(15);
  for_random_moves(15, [&](const Case& one) {
    const auto& [plan, period, straight, to] = one;
    const double duration = plan.duration();
    std::uniform_real_distribution<double> sometime(0.0, duration);
    const double first = sometime(engine), second = sometime(engine);
    Playback playback(plan);
    std::vector<JointValues> all(2, plan.start());
    double fraction = 0;
    SCOPED_TRACE("at rest after " + std::to_string(first) + " and " + std::to_string(second) +
                 " of " + std::to_string(duration) + " s");
    for (double time = 0; !playback.standing(); time += period) {
      for (const double rest_at : {first, second}) {
        if (time < rest_at || time >= rest_at + period) continue;
        SCOPED_TRACE("before a rest");
        // The joints come to rest between two set points, which is judged by the drives.
        ASSERT_NO_FATAL_FAILURE(expect_within_limits_but_jerk(one, all));
        const JointValues before = all.back();
        playback.rest();
        all.assign(2, playback.advance(0));
        ASSERT_LT((all.back() - before).cwiseAbs().maxCoeff(), 1e-9) << "moves at once";
      }
      all.push_back(playback.advance(period));
      ASSERT_GE(playback.fraction(), fraction);
      fraction = playback.fraction();
      ASSERT_LT(time, 4 * duration + 1) << "does not arrive";
    }
    all.insert(all.end(), 2, playback.advance(period));
    ASSERT_NO_FATAL_FAILURE(expect_within_limits(one, all));
    ASSERT_NO_FATAL_FAILURE(expect_at_goal(one, all.back()));
    ASSERT_EQ(playback.fraction(), 1);
  });
}

TEST_P(RandomMoves, OverriddenAndPausedAtAnyTimeKeepTheirPathAndAllLimits) {
  std::mt19937 engine(16);
  constexpr std::array factors{0.0, 0.1, 0.5, 0.9, 1.0};
  for_random_moves(16, [&](const Case& one) {
    const auto& [plan, period, straight, to] = one;
    const double duration = plan.duration();
    std::exponential_distribution<double> lasts(6 / duration);
    Playback playback(plan);
    std::vector<JointValues> all(2, plan.start());
    double fraction = 0, until = 0, time = 0;
    for (; !playback.standing(); time += period) {
      if (time >= until) {
        until = time + lasts(engine);
        // In the end it goes on at full speed.
        playback.set_override(time < 3 * duration ? factors[engine() % factors.size()] : 1);
      }
      all.push_back(playback.advance(period));
      ASSERT_GE(playback.fraction(), fraction);
      fraction = playback.fraction();
      ASSERT_LT(time, 6 * duration + 1) << "does not arrive";
    }
    all.insert(all.end(), 2, playback.advance(period));
    ASSERT_NO_FATAL_FAILURE(expect_within_limits(one, all));
    ASSERT_NO_FATAL_FAILURE(expect_at_goal(one, all.back()));
  });
}

TEST_P(RandomMoves, KeepTheConfigurationOrSayWhichOneCouldReachTheGoal) {
  RandomJoints random(model_, 17);
  int kept = 0, named = 0;
  for (int i = 0; i < 1000; ++i) {
    const JointValues from = random();
    const Frame goal = planner_.base_from_tool(random(), {});
    const auto present = planner_.configuration(from);
    if (const auto plan = planner_.joints_to(from, goal, {}, {})) {
      ASSERT_EQ(planner_.configuration(plan->goal()), present);
      ++kept;
      continue;
    }
    const auto any = planner_.joints_to(from, goal, {}, {}, arm::Configuration{});
    ASSERT_TRUE(any) << "random() is one";
    const auto other = planner_.configuration(any->goal());
    std::ostringstream words;
    words << "only in another configuration such as " << other
          << "; request that configuration, or allow any configuration";
    const std::string why = to_string(planner_.joints_to(from, goal, {}, {}).error());
    ASSERT_NE(why.find(words.str()), std::string::npos) << why;
    const auto asked = planner_.joints_to(from, goal, {}, {}, other);
    ASSERT_TRUE(asked);
    ASSERT_EQ(planner_.configuration(asked->goal()), other);
    ++named;
  }
  EXPECT_GT(kept, 100);
  EXPECT_GT(named, model_.front() ? 100 : -1);
}

}  // namespace
}  // namespace robcl::motion
