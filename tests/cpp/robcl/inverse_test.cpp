#include "robcl/arm/inverse.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>

#include "arms.hpp"
#include "robcl/arm/kinematics.hpp"
#include "robcl/arm/local_inverse.hpp"
#include "robcl/arm/numeric_inverse.hpp"
#include "robcl/arm/spherical_wrist.hpp"

namespace robcl::arm {
namespace {

bool inside(const ArmModel& model, const JointValues& q) { return !first_outside(model, q); }

std::string words(const Configuration& configuration) {
  std::ostringstream text;
  text << configuration;
  return text.str();
}

struct Arm {
  const char* name;
  ArmModel (*model)();
  const char* urdf;
  const char* base;
  std::array<const char*, 3> links;  // whose origins are shoulder, elbow and wrist centre
  JointValues tool_down;             // in front of the arm, the elbow up
  JointValues stretched;             // straight up, the maker's READY; joint 5 does not bend
};
void PrintTo(const Arm& arm, std::ostream* out) { *out << arm.name; }

class ClosedForm : public ::testing::TestWithParam<Arm> {
 protected:
  const ArmModel model_ = GetParam().model();
  Kinematics forward_{model_};
  const std::unique_ptr<SphericalWristInverse> inverse_ = SphericalWristInverse::for_arm(model_);

  /// Returns how many solutions there are at `q`, which must all be exact.
  std::size_t exact_solutions_at(const JointValues& q, const JointValues& reference) {
    const Frame pose = forward_.base_from_flange(q);
    const auto found = inverse_->all(pose, reference);
    for (std::size_t k = 0; k < found.count; ++k) {
      EXPECT_TRUE(near(forward_.base_from_flange(found.each[k].joints), pose, 1e-9, 1e-9))
          << "joint 5 at " << q[4];
    }
    return found.count;
  }
};

TEST_P(ClosedForm, ReachesEveryPoseThatTheArmReaches) {
  ASSERT_NE(inverse_, nullptr);
  RandomJoints random(model_, 3);
  for (int i = 0; i < 10000; ++i) {
    const Frame pose = forward_.base_from_flange(random());
    const auto solution = inverse_->solve(pose, random(), {});
    ASSERT_TRUE(solution.has_value()) << to_string(solution.error());
    ASSERT_TRUE(inside(model_, *solution));
    ASSERT_TRUE(near(forward_.base_from_flange(*solution), pose, 1e-9, 1e-9));
  }
}

TEST_P(ClosedForm, GivesEightDifferentSolutionsEachInTheConfigurationOfItsLabel) {
  RandomJoints random(model_, 4);
  int eight = 0;
  for (int i = 0; i < 1000; ++i) {
    const JointValues q = random();
    const Frame pose = forward_.base_from_flange(q);
    const auto found = inverse_->all(pose, q);
    std::set<std::string> labels;
    for (std::size_t k = 0; k < found.count; ++k) {
      ASSERT_TRUE(near(forward_.base_from_flange(found.each[k].joints), pose, 1e-8, 1e-8));
      ASSERT_EQ(inverse_->configuration(found.each[k].joints), found.each[k].configuration);
      labels.insert(words(found.each[k].configuration));
    }
    ASSERT_EQ(labels.size(), found.count);
    eight += found.count == 8 ? 1 : 0;
  }
  EXPECT_GT(eight, 500);
}

/// Returns the configuration as one sees it from outside. Both arms stand at the origin and look
/// along x while joint 1 is at 0.
Configuration seen(const Arm& arm, const JointValues& q) {
  std::array<Eigen::Vector3d, 3> points;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto part = ArmModel::from_urdf_file(arm.urdf, arm.base, arm.links[i], 0.25).value();
    points[i] = Kinematics(part).base_from_flange(q.head(part.axes())).position();
  }
  const Eigen::Vector3d ahead(std::cos(q[0]), std::sin(q[0]), 0);
  const auto [shoulder, elbow, wrist] = points;
  const double wx = (wrist - shoulder).dot(ahead), wz = wrist.z() - shoulder.z();
  const double ex = (elbow - shoulder).dot(ahead), ez = elbow.z() - shoulder.z();
  return {
      wx > 0 ? Shoulder::Righty : Shoulder::Lefty,
      (wx > 0 ? 1 : -1) * (wx * ez - wz * ex) > 0 ? Elbow::Above : Elbow::Below,
      std::sin(q[4]) * std::sin(arm.model().front().value()[4]) > 0 ? Wrist::Noflip : Wrist::Flip};
}

TEST_P(ClosedForm, ItsWordsMeanOnePostureOnEveryArm) {
  const Arm& arm = GetParam();
  RandomJoints random(model_, 9);
  int poses_with_all_labels = 0;
  for (int i = 0; i < 50; ++i) {
    const JointValues q = random();
    const auto found = inverse_->all(forward_.base_from_flange(q), q);
    std::set<std::string> labels;
    for (std::size_t k = 0; k < found.count; ++k) {
      ASSERT_EQ(found.each[k].configuration, seen(arm, found.each[k].joints))
          << words(found.each[k].configuration);
      labels.insert(words(found.each[k].configuration));
    }
    poses_with_all_labels += labels.size() == 8 ? 1 : 0;
  }
  EXPECT_GE(poses_with_all_labels, 12);
  EXPECT_EQ(words(inverse_->configuration(*model_.front())), "righty, above, noflip");
  EXPECT_EQ(words(inverse_->configuration(arm.tool_down)), "righty, above, flip");
}

TEST_P(ClosedForm, AFrontThatIsSingularOrOutsideTheTravelIsRefused) {
  const auto refusal = [&](JointValues front) {
    try {
      SphericalWristInverse::for_arm(model_.with_front(front).value());
    } catch (const std::invalid_argument& refused) {
      return std::string(refused.what());
    }
    return std::string("accepted");
  };
  JointValues straight = *model_.front();
  straight[4] = 0;
  EXPECT_NE(refusal(straight).find("'front' is at a singularity of the arm; give joint positions"),
            std::string::npos)
      << refusal(straight);
  JointValues outside = *model_.front();
  outside[1] = 10;
  EXPECT_EQ(model_.with_front(outside).error().text.rfind(
                "joint 2 of the posture 'front' is at 572.9", 0),
            0u);
  EXPECT_FALSE(model_.with_front(outside.head(5)));
}

TEST_P(ClosedForm, HasAllSolutionsExactlyAtTheWristSingularityAndBesideIt) {
  RandomJoints random(model_, 6);
  int eight = 0;
  for (int i = 0; i < 200; ++i) {
    JointValues q = random();
    q[4] = 0.5;
    // The wrist centre, and so the number of solutions, does not depend on joint 5.
    const std::size_t solutions = exact_solutions_at(q, q);
    eight += solutions == 8 ? 1 : 0;
    for (const double bend : {0.0, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6}) {
      for (const double side : {1.0, -1.0}) {
        q[4] = side * bend;
        for (const JointValues& reference : {q, random()}) {
          ASSERT_EQ(exact_solutions_at(q, reference), solutions) << "joint 5 at " << q[4];
          ASSERT_FALSE(HasFailure());
        }
      }
    }
  }
  EXPECT_GT(eight, 100);
}

TEST_P(ClosedForm, HasEightExactSolutionsInReady) {
  EXPECT_EQ(exact_solutions_at(GetParam().stretched, GetParam().stretched), 8U);
}

TEST_P(ClosedForm, StaysInTheConfigurationAskedFor) {
  RandomJoints random(model_, 5);
  for (int i = 0; i < 2000; ++i) {
    const JointValues q = random();
    const Configuration wanted = inverse_->configuration(q);
    const auto solution = inverse_->solve(forward_.base_from_flange(q), random(), wanted);
    ASSERT_TRUE(solution.has_value()) << to_string(solution.error());
    ASSERT_EQ(inverse_->configuration(*solution), wanted);
  }
}

TEST_P(ClosedForm, StaysWhereItStandsWhenTheGoalIsWhereItStands) {
  RandomJoints random(model_, 6);
  for (int i = 0; i < 2000; ++i) {
    const JointValues q = random();
    const auto solution = inverse_->solve(forward_.base_from_flange(q), q, {});
    ASSERT_TRUE(solution.has_value());
    ASSERT_LT((*solution - q).cwiseAbs().maxCoeff(), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(OnArms, ClosedForm,
                         ::testing::Values(Arm{"Rx90",
                                               rx90,
                                               ROBCL_SOURCE_DIR "/devices/arms/rx90.urdf",
                                               "foot",
                                               {"upper_arm", "elbow", "wrist"},
                                               joints({0, -20, 110, 0, 90, 0}),
                                               joints({0, 0, 0, 0, 0, 0})},
                                           Arm{"Puma560",
                                               puma560,
                                               ROBCL_SOURCE_DIR "/tests/cpp/robcl/puma560.urdf",
                                               "link0",
                                               {"link2", "link3", "link5"},
                                               joints({0, 45, -180, 0, -45, 0}),
                                               joints({0, 90, -90, 0, 0, 0})}),  // qr
                         [](const auto& made) { return made.param.name; });

class Rx90Inverse : public ::testing::Test {
 protected:
  const ArmModel model_ = rx90();
  Kinematics forward_{model_};
  const std::unique_ptr<InverseKinematics> inverse_ = make_inverse(model_);
};

TEST_F(Rx90Inverse, SolvesTheStretchedArmAndKeepsJointsThatDoNotMatter) {
  const JointValues up = joints({20, 0, 0, 30, 0, -10});
  const auto solution = inverse_->solve(forward_.base_from_flange(up), up);
  ASSERT_TRUE(solution.has_value()) << to_string(solution.error());
  EXPECT_TRUE(
      near(forward_.base_from_flange(*solution), forward_.base_from_flange(up), 1e-9, 1e-9));
  EXPECT_NEAR((*solution)[0], up[0], 1e-6);
  EXPECT_NEAR((*solution)[3], up[3], 1e-6);
  EXPECT_NEAR((*solution)[5], up[5], 1e-6);
}

TEST_F(Rx90Inverse, AllSolutionsOfTheStretchedArmAreExact) {
  const auto inverse = SphericalWristInverse::for_arm(model_);
  for (const auto& q : {joints({0, 0, 0, 0, 0, 0}), joints({20, 0, 0, 30, 0, -10}),
                        joints({20, 40, 0, 30, 50, -10})}) {
    const Frame pose = forward_.base_from_flange(q);
    const auto found = inverse->all(pose, q);
    ASSERT_GT(found.count, 0u);
    for (std::size_t k = 0; k < found.count; ++k) {
      EXPECT_TRUE(near(forward_.base_from_flange(found.each[k].joints), pose, 1e-9, 1e-9));
    }
  }
}

TEST_F(Rx90Inverse, TellsNoConfigurationAtASingularity) {
  EXPECT_EQ(inverse_->configuration(joints({0, 0, 0, 0, 0, 0})), Configuration{});
  EXPECT_EQ(words(inverse_->configuration(joints({0, 0, 90, 0, 90, 0}))), "righty, above, flip");
  EXPECT_EQ(words(inverse_->configuration(joints({0, 0, -90, 0, -90, 0}))), "lefty, above, noflip");
  EXPECT_EQ(words(inverse_->configuration(joints({0, 90, -90, 0, 0, 0}))), "righty, below, any");
}

TEST_F(Rx90Inverse, AFrontWithTheElbowDownIsRefused) {
  try {
    make_inverse(model_.with_front(joints({0, 90, -110, 0, -45, 0})).value());
    FAIL() << "accepted";
  } catch (const std::invalid_argument& refused) {
    EXPECT_STREQ(refused.what(),
                 "rx90: 'front' has the elbow below the line from shoulder to wrist; give joint "
                 "positions with the elbow up, the wrist in front of the shoulder and the flange "
                 "bent up");
  }
}

TEST_F(Rx90Inverse, TakesTheTurnOfTheLongTravellingJointsThatIsNearest) {
  const JointValues near_end = joints({0, -30, 120, 250, 60, 260});
  const auto solution = inverse_->solve(forward_.base_from_flange(near_end), near_end);
  ASSERT_TRUE(solution.has_value());
  EXPECT_LT((*solution - near_end).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_F(Rx90Inverse, SaysHowFarTheWristWouldBeWhenAGoalIsOutOfReach) {
  const auto solution = inverse_->solve(translate(2, 0, 0.42), joints({0, 0, 90, 0, 90, 0}));
  ASSERT_FALSE(solution.has_value());
  EXPECT_EQ(to_string(solution.error()),
            "out of reach: the wrist centre would be 2001.8 mm from the shoulder, but this "
            "distance must be 0.0 to "
            "900.0 mm");
}

TEST_P(ClosedForm, GivesReasonsThatFitIntoTheExceptionOfTheInterface) {
  const JointValues from = GetParam().tool_down;
  const Configuration wanted[] = {
      {}, {Shoulder::Righty, Elbow::Above, Wrist::Noflip}, {Shoulder::Lefty, Elbow::Below, {}}};
  for (const double away : {0.0, 0.1, 3.0, 1000.0}) {
    for (const Configuration& each : wanted) {
      const auto solution = inverse_->solve(translate(away, 0, 0), from, each);
      if (solution) continue;
      if (const auto* out = std::get_if<OutOfReach>(&solution.error())) {
        EXPECT_LE(out->reason.size(), 160u) << out->reason;
      }
    }
  }
}

TEST_F(Rx90Inverse, NamesTheJointThatWouldHaveToTurnTooFar) {
  // Upper arm and forearm folded onto each other further than joint 3 turns.
  const auto folded = forward_.base_from_flange(joints({0, 0, 160, 0, 60, 0}));
  const auto solution = inverse_->solve(folded, joints({0, 0, 90, 0, 90, 0}));
  ASSERT_FALSE(solution.has_value());
  const auto* limit = std::get_if<JointLimit>(&solution.error());
  ASSERT_NE(limit, nullptr) << to_string(solution.error());
  EXPECT_EQ(limit->axis, 3u);
  EXPECT_NEAR(limit->upper, 142.5_deg, 1e-9);
}

TEST_F(Rx90Inverse, RefusesAConfigurationThatCannotReachTheGoal) {
  const JointValues q =
      joints({0, 60, 30, 0, 45, 0});  // far in front: lefty would need joint 1 at 180
  const auto lefty =
      inverse_->solve(forward_.base_from_flange(q), q, {.shoulder = Shoulder::Lefty});
  ASSERT_FALSE(lefty.has_value());
  EXPECT_EQ(std::get<JointLimit>(lefty.error()).axis, 1u);
}

TEST(NearestTurn, PrefersTheNearestCopyInsideTheLimits) {
  const JointLimits limits{-270_deg, 270_deg, 1, 1};
  EXPECT_NEAR(nearest_turn(10_deg, 200_deg, limits), 10_deg, 1e-12);
  EXPECT_NEAR(nearest_turn(-100_deg, 200_deg, limits), 260_deg, 1e-12);
  EXPECT_NEAR(nearest_turn(-80_deg, 200_deg, limits), -80_deg, 1e-12);
  EXPECT_NEAR(nearest_turn(100_deg, 0, {-45_deg, 45_deg, 1, 1}), 100_deg, 1e-12);
}

/// Arms without a closed form.
class NumericInverses : public ::testing::TestWithParam<ArmModel (*)()> {
 protected:
  const ArmModel model_ = GetParam()();
  Kinematics forward_{model_};
  const std::unique_ptr<InverseKinematics> inverse_ = make_inverse(model_);
};
constexpr const char* arms_without_closed_form[] = {"Ur5", "SevenAxes", "FiveAxes"};
INSTANTIATE_TEST_SUITE_P(Of, NumericInverses, ::testing::Values(&ur5, &seven_axes, &five_axes),
                         [](const auto& made) { return arms_without_closed_form[made.index]; });

TEST(LocalInverse, MeasuresTheDistanceOfAnArmWithFiveJointsFromItsSingularities) {
  const LocalInverse inverse(five_axes());
  const auto distance_at = [&](const JointValues& joints) {
    return inverse.at(joints).inverse.singularity_distance();
  };
  EXPECT_GT(distance_at(joints({10, 20, 60, 30, 40})), 0.05);
  EXPECT_LT(distance_at(joints({10, 20, 0, 30, 40})), 1e-6) << "the elbow is stretched";
}

TEST(NumericInverse, OfAnArmWithFiveJointsTakesAGoalWhoseRoundingItCannotReach) {
  const ArmModel model = five_axes();
  Kinematics forward(model);
  const auto inverse = make_inverse(model);
  const JointValues there = joints({10, 20, 60, 30, 40});
  const Frame pose = forward.base_from_flange(there);
  for (const auto& [about_z, about_y, about_x] :
       {std::array{15e-9, 0., 0.}, std::array{0., 15e-9, 0.}, std::array{0., 0., 15e-9}}) {
    const Frame rounded = pose * Frame::from_euler_zyx(0, 0, 0, about_z, about_y, about_x);
    const auto solution = inverse->solve(rounded, joints({0, 20, 60, 30, 0}), {});
    ASSERT_TRUE(solution) << to_string(solution.error());
    EXPECT_LT((*solution - there).cwiseAbs().maxCoeff(), 1e-6);
  }
  const Frame turned = pose * Frame::from_euler_zyx(0, 0, 0, 0.01, 0.02, 0.03);
  const auto refused = inverse->solve(turned, there, {});
  ASSERT_FALSE(refused);
  const std::string why = to_string(refused.error());
  EXPECT_NE(why.find("out of reach: an arm with 5 joints reaches only some orientations; no joint "
                     "positions were found for this one, at "),
            std::string::npos)
      << why;
  EXPECT_NE(why.find(" mm from the base: give a pose that the arm has had"), std::string::npos)
      << why;
}

TEST_P(NumericInverses, GiveReasonsThatFitIntoTheExceptionOfTheInterface) {
  RandomJoints random(model_, 9);
  int refused = 0;
  for (const double away : {0.0, 0.3, 0.7, 0.999, 1.001, 3.0, 1000.0}) {
    for (int i = 0; i < 5; ++i) {
      const JointValues from = random();
      const Frame turned = forward_.base_from_flange(random());
      const double far = away * model_.reach() / std::max(turned.position().norm(), 1e-3);
      const Eigen::Vector3d moved = (far - 1) * turned.position();
      const auto solution =
          inverse_->solve(translate(moved.x(), moved.y(), moved.z()) * turned, from, {});
      if (solution) continue;
      const auto* out = std::get_if<OutOfReach>(&solution.error());
      if (out == nullptr) continue;
      ++refused;
      EXPECT_LE(out->reason.size(), 160u) << out->reason;
      EXPECT_EQ(out->reason.starts_with("an arm with 5 joints"), from.size() == 5 && away < 1)
          << out->reason;
    }
  }
  EXPECT_GE(refused, 15);
}

TEST_P(NumericInverses, ReachNearlyEveryPoseAndNeverLie) {
  ASSERT_NE(dynamic_cast<NumericInverse*>(inverse_.get()), nullptr);
  RandomJoints random(model_, 7);
  constexpr int poses = 10000;
  int reached = 0;
  for (int i = 0; i < poses; ++i) {
    const Frame pose = forward_.base_from_flange(random());
    const auto solution = inverse_->solve(pose, random(), {});
    if (!solution) continue;
    ++reached;
    ASSERT_TRUE(inside(model_, *solution));
    ASSERT_TRUE(near(forward_.base_from_flange(*solution), pose, 1e-9, 1e-9));
  }
  RecordProperty("reached", reached);
  EXPECT_GE(reached, poses * 99 / 100);
}

TEST_P(NumericInverses, StayNearWhereTheArmIs) {
  RandomJoints random(model_, 8);
  for (int i = 0; i < 200; ++i) {
    const JointValues at = random();
    const Frame beside = forward_.base_from_flange(at + 1e-3 * (random() - at));
    const auto solution = inverse_->solve(beside, at, {});
    ASSERT_TRUE(solution.has_value());
    EXPECT_LT((*solution - at).cwiseAbs().maxCoeff(), 0.5);
  }
}

TEST(Ur5, StandsWhereItsMakersParametersSay) {
  const ArmModel model = ur5();
  Kinematics forward(model);
  const Frame flange = forward.base_from_flange(JointValues::Zero(6));
  EXPECT_LT((flange.position() - Eigen::Vector3d(-0.81725, -0.19145, -0.005491)).norm(), 1e-9);
}

TEST(MakeInverse, FallsBackToTheNumericSolverForAnArmOfAnotherGeometry) {
  const auto two_joints = ArmModel::from_urdf(
      "<robot name='short'><link name='a'/><link name='b'/><link name='c'/>"
      "<joint name='1' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>"
      "<limit lower='-3' upper='3' velocity='1' effort='0'/></joint>"
      "<joint name='2' type='revolute'><parent link='b'/><child link='c'/><origin xyz='1 0 0'/>"
      "<axis xyz='0 0 1'/><limit lower='-3' upper='3' velocity='1' effort='0'/></joint></robot>",
      "a", "c", 0.25);
  ASSERT_TRUE(two_joints.has_value());
  EXPECT_NE(dynamic_cast<NumericInverse*>(make_inverse(*two_joints).get()), nullptr);
  EXPECT_NE(dynamic_cast<SphericalWristInverse*>(make_inverse(rx90()).get()), nullptr);
}

}  // namespace
}  // namespace robcl::arm
