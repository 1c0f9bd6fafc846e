// Names that mean something else elsewhere, types that hold each other, ranges and secrets
// everywhere. The interfaces stand in tests/idl/corners; their sources are compiled as one.
#include <gtest/gtest.h>

#include <concepts>
#include <limits>
#include <sstream>

#include "bounded_client.hpp"
#include "bounded_json.hpp"
#include "bounded_server.hpp"
#include "direct_session.hpp"
#include "gecos/wire/json.hpp"
#include "letters_types.hpp"
#include "places_client.hpp"
#include "places_server.hpp"
#include "reopened_server.hpp"

namespace {

using namespace bounded;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

template <class T>
std::string printed(const T& value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

/// What the receiver says of bytes that a sender should not have sent.
template <class T>
std::string on_receipt(const T& value) {
  const auto decoded = gecos::wire::from_bytes<T>(gecos::wire::to_bytes(value));
  return decoded ? "accepted" : decoded.error().message();
}

/// Refused on both sides, and `member` is named.
template <class T>
void expect_refused(const T& value, const std::string& member) {
  const std::string why = gecos_violation(value);  // may name an element: "Arrays.pose[2]: …"
  EXPECT_TRUE(why.rfind(member + ": ", 0) == 0 || why.rfind(member + "[", 0) == 0) << why;
  EXPECT_NE(on_receipt(value).find(member), std::string::npos) << on_receipt(value);
}

template <class T>
void expect_accepted(const T& value) {
  EXPECT_EQ(gecos_violation(value), "");
  EXPECT_EQ(on_receipt(value), "accepted");
}

}  // namespace

TEST(GeneratedNames, AreAbsolute) {
  static_assert(std::same_as<decltype(a::x::S::k), ::geo::P>);
  static_assert(std::same_as<decltype(a::x::All::kind), ::geo::Kind>);
  static_assert(std::same_as<decltype(a::x::All::marks), ::geo::Marks>);
  static_assert(std::same_as<decltype(a::x::All::frame), ::robcl::Frame>);
  static_assert(std::same_as<decltype(a::x::All::root), ::Root>);
  static_assert(std::derived_from<a::x::Site, ::geo::Site>);
  static_assert(std::derived_from<a::x::SiteServant, ::geo::SiteServant>);
  const a::x::S sent{.k = {.small = 7}};
  EXPECT_EQ(gecos::wire::to_bytes(sent).size(), 4u);
  EXPECT_EQ(gecos::wire::from_bytes<a::x::S>(gecos::wire::to_bytes(sent)), sent);
}

TEST(GeneratedTypes, MayHoldEachOtherAcrossOpeningsOfTheirModule) {
  tree::Node leaf;
  leaf.chosen = tree::Choice::make_below({});
  tree::Node node;
  node.below = {leaf, leaf};
  node.chosen = tree::Choice::make_others({tree::Choice::make_below(node.below)});
  EXPECT_EQ(gecos::wire::from_bytes<tree::Node>(gecos::wire::to_bytes(node)), node);
}

TEST(GeneratedLetters, AreOneByteOfLatin1) {
  EXPECT_EQ(static_cast<unsigned char>(letters::BIG), 0xff);
  EXPECT_EQ(letters::ZERO, 0);
  EXPECT_EQ(letters::S1,
            "a\x01"
            "1?"
            "?=?");
  EXPECT_EQ(letters::Cs{}.c, static_cast<char>(0xfe));
  for (const auto& letter : {letters::Letter::make_a(5), letters::Letter::make_z(6)}) {
    EXPECT_EQ(gecos_violation(letter), "");
    EXPECT_EQ(gecos::wire::from_bytes<letters::Letter>(gecos::wire::to_bytes(letter)), letter);
  }
  const auto bytes = gecos::wire::to_bytes(letters::Letter::make_a(5));
  EXPECT_EQ(bytes[3], std::byte{0xff});  // its tag
}

TEST(GeneratedRanges, HoldInArrays) {
  Arrays arrays;
  expect_accepted(arrays);
  arrays.pose = {3, -3, 3};
  expect_accepted(arrays);
  for (const double outside : {3.5, -3.5, not_a_number}) {
    arrays.pose = {0, 0, outside};
    expect_refused(arrays, "Arrays.pose");
  }
  arrays = {};
  arrays.grid[1][0] = 4;
  expect_refused(arrays, "Arrays.grid");
  arrays = {};
  arrays.trims[1] = -1.5F;
  expect_refused(arrays, "Arrays.trims");
  arrays = {};
  arrays.duty[3] = 11;
  EXPECT_EQ(gecos_violation(arrays), "Arrays.duty[3]: 11 is outside [0, 10]; give at most 10");
  expect_refused(arrays, "Arrays.duty");
  arrays = {};
  arrays.shares[0] = std::numeric_limits<float>::infinity();
  expect_accepted(arrays);
  arrays.shares[0] = -0.5F;
  expect_refused(arrays, "Arrays.shares");
}

TEST(GeneratedRanges, SayWhereTheFirstNumberOutsideLies) {
  Arrays arrays;
  arrays.pose = {0, 5, 7};
  const auto decoded = gecos::wire::from_bytes<Arrays>(gecos::wire::to_bytes(arrays));
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().offset, 8u);
  EXPECT_EQ(gecos_violation(arrays), "Arrays.pose[1]: 5 is outside [-3.0, 3.0]; give at most 3.0");
}

TEST(GeneratedRanges, HoldInSequencesAndOptionals) {
  Sequences some;
  expect_accepted(some);
  some.along = {1, 2, 3, 3.5};
  expect_refused(some, "Sequences.along");
  some = {};
  some.steps = {Joints{1, 1, 1}, Joints{1, not_a_number, 1}};
  expect_refused(some, "Sequences.steps");
  some = {};
  some.rows = {{1, 9}, {}, {0}};
  expect_refused(some, "Sequences.rows");
  some = {};
  some.counts = {100, 101};
  expect_refused(some, "Sequences.counts");
  some = {};
  some.lows = {2};
  expect_accepted(some);
  some.lows = {2.5};
  expect_refused(some, "Sequences.lows");
  some = {};
  some.maybe = {0, 0, 4};
  expect_refused(some, "Sequences.maybe");
  some = {};
  some.part = 1.5;
  expect_refused(some, "Sequences.part");
}

TEST(GeneratedRanges, HoldInMaps) {
  Maps maps;
  maps.angles[1] = 3;
  expect_accepted(maps);
  maps.angles[10] = 0;
  expect_refused(maps, "Maps.angles");
  maps.angles = {{1, -4}};
  expect_refused(maps, "Maps.angles");
  maps = {};
  maps.poses["there"] = {0, 0, 4};
  expect_refused(maps, "Maps.poses");
  maps = {};
  maps.paths[9] = {0, 0, 4};
  expect_refused(maps, "Maps.paths");
}

TEST(GeneratedRanges, HoldInUnionsAndExceptions) {
  expect_accepted(Arm::make_one(3));
  expect_refused(Arm::make_one(4), "Arm.one");
  expect_refused(Arm::make_all({0, 0, 4}), "Arm.all");
  expect_refused(Arm::make_large(4), "Arm.large");
  expect_refused(Arm::make_along({9}, 9), "Arm.along");
  expect_refused(Broken{.at = 4, .token = "t"}, "Broken.at");
}

namespace {

class Bounded final : public RobotServant {
 public:
  Joints answer{};
  Robot_both_result pair;
  bool raises = false;
  bool called = false;

 private:
  gecos::Result<void> go(const Joints&, const std::map<Level, Angle>&,
                         const std::optional<Path>&) override {
    called = true;
    if (raises) return tl::unexpected(Broken{.at = answer[0], .token = "hush"});
    return {};
  }
  gecos::Result<Joints> where() override { return answer; }
  gecos::Result<Robot_both_result> both() override { return pair; }
  gecos::Result<Joints> now() override { return answer; }
  gecos::Result<Path> plan() override { return Path{answer[0]}; }
  gecos::Result<void> set_plan(const Path&) override { return {}; }
  gecos::Result<void> run(Angle, gecos::Execution<Arrays>&) override { return {}; }
};

struct BoundedCalls : testing::Test {
  Bounded servant;
  std::shared_ptr<Direct> session = std::make_shared<Direct>(servant);
  Robot robot{session};

  template <class Command>
  std::string refusal(Command command) {
    const auto result = command.get();
    return result ? "accepted" : result.error().text;
  }
};

TEST_F(BoundedCalls, RefuseArgumentsBeforeTheyAreSent) {
  EXPECT_EQ(refusal(robot.go({0, 0, 4}, {})),
            "go.to[2]: 4 is outside [-3.0, 3.0]; give at most 3.0");
  EXPECT_EQ(refusal(robot.go({}, {{10, 0}})), "go.by_level: 10 is outside [1, 9]; give at most 9");
  EXPECT_EQ(refusal(robot.go({}, {{1, 4}})),
            "go.by_level: 4 is outside [-3.0, 3.0]; give at most 3.0");
  EXPECT_EQ(refusal(robot.go({}, {}, Path{4})),
            "go.along[0]: 4 is outside [-3.0, 3.0]; give at most 3.0");
  EXPECT_EQ(refusal(robot.set_plan({4})),
            "plan.value[0]: 4 is outside [-3.0, 3.0]; give at most 3.0");
  EXPECT_EQ(refusal(robot.run(not_a_number)), "run.to: nan is outside [-3.0, 3.0]; give a number");
  EXPECT_EQ(session->sent, 0);
  EXPECT_EQ(refusal(robot.go({3, 3, 3}, {{9, 3}}, Path{3})), "accepted");
}

TEST_F(BoundedCalls, RefuseArgumentsWhereTheyArrive) {
  for (const auto& operation : Robot::gecos_description().operations) {
    if (operation.name != "go") continue;
    gecos::Bytes arguments(24 + 4 + 1);
    gecos::wire::Encoder(std::span(arguments)).put(0.0, 0.0, 4.0);
    const gecos::Command<void> sent(session->send(operation, arguments));
    EXPECT_EQ(sent.get().error().detail, gecos::Detail::BadParameter);
    EXPECT_FALSE(servant.called);
    return;
  }
  FAIL() << "there is no operation go";
}

TEST_F(BoundedCalls, RefuseResults) {
  servant.answer = {0, 4, 0};
  EXPECT_NE(refusal(robot.where()).find("where[1]: 4 is outside"), std::string::npos);
  EXPECT_NE(refusal(robot.now()).find("now[1]: 4 is outside"), std::string::npos);
  servant.pair.along = {0, 4};
  EXPECT_NE(refusal(robot.both()).find("both.along[1]: 4 is outside"), std::string::npos);
  servant.pair = {};
  servant.pair.result = -4;
  EXPECT_NE(refusal(robot.both()).find("both.result: -4 is outside"), std::string::npos);
}

TEST_F(BoundedCalls, DoNotRaiseWhatTheInterfaceForbids) {
  servant.raises = true;
  servant.answer = {4, 0, 0};
  const auto gone = robot.go({}, {}).get();
  ASSERT_FALSE(gone);
  EXPECT_FALSE(gone.error().as<Broken>());
  EXPECT_EQ(gone.error().text,
            "the handler raised Broken.at: 4 is outside [-3.0, 3.0]; give at most 3.0");
}

TEST_F(BoundedCalls, TellNoSecretOfAnException) {
  servant.raises = true;
  const auto gone = robot.go({}, {}).get();
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().text, "Broken{at=0, token=***}");
  EXPECT_EQ(gone.error().as<Broken>()->token, "hush");
}

TEST(GeneratedSecrets, AreNotPrinted) {
  const Login login{.name = "eve", .password = "hush", .pin = "1234"};
  EXPECT_EQ(printed(login), "Login{name=\"eve\", password=***, pin=***}");
  EXPECT_EQ(printed(Arm::make_password("hush")), "Arm{tag=4, password=***}");
  Robot_both_result both;
  both.token = "hush";
  EXPECT_EQ(printed(both), "Robot_both_result{result=0, along=[], token=***}");
  EXPECT_EQ(printed(Broken{.at = 1, .token = "hush"}), "Broken{at=1, token=***}");
}

TEST(GeneratedSecrets, AreHiddenInJson) {
  using gecos::wire::from_json_text;
  using gecos::wire::to_json_text;
  EXPECT_EQ(to_json_text(Arm::make_password("hush")), R"({"tag":4,"value":"***"})");
  EXPECT_EQ(to_json_text(Arm::make_one(2)), R"({"tag":1,"value":2.0})");
  EXPECT_EQ(from_json_text<Arm>(R"({"tag":4,"value":"said"})"), Arm::make_password("said"));
  EXPECT_FALSE(from_json_text<Arm>(R"({"tag":4,"value":"***"})"));
}

TEST(GeneratedSecrets, AreNotInTextsOfErrors) {
  const Login login{.name = "eve", .password = "much too long", .pin = {}};
  EXPECT_EQ(gecos_violation(login).find("much"), std::string::npos);
  EXPECT_EQ(gecos_violation(Arm::make_password("much too long")).find("much"), std::string::npos);
}

}  // namespace
