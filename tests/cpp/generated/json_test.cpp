#include "gecos/wire/json.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "everything_calls.hpp"
#include "everything_json.hpp"

using gecos::wire::from_json;
using gecos::wire::from_json_text;
using gecos::wire::to_json;
using gecos::wire::to_json_text;

TEST(GeneratedJson, AValueIsAnObjectOfItsMembers) {
  everything::Limits value;
  value.both = -0.5;
  value.lower = std::numeric_limits<float>::infinity();
  value.few = 2;
  EXPECT_EQ(to_json(value), nlohmann::json::parse(R"({"both": -0.5, "lower": "inf", "upper": 0,
                                                      "share": 0, "few": 2})"));
  const auto again = from_json<everything::Limits>(to_json(value));
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(*again, value);
}

TEST(GeneratedJson, TextHasTheMembersInTheOrderOfTheInterface) {
  EXPECT_EQ(to_json_text(everything::Grows{}),
            R"({"first":0,"second":2.5,"third":null,"fourth":"x"})");
  EXPECT_EQ(to_json_text(everything::Base{}, 2), "{\n  \"below\": 0\n}");
}

TEST(GeneratedJson, WhatIsLeftOutHasItsDefault) {
  const auto value = from_json_text<everything::Grows>("{}");
  ASSERT_TRUE(value) << value.error().message();
  EXPECT_EQ(*value, everything::Grows{});
}

TEST(GeneratedJson, ValuesMadeByAProgramMayHaveSignedNumbers) {
  const auto value = from_json<everything::Numbers>({{"u64", 7}, {"i64", 7u}, {"single", 2}});
  ASSERT_TRUE(value) << value.error().message();
  EXPECT_EQ(value->u64, 7u);
  EXPECT_EQ(value->i64, 7);
  EXPECT_EQ(value->single, 2.0F);
}

TEST(GeneratedJson, AnEnumeratorThatDoesNotExistStandsAsItsNumberAndIsNotTaken) {
  const auto json = to_json(static_cast<everything::Strict>(-5));
  EXPECT_EQ(json, -5);
  const auto again = from_json<everything::Strict>(json);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().message(), "a name is expected, a number is there");
}

TEST(GeneratedJson, TextThatIsNotUtf8IsWrittenAllTheSame) {
  everything::Derived value;
  value.above = "\xff!";
  EXPECT_EQ(to_json_text(value), "{\"below\":0,\"above\":\"\xEF\xBF\xBD!\"}");
  EXPECT_FALSE(from_json<everything::Derived>(to_json(value)));
}

TEST(GeneratedJson, SecretsAreHiddenAndNotTakenForThemselves) {
  everything::Words value;
  value.pass = "hunter2";
  EXPECT_EQ(to_json(value)["pass"], "***");
  const auto again = from_json<everything::Words>(to_json(value));
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().path, "pass");
}

TEST(GeneratedJson, DeepNestingIsRefusedBeforeItIsFollowed) {
  std::string text;
  for (int i = 0; i < 100'000; ++i) text += "{\"below\":[";
  for (int i = 0; i < 100'000; ++i) text += "]}";
  const auto value = from_json_text<everything::Tree>(text);
  ASSERT_FALSE(value);
  EXPECT_EQ(value.error().message(), "nested deeper than 100");
}

TEST(GeneratedJson, ArgumentsAndResultsAreStructs) {
  const everything::Stage_paint_arguments arguments{everything::Colour::RED, {"a"}, 4};
  EXPECT_EQ(to_json_text(arguments), R"({"what":"RED","words":["a"],"times":4})");
  const auto again =
      from_json_text<everything::Stage_paint_arguments>(R"({"what": "RED", "words": ["a"]})");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->times, 3) << "its default";
  EXPECT_EQ(to_json_text(everything::Stage_level_result{2.5}), R"({"result":2.5})");
}

TEST(GeneratedJson, ArgumentsThatAreMissingOrUnknownOrOutsideTheirRangeAreNamed) {
  const auto why = [](std::string_view text) {
    return from_json_text<everything::Stage_paint_arguments>(text).error().message();
  };
  EXPECT_EQ(why(R"({"what": "RED"})"), "words: it is missing");
  EXPECT_EQ(why(R"({"often": 1})"),
            "often: unknown member; the known members are what, words, times");
  EXPECT_EQ(why(R"({"what": "RED", "words": [], "times": 10})"),
            "paint.times: 10 is outside [0, 9]; give at most 9");
  EXPECT_EQ(why(R"({"what": "RED", "words": ["12345"]})"),
            "paint.words: 5 bytes, at most 4 fit; shorten it");
}

TEST(GeneratedJson, ArgumentsAreReadFromTheBytesOfACall) {
  const everything::Stage_paint_arguments arguments{everything::Colour::BLUE, {"ab", ""}, 9};
  const auto bytes = gecos::layout::to_bytes(arguments);
  const auto read = gecos::layout::from_bytes<everything::Stage_paint_arguments>(bytes);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(to_json_text(*read), to_json_text(arguments));
  const auto short_by_one = gecos::ByteView(bytes).first(bytes.size() - 1);
  const auto refused = gecos::layout::from_bytes<everything::Stage_paint_arguments>(short_by_one);
  ASSERT_FALSE(refused);
  EXPECT_STREQ(refused.error().field, "paint.times");
}
