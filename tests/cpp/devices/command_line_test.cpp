#include "devices/support/command_line.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <initializer_list>
#include <string>
#include <vector>

namespace devices {
namespace {

CommandLine started_with(std::vector<std::string> words) {
  words.insert(words.begin(), "robcl-belt");
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  return CommandLine("robcl-belt", "Serves a belt.",
                     {{"name", "BELT", "name to register"}, {"speed", "0.5", "m/s"}},
                     static_cast<int>(pointers.size()), pointers.data());
}

TEST(CommandLine, WhatIsNotGivenHasItsStandardValue) {
  const CommandLine line = started_with({"--speed", "1.25"});
  EXPECT_FALSE(line.exit_status().has_value());
  EXPECT_EQ(line.text("name"), "BELT");
  EXPECT_EQ(line.number("speed"), 1.25);
}

TEST(CommandLine, InsecureIsAFlagWithoutAValueAndNoVariableSetsIt) {
  ::setenv("GECOS_INSECURE", "1", 1);
  EXPECT_EQ(started_with({}).admission(), gecos::Admission::Listed);
  ::unsetenv("GECOS_INSECURE");
  const CommandLine line = started_with({"--insecure", "--speed", "1.25"});
  EXPECT_FALSE(line.exit_status().has_value());
  EXPECT_EQ(line.admission(), gecos::Admission::Insecure);
  EXPECT_EQ(line.number("speed"), 1.25);
}

TEST(CommandLine, HelpNamesEveryOptionWithItsStandardValueAndEndsWell) {
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(started_with({"--help"}).exit_status(), 0);
  EXPECT_EQ(
      ::testing::internal::GetCapturedStdout(),
      "usage: robcl-belt [--WORD VALUE]... [--insecure]\n"
      "Serves a belt.\n"
      "  --name              name to register (BELT)\n"
      "  --speed             m/s (0.5)\n"
      "  --clock             simulated seconds per second of real time; default: ROBCL_CLOCK, "
      "if set (1)\n"
      "  --insecure          admit every user of every host; for simulated devices only\n"
      "Prints one line when it is ready and ends on SIGINT or SIGTERM.\n");
}

TEST(CommandLine, TheUsageHasTheArgumentThatTheProgramReadsItself) {
  ::testing::internal::CaptureStderr();
  CommandLine line("robcl-belt", "Serves a belt.", {}, 0, nullptr, "BELT.toml");
  EXPECT_FALSE(line.exit_status().has_value());
  line.refuse("the file is missing");
  EXPECT_EQ(line.exit_status(), 2);
  EXPECT_EQ(
      ::testing::internal::GetCapturedStderr(),
      "robcl-belt: the file is missing\n"
      "usage: robcl-belt BELT.toml [--WORD VALUE]... [--insecure]\n"
      "Serves a belt.\n"
      "  --clock             simulated seconds per second of real time; default: ROBCL_CLOCK, "
      "if set (1)\n"
      "  --insecure          admit every user of every host; for simulated devices only\n"
      "Prints one line when it is ready and ends on SIGINT or SIGTERM.\n");
}

TEST(CommandLine, SaysWhatIsWrongWithAWordBeforeTheUsage) {
  const auto says = [](std::vector<std::string> words) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(started_with(std::move(words)).exit_status(), 2);
    const std::string said = ::testing::internal::GetCapturedStderr();
    return said.substr(0, said.find('\n'));
  };
  EXPECT_EQ(says({"--sped", "1"}), "robcl-belt: '--sped' is not an option of this program");
  EXPECT_EQ(says({"--speed"}), "robcl-belt: '--speed' needs a value");
  EXPECT_EQ(says({"--speed", "fast"}), "robcl-belt: '--speed' needs a number, not 'fast'");
  EXPECT_EQ(says({"--speed", "nan"}), "robcl-belt: '--speed' needs a number, not 'nan'");
}

TEST(CommandLine, EveryProgramHasAClockWhoseDefaultIsThatOfTheLaboratory) {
  EXPECT_EQ(started_with({}).clock(), 1);
  EXPECT_EQ(started_with({"--clock", "10"}).clock(), 10);
  ::setenv("ROBCL_CLOCK", "20", 1);
  EXPECT_EQ(started_with({}).clock(), 20);
  EXPECT_EQ(started_with({"--clock", "0.5"}).clock(), 0.5);
  ::setenv("ROBCL_CLOCK", "", 1);  // as in all our variables, the same as unset
  EXPECT_EQ(started_with({}).clock(), 1);
  ::unsetenv("ROBCL_CLOCK");
}

TEST(CommandLine, AnImpossibleClockIsRefusedAndSoIsThatOfTheLaboratory) {
  const auto says = [](std::vector<std::string> words) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(started_with(std::move(words)).exit_status(), 2);
    const std::string said = ::testing::internal::GetCapturedStderr();
    return said.substr(0, said.find('\n'));
  };
  EXPECT_EQ(says({"--clock", "0"}),
            "robcl-belt: '--clock' needs a number from 0.1 to 100000, not '0'");
  EXPECT_EQ(says({"--clock", "100001"}),
            "robcl-belt: '--clock' needs a number from 0.1 to 100000, not '100001'");
  ::setenv("ROBCL_CLOCK", "fast", 1);
  EXPECT_EQ(says({}), "robcl-belt: ROBCL_CLOCK needs a number from 0.1 to 100000, not 'fast'");
  EXPECT_EQ(says({"--clock", "fast"}),
            "robcl-belt: '--clock' needs a number from 0.1 to 100000, not 'fast'");
  ::unsetenv("ROBCL_CLOCK");
}

}  // namespace
}  // namespace devices
