#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "everything_types.hpp"
#include "gecos/object_types.hpp"
#include "gecos/wire/contents.hpp"
#include "robcl/manipulator_types.hpp"

using namespace everything;

namespace {

template <class T>
std::string printed(const T& value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

template <class T>
std::string why_refused(const gecos::Bytes& bytes) {
  const auto decoded = gecos::wire::from_bytes<T>(bytes);
  return decoded ? "accepted" : decoded.error().message();
}

}  // namespace

TEST(GeneratedTypes, HaveTheDefaultsOfTheInterface) {
  const robcl::Trajectory how;
  EXPECT_EQ(how.speed, 1.0);
  EXPECT_EQ(how.path, robcl::PathType::JOINT);
  EXPECT_FALSE(how.tool_speed);
  EXPECT_EQ(Grows{}.fourth, "x");
  EXPECT_EQ(HALF, 0.5);
  EXPECT_EQ(LEAST, std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(GREETING, "say \"hello\"");
}

TEST(GeneratedTypes, HaveTheEnumsOwnDefaultInArraysToo) {
  const Arrays arrays;
  for (const auto& row : arrays.colours) {
    for (const Colour each : row) EXPECT_EQ(each, Colour::GREEN);
  }
}

TEST(GeneratedTypes, SayWhatMustNotBeSentByItsName) {
  robcl::Trajectory how;
  EXPECT_EQ(gecos_violation(how), "");
  how.speed = 3;
  EXPECT_EQ(gecos_violation(how), "Trajectory.speed: 3 is outside [0.01, 1.0]; give at most 1.0");
  how.speed = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(gecos_violation(how), "Trajectory.speed: nan is outside [0.01, 1.0]; give a number");

  Limits limits;
  limits.few = 1;
  EXPECT_EQ(gecos_violation(limits), "");
  limits.share = 101;
  EXPECT_EQ(gecos_violation(limits), "Limits.share: 101 is outside [0, 100]; give at most 100");

  Sequences many;
  many.few = {1, 2, 3, 4};
  EXPECT_EQ(gecos_violation(many), "Sequences.few: 4 elements, at most 3 fit; shorten it");
  many.few.clear();
  many.words = {"abcde"};
  EXPECT_EQ(gecos_violation(many), "Sequences.words: 5 bytes, at most 4 fit; shorten it");
  many.words = {"\xff"};
  EXPECT_EQ(gecos_violation(many),
            "Sequences.words: the string is not UTF-8 or contains NUL; convert it to UTF-8");
  many.words.clear();
  many.percents = {100, 101};
  EXPECT_EQ(gecos_violation(many),
            "Sequences.percents[1]: 101 is outside [0, 100]; give at most 100");

  Holds nested;
  nested.many.resize(2);
  nested.many[1].fourth = std::string("\0", 1);
  EXPECT_EQ(gecos_violation(nested),
            "Grows.fourth: the string is not UTF-8 or contains NUL; convert it to UTF-8");

  Shape shape = Shape::make_radius(1.0);
  EXPECT_EQ(gecos_violation(shape), "");
  shape.tag = Colour::BLUE;
  EXPECT_EQ(
      gecos_violation(shape),
      "Shape: the value does not agree with the union's discriminator; make it with one of the "
      "functions make_…");

  Packed bits;
  bits.mode = 8;
  EXPECT_EQ(gecos_violation(bits), "Packed.mode: 8 is outside [0, 7]; give at most 7");
}

TEST(GeneratedTypes, RefuseWhatIsOutOfRangeWhereItLies) {
  Limits limits;
  limits.few = 1;
  gecos::Bytes bytes = gecos::wire::to_bytes(limits);
  bytes.back() = std::byte{9};
  EXPECT_EQ(why_refused<Limits>(bytes), "field 'Limits.few' at byte " +
                                            std::to_string(bytes.size() - 2) +
                                            ": 9 is outside [1, 3]; give at most 3");
}

TEST(GeneratedTypes, ReadAnUnknownEnumeratorAsTheDefaultLiteralOrRefuseIt) {
  gecos::Bytes bytes = gecos::wire::to_bytes(gecos::Grant{gecos::Status::MASTER, 7});
  bytes[3] = std::byte{99};
  const auto grant = gecos::wire::from_bytes<gecos::Grant>(bytes);
  ASSERT_TRUE(grant);
  EXPECT_EQ(grant->status, gecos::Status::SENSOR);

  bytes = gecos::wire::to_bytes(Masks{});
  bytes.back() = std::byte{5};
  EXPECT_NE(why_refused<Masks>(bytes).find("Masks.level"), std::string::npos);
}

TEST(GeneratedTypes, ReadOlderWritersWithDefaultsAndNewerOnesByWhatIsKnown) {
  const auto older = gecos::wire::from_bytes<Grows>(gecos::Bytes(4));
  ASSERT_TRUE(older);
  EXPECT_EQ(*older, Grows{});
  gecos::Bytes newer = gecos::wire::to_bytes(Grows{});
  newer.resize(newer.size() + 5, std::byte{7});
  EXPECT_EQ(gecos::wire::from_bytes<Grows>(newer), Grows{});
  EXPECT_FALSE(gecos::wire::from_bytes<Grows>(gecos::Bytes(2)));
}

TEST(GeneratedTypes, BoundTheirDepthWhereTheyHoldThemselves) {
  Tree tree;
  for (int i = 1; i < gecos::wire::max_depth; ++i) {
    Tree above;
    above.below.push_back(tree);
    tree = above;
  }
  EXPECT_EQ(gecos::wire::from_bytes<Tree>(gecos::wire::to_bytes(tree)), tree);
  Tree deeper;
  deeper.below.push_back(tree);
  EXPECT_NE(why_refused<Tree>(gecos::wire::to_bytes(deeper)).find("nested deeper"),
            std::string::npos);
}

TEST(GeneratedTypes, HaveUnionsThatNameTheirArms) {
  const Choice choice = Choice::make_text("two", 2);
  EXPECT_EQ(choice.tag, 2);
  ASSERT_NE(choice.text(), nullptr);
  EXPECT_EQ(*choice.text(), "two");
  EXPECT_EQ(choice.small(), nullptr);
  EXPECT_EQ(printed(choice), "Choice{tag=2, text=\"two\"}");
}

TEST(GeneratedTypes, HaveMasksThatCombine) {
  const Lamps both = Lamps::LEFT | Lamps::TOP;
  EXPECT_TRUE(has(both, Lamps::TOP));
  EXPECT_FALSE(has(both, Lamps::RIGHT));
  EXPECT_EQ(printed(both), "LEFT|TOP");
  EXPECT_EQ(printed(Lamps{}), "none");
}

TEST(GeneratedTypes, PrintUnitsAndHideSecrets) {
  Words words;
  words.pass = "hunter2";
  words.value = 1.5;
  const std::string text = printed(words);
  EXPECT_EQ(text.find("hunter2"), std::string::npos);
  EXPECT_NE(text.find("pass=***"), std::string::npos);
  EXPECT_NE(text.find("value=1.5 m"), std::string::npos);
}

TEST(GeneratedTypes, AskAboutTheUnitOfAValueUnlessTheObjectComputedIt) {
  const auto asks = [](const robcl::JointLimit& limit) {
    return printed(limit).find("; is the value in degrees?") != std::string::npos;
  };
  robcl::JointLimit given{.axis = 4, .value = 45, .lower = -1, .upper = 1};
  EXPECT_TRUE(asks(given));
  robcl::JointLimit on_the_way = given, at_the_goal = given;
  on_the_way.place = robcl::PlaceOnLine{.way = 0.1};
  at_the_goal.configuration = robcl::Configuration{};
  EXPECT_FALSE(asks(on_the_way));
  EXPECT_FALSE(asks(at_the_goal));
}

TEST(GeneratedTypes, KnowTheirNameAndFingerprint) {
  EXPECT_EQ(robcl::OutOfReach::type_name(), "robcl::OutOfReach");
  static_assert(robcl::Vector::fingerprint() != 0);
  static_assert(gecos::wire::GeneralContents<Shape>);
  static_assert(gecos::wire::GeneralContents<Holds>);
}
