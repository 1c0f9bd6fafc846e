#include "robcl/frames/frame.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "gecos/wire/contents.hpp"

namespace robcl {
namespace {

using gecos::wire::DecodeProblem;

static_assert(gecos::wire::GeneralContents<Frame>);
static_assert(sizeof(Frame) == 7 * sizeof(double));

constexpr double pi = std::numbers::pi;

class RandomFrames {
 public:
  double angle() { return turn_(engine_); }
  double length() { return place_(engine_); }
  Frame frame() {
    const double x = length(), y = length(), z = length(), a = angle(), c = angle();
    return Frame::from_euler_zyz(x, y, z, a, std::abs(angle()), c);
  }

 private:
  std::mt19937 engine_{90};
  std::uniform_real_distribution<double> turn_{-pi, pi}, place_{-2, 2};
};

void expect_same(const Frame& left, const Frame& right) {
  EXPECT_TRUE(near(left, right, 1e-12, 1e-12)) << left << " is not " << right;
}

TEST(Frame, ComposesAndInverts) {
  RandomFrames random;
  for (int i = 0; i < 1000; ++i) {
    const Frame a = random.frame(), b = random.frame(), c = random.frame();
    expect_same((a * b) * c, a * (b * c));
    expect_same(a * a.inverse(), Frame());
    expect_same((a * b).inverse(), b.inverse() * a.inverse());
    EXPECT_TRUE((a * b).matrix().isApprox(a.matrix() * b.matrix(), 1e-12));
  }
}

TEST(Frame, CarriesPointsLikeItsMatrix) {
  const Frame frame = Frame::from_euler_zyz(1, 2, 3, 90_deg, 0, 0);
  EXPECT_TRUE(frame.transform({1, 0, 0}).isApprox(Eigen::Vector3d(1, 3, 3)));
}

TEST(Frame, EulerAnglesComeBackAsTheyWentIn) {
  RandomFrames random;
  for (int i = 0; i < 2000; ++i) {
    const double a = random.angle(), b = std::abs(random.angle()), c = random.angle();
    const auto zyz = Frame::from_euler_zyz(0, 0, 0, a, b, c).euler_zyz();
    EXPECT_NEAR(zyz[0], a, 1e-9);
    EXPECT_NEAR(zyz[1], b, 1e-9);
    EXPECT_NEAR(zyz[2], c, 1e-9);
    const double pitch = (b - pi / 2) * 0.999;
    const auto zyx = Frame::from_euler_zyx(0, 0, 0, a, pitch, c).euler_zyx();
    EXPECT_NEAR(zyx[0], a, 1e-9);
    EXPECT_NEAR(zyx[1], pitch, 1e-9);
    EXPECT_NEAR(zyx[2], c, 1e-9);
  }
}

TEST(Frame, ThirdEulerAngleIsZeroWhereTwoAxesAreParallel) {
  for (const double b : {0.0, pi}) {
    const Frame frame = Frame::from_euler_zyz(0, 0, 0, 0.3, b, 0.4);
    const auto [a, middle, c] = frame.euler_zyz();
    EXPECT_NEAR(middle, b, 1e-9);
    EXPECT_EQ(c, 0);
    expect_same(Frame::from_euler_zyz(0, 0, 0, a, middle, c), frame);
  }
  for (const double b : {-pi / 2, pi / 2}) {
    const Frame frame = Frame::from_euler_zyx(0, 0, 0, 0.3, b, 0.4);
    const auto [a, middle, c] = frame.euler_zyx();
    EXPECT_NEAR(middle, b, 1e-7);
    EXPECT_EQ(c, 0);
    EXPECT_TRUE(near(Frame::from_euler_zyx(0, 0, 0, a, middle, c), frame, 1e-12, 1e-7));
  }
}

TEST(Frame, FixedAxesAreZyxFromBackToFront) {
  const Frame fixed = Frame::from_fixed_xyz(0.1, 0.2, 0.3, 10_deg, 20_deg, 30_deg);
  expect_same(fixed, Frame::from_euler_zyx(0.1, 0.2, 0.3, 30_deg, 20_deg, 10_deg));
  expect_same(fixed,
              translate(0.1, 0.2, 0.3) * rotate_z(30_deg) * rotate_y(20_deg) * rotate_x(10_deg));
  const auto [rx, ry, rz] = fixed.fixed_xyz();
  EXPECT_NEAR(rx, 10_deg, 1e-12);
  EXPECT_NEAR(ry, 20_deg, 1e-12);
  EXPECT_NEAR(rz, 30_deg, 1e-12);
}

TEST(Frame, EulerAnglesAreReadAccuratelyBesideTheirSingularity) {
  for (const double beside : {1e-3, 1e-5, 1e-7}) {
    for (const double b : {90_deg - beside, beside - 90_deg}) {
      const auto [a, middle, c] = Frame::from_euler_zyx(0, 0, 0, 0.3, b, 0.4).euler_zyx();
      EXPECT_NEAR(middle, b, 1e-15);
      EXPECT_NEAR(a, 0.3, 1e-15 / beside);
      EXPECT_NEAR(c, 0.4, 1e-15 / beside);
    }
  }
}

TEST(Frame, AMatrixGivesTheQuaternionWhoseFirstComponentIsPositive) {
  RandomFrames random;
  for (int i = 0; i < 20000; ++i) {
    const Frame frame = random.frame();
    const auto read = Frame::from_matrix(frame.matrix()).quaternion();
    ASSERT_GE(read[0], 0);
    const double sign = frame.quaternion()[0] < 0 ? -1 : 1;
    for (std::size_t k = 0; k < 4; ++k) ASSERT_NEAR(read[k], sign * frame.quaternion()[k], 1e-9);
  }
}

TEST(Frame, AnInterpolatedFrameIsOnTheLineAndTheTurn) {
  RandomFrames random;
  for (int i = 0; i < 1000; ++i) {
    const Frame start = random.frame(), goal = random.frame();
    expect_same(interpolate(start, goal, 0), start);
    expect_same(interpolate(start, goal, 1), goal);
    const Frame between = interpolate(start, goal, 0.3);
    EXPECT_NEAR(distance(start, between), 0.3 * distance(start, goal), 1e-9);
    EXPECT_NEAR(angle(start, between), 0.3 * angle(start, goal), 1e-9);
    EXPECT_NEAR(angle(between, goal), 0.7 * angle(start, goal), 1e-9);
  }
  EXPECT_THROW(interpolate(Frame(), Frame(), 1.5), std::invalid_argument);
  EXPECT_THROW(interpolate(Frame(), Frame(), std::nan("")), std::invalid_argument);
}

TEST(Frame, IsItsAxisAndAngle) {
  RandomFrames random;
  for (int i = 0; i < 1000; ++i) {
    const Frame frame = random.frame();
    const Eigen::Vector3d turn = frame.rotation_vector();
    EXPECT_LE(turn.norm(), 180_deg + 1e-15);
    expect_same(Frame::from_axis_angle(frame.x(), frame.y(), frame.z(), turn, turn.norm()), frame);
  }
  EXPECT_THROW(Frame::from_axis_angle(0, 0, 0, Eigen::Vector3d::Zero(), 1), InvalidFrame);
}

TEST(Frame, TwistAndWrenchDoTheSameWorkSeenFromAnywhere) {
  RandomFrames random;
  const Twist twist{{0.1, -0.2, 0.3}, {1.0, 2.0, -0.5}};
  const Wrench wrench{{5.0, -3.0, 2.0}, {0.2, 0.4, -0.6}};
  const Eigen::Vector3d point(0.7, 0.1, -0.4);
  for (int i = 0; i < 100; ++i) {
    const Frame frame = random.frame();
    const Twist seen = frame.transform_twist(twist);
    const Wrench felt = frame.transform_wrench(wrench);
    EXPECT_NEAR(seen.linear.dot(felt.force) + seen.angular.dot(felt.torque),
                twist.linear.dot(wrench.force) + twist.angular.dot(wrench.torque), 1e-9);
    const Eigen::Vector3d velocity = frame.rotation() * (twist.linear + twist.angular.cross(point));
    EXPECT_LT((seen.linear + seen.angular.cross(frame.transform(point)) - velocity).norm(), 1e-12);
  }
}

TEST(Frame, MatrixAndQuaternionComeBackAsTheyWentIn) {
  RandomFrames random;
  for (int i = 0; i < 1000; ++i) {
    const Frame frame = random.frame();
    expect_same(Frame::from_matrix(frame.matrix()), frame);
    const auto [w, x, y, z] = frame.quaternion();
    expect_same(Frame::from_quaternion(frame.x(), frame.y(), frame.z(), w, x, y, z), frame);
  }
}

TEST(Frame, FaceToFaceHandoverAppliedTwiceIsHere) {
  const Frame face_to_face = Frame::from_euler_zyz(0, 0, 0, 0, 180_deg, 0);
  expect_same(face_to_face * face_to_face, Frame());
}

TEST(Frame, ApproachAlongTheToolIsAboveABlockWhoseZPointsDown) {
  const Frame block = Frame::from_euler_zyz(0.5, 0.1, 0.3, 0, 180_deg, 0);
  const Frame above = block * translate(0, 0, -200_mm);
  EXPECT_NEAR(above.z(), 500_mm, 1e-12);
  EXPECT_NEAR(above.x(), 0.5, 1e-12);
}

TEST(Frame, AngleIsExactForSmallTurnsAndNeverAboveAHalfTurn) {
  EXPECT_NEAR(angle(Frame(), rotate_y(1e-9)), 1e-9, 1e-20);
  EXPECT_NEAR(angle(rotate_z(-170_deg), rotate_z(170_deg)), 20_deg, 1e-12);
}

TEST(Frame, RefusesAQuaternionThatIsNotOfUnitLengthAndSaysItsLength) {
  try {
    Frame::from_quaternion(0, 0, 0, 1, 1, 0, 0);
    FAIL() << "accepted";
  } catch (const InvalidFrame& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("(1, 1, 0, 0) has length 1.41421356"), std::string::npos) << text;
  }
  EXPECT_THROW(Frame::from_quaternion(0, 0, 0, 0, 0, 0, 0), InvalidFrame);
  EXPECT_THROW(translate(std::nan(""), 0, 0), InvalidFrame);
  try {
    rotate_x(std::numeric_limits<double>::infinity());
    FAIL() << "accepted";
  } catch (const InvalidFrame& error) {
    EXPECT_STREQ(error.what(), "frame: angle inf rad is not finite");
  }
}

TEST(Frame, RefusesMatricesThatAreNotRigid) {
  Eigen::Matrix4d stretched = Eigen::Matrix4d::Identity();
  stretched(0, 0) = 1.01;
  Eigen::Matrix4d mirrored = Eigen::Matrix4d::Identity();
  mirrored(0, 0) = -1;
  Eigen::Matrix4d projecting = Eigen::Matrix4d::Identity();
  projecting(3, 0) = 0.1;
  EXPECT_THROW(Frame::from_matrix(stretched), InvalidFrame);
  EXPECT_THROW(Frame::from_matrix(mirrored), InvalidFrame);
  EXPECT_THROW(Frame::from_matrix(projecting), InvalidFrame);
}

TEST(Frame, SinglePrecisionQuaternionsAreAcceptedAndMadeExact) {
  const float part = std::sqrt(0.5f);
  const auto [w, x, y, z] = Frame::from_quaternion(0, 0, 0, part, part, 0, 0).quaternion();
  EXPECT_NEAR(w * w + x * x + y * y + z * z, 1, 1e-15);
}

TEST(Frame, EncodesAsSevenDoublesPositionFirst) {
  const Frame frame = Frame::from_quaternion(1, 2, 3, 0, 1, 0, 0);
  const auto bytes = gecos::wire::to_bytes(frame);
  ASSERT_EQ(bytes.size(), 56u);
  gecos::wire::Decoder from(bytes);
  for (const double expected : {1.0, 2.0, 3.0, 0.0, 1.0, 0.0, 0.0}) {
    double number = -1;
    ASSERT_TRUE(from.get(number));
    EXPECT_EQ(number, expected);
  }
}

TEST(Frame, DecodesToTheSameNumbersBitByBit) {
  RandomFrames random;
  for (int i = 0; i < 1000; ++i) {
    const Frame frame = random.frame();
    const auto back = gecos::wire::from_message<Frame>(gecos::wire::to_message(frame));
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(*back, frame);
  }
}

TEST(Frame, DecodingRefusesWhatIsNoPlacementAndNamesTheField) {
  const auto decode = [](std::array<double, 7> numbers) {
    gecos::Bytes bytes(56);
    gecos::wire::Encoder to(bytes);
    to.put_array(numbers);
    return gecos::wire::from_bytes<Frame>(bytes);
  };
  const double nan = std::nan("");
  EXPECT_TRUE(decode({0, 0, 0, -1, 0, 0, 0}).has_value());
  EXPECT_EQ(decode({nan, 0, 0, 1, 0, 0, 0}).error(),
            (gecos::wire::DecodeError{DecodeProblem::InvalidValue, 0, "position"}));
  EXPECT_EQ(decode({0, 0, 0, nan, 0, 0, 0}).error(),
            (gecos::wire::DecodeError{DecodeProblem::InvalidValue, 24, "orientation"}));
  EXPECT_EQ(
      decode({0, 0, 0, 0, 0, 0, 0}).error().message(),
      "field 'orientation' at byte 24: 0 is the length of the orientation's quaternion, which "
      "must be 1; without rotation, w is 1");
  EXPECT_FALSE(decode({0, 0, 0, 1, 0, 0, 1e-2}).has_value());
  EXPECT_EQ(gecos::wire::from_bytes<Frame>(gecos::Bytes(55)).error().problem,
            DecodeProblem::Truncated);
}

// The rule that lcm-gen follows, written down once more, over the struct that geometry.gidl
// declares.
class Fingerprint {
 public:
  Fingerprint& member(const std::string& name, const std::string& primitive = {}) {
    text(name);
    if (!primitive.empty()) text(primitive);
    byte(0);  // dimensions
    return *this;
  }
  Fingerprint& nested(std::uint64_t fingerprint) {
    nested_ += fingerprint;
    return *this;
  }
  std::uint64_t value() const {
    const std::uint64_t sum = static_cast<std::uint64_t>(hash_) + nested_;
    return (sum << 1) | (sum >> 63);
  }

 private:
  void byte(int value) {
    const auto shifted = static_cast<std::int64_t>(static_cast<std::uint64_t>(hash_) << 8);
    const auto mixed = static_cast<std::uint64_t>(shifted ^ (hash_ >> 55));
    hash_ = static_cast<std::int64_t>(mixed + static_cast<std::uint64_t>(value));
  }
  void text(const std::string& characters) {
    byte(static_cast<int>(characters.size()));
    for (const char character : characters) byte(character);
  }
  std::int64_t hash_ = 0x12345678;
  std::uint64_t nested_ = 0;
};

TEST(Frame, FingerprintIsTheOneOfItsDeclaredLayout) {
  Fingerprint vector, quaternion, frame;
  vector.member("x", "double").member("y", "double").member("z", "double");
  quaternion.member("w", "double")
      .member("x", "double")
      .member("y", "double")
      .member("z", "double");
  frame.member("position").member("orientation").nested(vector.value()).nested(quaternion.value());
  EXPECT_EQ(static_cast<std::uint64_t>(Frame::fingerprint()), frame.value());
}

TEST(Frame, PrintsMillimetresAndDegreesWithoutNegativeZeros) {
  EXPECT_EQ(to_string(Frame::from_euler_zyz(0.4521, -0.15, -1e-9, 0, 90_deg, -1e-9)),
            "(452.1, -150.0, 0.0) mm, ZYZ (0.00, 90.00, 0.00) deg");
}

}  // namespace
}  // namespace robcl
