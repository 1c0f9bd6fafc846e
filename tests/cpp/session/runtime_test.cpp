#include "gecos/session/process/runtime.hpp"

#include <gtest/gtest.h>

#include "child.hpp"

namespace {

using gecos::session::process_incarnation;

TEST(ProcessIncarnation, IsOneForAProcessAndAnotherForEachOfItsForkedChildren) {
  const auto parents = process_incarnation();
  EXPECT_NE(gecos::number(parents), 0u);
  const auto tell = [](probe::Child::Line& line) {
    line.hear();
    line.say(std::to_string(gecos::number(process_incarnation())));
    line.say(std::to_string(gecos::number(process_incarnation())));
  };
  probe::Child one(tell);
  probe::Child other(tell);
  std::vector<std::string> heard;
  for (probe::Child* child : {&one, &other}) {
    child->line().say("tell");
    heard.push_back(child->line().hear());
    EXPECT_EQ(child->line().hear(), heard.back());
  }
  EXPECT_NE(heard[0], heard[1]);
  EXPECT_NE(heard[0], std::to_string(gecos::number(parents)));
  EXPECT_NE(heard[1], std::to_string(gecos::number(parents)));
  EXPECT_EQ(process_incarnation(), parents);
}

}  // namespace
