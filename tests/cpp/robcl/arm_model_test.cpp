#include <gtest/gtest.h>

#include "arms.hpp"
#include "robcl/arm/kinematics.hpp"
#include "robcl/arm/model.hpp"

namespace robcl::arm {
namespace {

constexpr double pi = std::numbers::pi;

Frame khalil_link(double alpha, double d, double theta, double r) {
  return rotate_x(alpha) * translate(d, 0, 0) * rotate_z(theta) * translate(0, 0, r);
}

/// The RX90 by the published modified Denavit-Hartenberg table, from its shoulder to its wrist
/// centre.
Frame khalil(const JointValues& k) {
  return khalil_link(0, 0, k[0], 0) * khalil_link(90_deg, 0, k[1], 0) *
         khalil_link(0, 450_mm, k[2], 0) * khalil_link(-90_deg, 0, k[3], 450_mm) *
         khalil_link(90_deg, 0, k[4], 0) * khalil_link(-90_deg, 0, k[5], 0);
}

TEST(Rx90Model, StandsStraightUpWithAllJointsAtZero) {
  const ArmModel model = rx90();
  EXPECT_TRUE(near(Kinematics(model).base_from_flange(joints({0, 0, 0, 0, 0, 0})),
                   translate(0, 0, 1405_mm), 1e-12, 1e-12));
  EXPECT_NEAR(model.reach(), 1405_mm, 1e-12);
}

TEST(Rx90Model, IsTheArmOfKhalilsTableUnderTheDocumentedMapOfJointZeros) {
  const ArmModel model = rx90();
  Kinematics kinematics(model);
  RandomJoints random(model, 1);
  for (int i = 0; i < 1000; ++i) {
    const JointValues q = random();
    JointValues k = q;
    k[1] = pi / 2 - q[1];
    k[2] = -pi / 2 - q[2];
    k[4] = -q[4];
    const Frame expected = translate(0, 0, 420_mm) * khalil(k) * translate(0, 0, 85_mm);
    ASSERT_TRUE(near(kinematics.base_from_flange(q), expected, 1e-12, 1e-9));
  }
}

TEST(Rx90Model, HasTheTravelAndTheSpeedsOfItsDataSheet) {
  const ArmModel model = rx90();
  const double lower[] = {-160, -137.5, -142.5, -270, -105, -270};
  const double upper[] = {160, 137.5, 142.5, 270, 120, 270};
  const double speed[] = {236, 200, 286, 401, 320, 580};
  ASSERT_EQ(model.axes(), 6);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(model.limits()[i].lower, deg(lower[i]), 1e-12);
    EXPECT_NEAR(model.limits()[i].upper, deg(upper[i]), 1e-12);
    EXPECT_NEAR(model.limits()[i].speed, deg(speed[i]), 1e-12);
    EXPECT_NEAR(model.limits()[i].acceleration, deg(speed[i]) / 0.25, 1e-12);
  }
}

TEST(Puma560Model, StandsWhereThePublishedPosesSay) {
  const ArmModel model = puma560();
  Kinematics kinematics(model);
  struct Published {
    JointValues joints;
    Frame pose;
  };
  for (const auto& [q, pose] : std::vector<Published>{
           {joints({0, 0, 0, 0, 0, 0}), translate(.4521, -.15005, .4318)},
           {joints({0, 90, -90, 0, 0, 0}), translate(.0203, -.15005, .8636)},
           {joints({0, 0, -90, 0, 0, 0}), translate(.8636, -.15005, -.0203) * rotate_y(90_deg)},
           {joints({0, 45, -180, 0, 45, 0}),
            translate(.596303, -.15005, -.014354) * rotate_y(90_deg)}}) {
    EXPECT_TRUE(near(kinematics.base_from_flange(q), pose, 1e-6, 1e-9))
        << kinematics.base_from_flange(q) << " is not " << pose;
  }
}

TEST(Puma560Model, OfTheDeviceStandsOnItsPedestalAndEndsAtItsFlange) {
  const ArmModel bare = puma560();
  const ArmModel served = ArmModel::from_urdf_file(ROBCL_SOURCE_DIR "/devices/arms/puma560.urdf",
                                                   "foot", "flange", 0.25)
                              .value();
  Kinematics of_bare(bare), of_served(served);
  RandomJoints random(bare, 1);
  for (int i = 0; i < 100; ++i) {
    const JointValues q = random();
    const Frame expected =
        translate(0, 0, 671.83_mm) * of_bare.base_from_flange(q) * translate(0, 0, 56.25_mm);
    ASSERT_TRUE(near(of_served.base_from_flange(q), expected, 1e-12, 1e-9));
  }
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(served.limits()[i].lower, bare.limits()[i].lower);
    EXPECT_EQ(served.limits()[i].upper, bare.limits()[i].upper);
    EXPECT_EQ(served.limits()[i].speed, bare.limits()[i].speed);
  }
}

TEST(Kinematics, JacobianIsTheDerivativeOfTheFlangePose) {
  const ArmModel model = puma560();
  Kinematics kinematics(model);
  RandomJoints random(model, 2);
  constexpr double step = 1e-6;
  for (int i = 0; i < 100; ++i) {
    const JointValues q = random();
    const Jacobian jacobian = kinematics.place(q).jacobian;
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      JointValues before = q, after = q;
      before[axis] -= step;
      after[axis] += step;
      const Frame from = kinematics.base_from_flange(before);
      const Frame to = kinematics.base_from_flange(after);
      const Eigen::Vector3d speed = (to.position() - from.position()) / (2 * step);
      const Eigen::AngleAxisd turn(to.orientation() * from.orientation().conjugate());
      const Eigen::Vector3d rate = turn.axis() * turn.angle() / (2 * step);
      ASSERT_LT((jacobian.col(axis).head<3>() - speed).norm(), 1e-8);
      ASSERT_LT((jacobian.col(axis).tail<3>() - rate).norm(), 1e-8);
    }
  }
}

std::string refusal(const std::string& xml, const std::string& base, const std::string& flange) {
  const auto model = ArmModel::from_urdf(xml, base, flange, 0.25);
  return model ? "accepted" : model.error().text;
}

TEST(ArmModel, RefusesWhatIsNoArmAndSaysWhy) {
  const auto robot = [](const std::string& joint) {
    return "<robot name='r'><link name='a'/><link name='b'/><joint name='j' " + joint +
           "<parent link='a'/><child link='b'/></joint></robot>";
  };
  EXPECT_EQ(refusal(robot("type='prismatic'><limit lower='0' upper='1' velocity='1' effort='1'/>"),
                    "a", "b"),
            "joint 'j' is not revolute, continuous or fixed; other types are not supported");
  EXPECT_EQ(refusal(robot("type='revolute'><limit lower='0' upper='1' velocity='0' effort='1'/>"),
                    "a", "b"),
            "joint 'j' needs a velocity limit from 1e-6 to 1e6 rad/s");
  EXPECT_EQ(refusal(robot("type='revolute'><limit lower='1' upper='1' velocity='1' effort='1'/>"),
                    "a", "b"),
            "joint 'j': its lower limit must be below its upper limit");
  EXPECT_EQ(refusal(robot("type='revolute'><limit lower='0' upper='1e7' velocity='1' effort='1'/>"),
                    "a", "b"),
            "joint 'j' needs limits of its travel from -1e6 to 1e6 rad");
  EXPECT_EQ(refusal(robot("type='revolute'><limit lower='0' upper='1' velocity='1' effort='1'/>"
                          "<mimic joint='i'/>"),
                    "a", "b"),
            "joint 'j' has a <mimic> element: it follows joint 'i', which is not supported in an "
            "arm");
  EXPECT_EQ(refusal(robot("type='fixed'>"), "a", "tip"), "the URDF has no link 'tip'");
  EXPECT_EQ(refusal(robot("type='fixed'>"), "b", "a"), "link 'a' is not a descendant of link 'b'");
  EXPECT_EQ(refusal(robot("type='fixed'>"), "a", "b"),
            "the arm has 0 moving joints; 1 to 8 are supported");
  EXPECT_EQ(refusal(robot("type='revolute'><limit lower='0' upper='1' velocity='1' effort='1'/>"
                          "<axis xyz='0 0 0'/>"),
                    "a", "b"),
            "joint 'j' has an <axis> without a direction");
  EXPECT_EQ(refusal(robot("type='revolute'><limit lower='0' upper='1' velocity='1' effort='1'/>"
                          "<origin xyz='0 0 1e308'/>"),
                    "a", "b"),
            "joint 'j' is further than 1000 m from the one before it");
  EXPECT_EQ(refusal("<robot name='loop'><link name='a'/><link name='b'/><link name='c'/>"
                    "<joint name='1' type='fixed'><parent link='b'/><child link='c'/></joint>"
                    "<joint name='2' type='fixed'><parent link='c'/><child link='b'/></joint>"
                    "</robot>",
                    "a", "c"),
            "link 'b' cannot be reached from the root link 'a': the joints above it form a loop");
  const auto missing = ArmModel::from_urdf_file("/nowhere/x.urdf", "a", "b", 0.25);
  EXPECT_EQ(missing.error().text, "/nowhere/x.urdf: cannot be read");
}

TEST(ArmModel, RefusesALinkWithTwoParentsAndAJointWithoutAName) {
  const auto joined = [](const std::string& first, const std::string& second) {
    const auto joint = [](const std::string& name, const char* parent) {
      return "<joint name='" + name + "' type='revolute'><parent link='" + parent +
             "'/><child link='c'/><limit lower='0' upper='1' velocity='1' effort='1'/></joint>";
    };
    return refusal(
        "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>"
        "<joint name='to_b' type='fixed'><parent link='a'/><child link='b'/></joint>" +
            joint(first, "a") + (second.empty() ? "" : joint(second, "b")) + "</robot>",
        "a", "c");
  };
  EXPECT_EQ(joined("from_a", "from_b"),
            "link 'c' is the child of two joints, one of them 'from_b'");
  for (const std::string name : {"", "from\na", "from&#7;a", "from&#127;a"}) {
    EXPECT_EQ(joined(name, ""), "the joint above link 'c' needs a name without control characters");
  }
}

TEST(ArmModel, RefusesElementsThatAreNestedSoDeepThatTheParserWouldCrash) {
  const auto nested = [](int levels) {
    std::string open, close;
    for (int i = 0; i < levels; ++i) {
      open += "<extra at=\"1>2/\">";
      close += "</extra>";
    }
    return "<?xml version='1.0'?><!-- <a><a> --><robot name='r'><link name='a'/>" + open + close +
           "</robot>";
  };
  const std::string deep =
      "the elements of the URDF are nested more than 100 deep, or one contains '<?'";
  EXPECT_EQ(refusal(nested(99), "a", "b"), "the URDF has no link 'b'");
  EXPECT_EQ(refusal(nested(100), "a", "b"), deep);
  EXPECT_EQ(refusal(nested(200'000), "a", "b"), deep);
  // In the quotes of a declaration, the parser sees no tags.
  std::string hidden = "<robot name='r'>";
  for (int part = 0; part < 2000; ++part) {
    for (int i = 0; i < 90; ++i) hidden += "<extra>";
    hidden += "<?xml version='>";
    for (int i = 0; i < 90; ++i) hidden += "</extra>";
    hidden += "'?>";
  }
  EXPECT_EQ(refusal(hidden, "a", "b"), deep);
  std::string side_by_side = "<robot name='r'><link name='a'/>";
  for (int i = 0; i < 1000; ++i)
    side_by_side += "<extra/><extra></extra><!-- <a> --><![CDATA[<a>]]>";
  EXPECT_EQ(refusal(side_by_side + "</robot>", "a", "b"), "the URDF has no link 'b'");
}

TEST(ArmModel, DoesNotDependOnShapesAndMassesNorOnMalformedOnes) {
  const auto with = [](const std::string& element) {
    return refusal("<robot name='r'><link name='a'/><link name='b'>" + element +
                       "</link><joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
                       "<limit lower='0' upper='1' velocity='1' effort='1'/></joint></robot>",
                   "a", "b");
  };
  const std::string inertia =
      "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>";
  EXPECT_EQ(with("<inertial><mass value='3'/>" + inertia), "accepted");
  EXPECT_EQ(with("<inertial><mass value='-3'/>" + inertia), "accepted");
  EXPECT_EQ(with("<inertial><mass/>" + inertia), "accepted");
  for (const std::string kind : {"visual", "collision"}) {
    for (const std::string solid :
         {"<box size='1 2 3'/>", "<mesh filename='/nowhere/arm.stl'/>", "<box/>"}) {
      EXPECT_EQ(with("<" + kind + "><geometry>" + solid + "</geometry></" + kind + ">"),
                "accepted");
    }
  }
}

}  // namespace
}  // namespace robcl::arm
