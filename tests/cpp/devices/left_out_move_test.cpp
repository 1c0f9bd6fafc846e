// After a move that is not made, the arm does not go to the goals that its caller asked for after
// it, by the set points that the driver receives.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "rx90_fixture.hpp"

namespace devices {
namespace {

using gecos::Detail;
using robcl::translate;
using namespace robcl::literals;

class LeftOutMoves : public Rx90Laboratory {
 protected:
  using Moves = std::vector<gecos::Command<void, robcl::MotionProgress>>;

  void SetUp() override {
    Rx90Laboratory::SetUp();
    lease_.emplace(*gecos::actor(robot_));
    start_ = tool();
  }
  Frame tool() {
    robcl::arm::Kinematics forward(described_.model);
    return forward.base_from_flange(arm_.sample().commanded) * arm_.tool_offset();
  }
  /// Asks for a straight move to the place `side` beside the start and `up` above it.
  void ask(double side, double up, robcl::Blend at_goal = robcl::Blend::NOBREAK) {
    moves_.push_back(
        robot_.move(start_ * translate(0, side, -up),
                    robcl::Trajectory{.path = robcl::PathType::STRAIGHT, .at_goal = at_goal}));
  }
  /// Cycles of the control loop until all moves have ended. Notes how far up a set point is.
  void let_end() {
    const auto work = [this] {
      cycle()();
      highest_ = std::max(highest_, std::abs(tool().z() - start_.z()));
    };
    for (const auto& move : moves_) get(move, work);
    for (int i = 0; i < 25; ++i) work();
  }
  void expect_made(std::size_t which) {
    const auto moved = moves_[which].get();
    EXPECT_TRUE(moved) << which << ": " << moved.error();
  }
  void expect_ended(std::size_t which, Detail detail, const std::string& words) {
    const auto ended = moves_[which].get();
    ASSERT_FALSE(ended) << which;
    EXPECT_EQ(ended.error().detail, detail) << which << ": " << ended.error();
    EXPECT_NE(ended.error().text.find(words), std::string::npos) << ended.error();
  }
  /// Expects that the arm stands `side` beside the start, and was never up.
  void expect_stands_beside(double side) {
    EXPECT_FALSE(arm_.moving());
    EXPECT_LT(distance(tool(), start_ * translate(0, side, 0)), 1e-6);
    EXPECT_LT(highest_, 1e-5) << "a set point leads to a later goal";
  }

  static constexpr double out_of_reach = 5;
  std::optional<gecos::Lease> lease_;
  Frame start_;
  Moves moves_;
  double highest_ = 0;
};

TEST_F(LeftOutMoves, AreThoseAfterAFirstMoveThatIsOutOfReach) {
  ask(out_of_reach, 0);
  ask(0, 80_mm);
  ask(60_mm, 80_mm, robcl::Blend::BREAK);
  let_end();
  expect_ended(0, Detail::Fault, "OutOfReach");
  expect_ended(1, Detail::Rejected, "'move' of the same caller did not succeed");
  expect_ended(2, Detail::Rejected, "FAULT, OutOfReach");
  expect_stands_beside(0);
}

TEST_F(LeftOutMoves, AreThoseAfterOneInTheMiddleOfAChain) {
  ask(30_mm, 0);
  ask(60_mm, 0);
  ask(out_of_reach, 0);
  ask(60_mm, 80_mm);
  ask(0, 80_mm, robcl::Blend::BREAK);
  let_end();
  expect_made(0);
  expect_made(1);
  expect_ended(2, Detail::Fault, "OutOfReach");
  expect_ended(3, Detail::Rejected, "OutOfReach");
  expect_ended(4, Detail::Rejected, "OutOfReach");
  expect_stands_beside(60_mm);
}

TEST_F(LeftOutMoves, IsNothingBeforeALastOneAndNothingThatBeginsAnew) {
  ask(30_mm, 0);
  ask(60_mm, 0);
  ask(out_of_reach, 0, robcl::Blend::BREAK);
  let_end();
  expect_made(0);
  expect_made(1);
  expect_ended(2, Detail::Fault, "OutOfReach");
  expect_stands_beside(60_mm);
  moves_.clear();
  ask(0, 0);
  ask(30_mm, 0, robcl::Blend::BREAK);
  let_end();
  expect_made(0);
  expect_made(1);
  expect_stands_beside(30_mm);
}

TEST_F(LeftOutMoves, AreThoseThatAreAskedForLongAfterTheArmStandsButBeforeTheRefusalIsSeen) {
  ask(out_of_reach, 0);
  const auto standing = [&] { return robot_.standing().get().value_or(false); };
  for (int i = 0; i < 50 || !standing(); ++i) cycle()();
  ask(60_mm, 80_mm);
  ask(0, 80_mm, robcl::Blend::BREAK);
  let_end();
  expect_ended(1, Detail::Rejected, "OutOfReach");
  expect_ended(2, Detail::Rejected, "OutOfReach");
  expect_stands_beside(0);
}

TEST_F(LeftOutMoves, AreThoseAfterAMoveThatIsCanceledWhileItWaits) {
  ask(60_mm, 0, robcl::Blend::BREAK);
  ask(60_mm, 80_mm);
  ask(0, 80_mm, robcl::Blend::BREAK);
  moves_[1].cancel();
  let_end();
  expect_made(0);
  expect_ended(1, Detail::Canceled, "canceled before it started");
  expect_ended(2, Detail::Canceled, "an earlier command of the same client was canceled");
  expect_stands_beside(60_mm);
}

}  // namespace
}  // namespace devices
