// What a TOML file says about an arm, and the errors of bad ones.
#include "devices/arm/arm_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "devices/rx90/rx90_files.hpp"
#include "robcl/frames/units.hpp"

namespace devices {
namespace {

using robcl::deg;
using Parsed = tl::expected<ArmDescription, ArmFileError>;

const std::string good = R"(name = "BENCH"
description = "arm of a test"
urdf = "rx90.urdf"
base_link = "foot"
flange_link = "flange"
seconds_to_full_speed = 0.5
front_deg = [0, -20, 110, 0, -45, 0]
start_deg = [0, -20, 110, 0, 90, 1.5]
place = "it stands in a test"
[tool]
offset_mm = [10, 20, 30]
offset_zyz_deg = [0, 90, 0]
speed_m_per_s = 0.5
acceleration_m_per_s2 = 2
turn_speed_deg_per_s = 90
turn_acceleration_deg_per_s2 = 360
)";

tl::expected<std::string, std::string> rx90_urdf(const std::filesystem::path& path) {
  if (path == "broken.urdf") return std::string("<robot name='broken'>");
  if (path != "rx90.urdf") return tl::unexpected(std::string("No such file or directory"));
  return rx90_files.urdf;
}

Parsed parse(const std::string& toml) { return parse_arm(toml, "arm.toml", rx90_urdf); }

/// The text of a good file in which the line that begins with `key` is replaced by `line`.
std::string good_but(const std::string& key, const std::string& line) {
  std::string text = good;
  const std::size_t from = text.find(key);
  EXPECT_NE(from, std::string::npos) << key;
  return text.replace(from, text.find('\n', from) - from, line);
}

TEST(ArmFile, AGoodFileIsAnArmInSiUnits) {
  const Parsed arm = parse(good);
  ASSERT_TRUE(arm) << to_string(arm.error());
  EXPECT_EQ(arm->name, "BENCH");
  EXPECT_EQ(arm->description, "arm of a test");
  EXPECT_EQ(arm->place, "it stands in a test");
  EXPECT_EQ(arm->model.axes(), 6);
  EXPECT_EQ(arm->model.limits()[0].acceleration, arm->model.limits()[0].speed / 0.5);
  ASSERT_TRUE(arm->model.front().has_value());
  EXPECT_EQ((*arm->model.front())[4], deg(-45));
  EXPECT_EQ(arm->start[5], deg(1.5));
  EXPECT_EQ(arm->tool_limits.speed, 0.5);
  EXPECT_EQ(arm->tool_limits.acceleration, 2);
  EXPECT_EQ(arm->tool_limits.turn_speed, deg(90));
  EXPECT_EQ(arm->tool_limits.turn_acceleration, deg(360));
  EXPECT_LT(distance(arm->tool_offset, robcl::translate(.010, .020, .030)), 1e-12);
  EXPECT_NEAR((arm->tool_offset * robcl::translate(0, 0, 1)).position().x(), 1.010, 1e-12);
}

TEST(ArmFile, EachJointMayHaveATimeOfItsOwnToFullSpeed) {
  const Parsed arm =
      parse(good_but("seconds_to", "seconds_to_full_speed = [0.1, 0.2, 0.3, 0.4, 0.5, 2]"));
  ASSERT_TRUE(arm) << to_string(arm.error());
  EXPECT_EQ(arm->model.limits()[1].acceleration, arm->model.limits()[1].speed / 0.2);
  EXPECT_EQ(arm->model.limits()[5].acceleration, arm->model.limits()[5].speed / 2);
}

TEST(ArmFile, TheLimitOfJerkMayBeLeftOut) {
  EXPECT_EQ(parse(good).value().seconds_to_full_acceleration, 0);
  const std::string limited =
      good_but("seconds_to", "seconds_to_full_speed = 0.5\nseconds_to_full_acceleration = 0.05");
  EXPECT_EQ(parse(limited).value().seconds_to_full_acceleration, 0.05);
}

TEST(ArmFile, FrontAndTheAnglesOfTheToolMayBeLeftOut) {
  EXPECT_FALSE(parse(good_but("front_deg", "")).value().model.front().has_value());
  const robcl::Frame offset = parse(good_but("offset_zyz_deg", "")).value().tool_offset;
  EXPECT_EQ(offset, robcl::translate(.010, .020, .030));
}

struct Bad {
  const char* key;   ///< the line of the good file that is replaced
  const char* line;  ///< by what
  const char* says;
};

// In the order of the lines of the file.
const std::vector<Bad> bad{
    {"name", "",
     "arm.toml:1: name: this key is missing; give the name under which clients find the arm, for "
     "example \"RX90\""},
    {"name", "name = 90",
     "arm.toml:1: name: a number does not fit here; give the name under which clients find the "
     "arm, for example \"RX90\""},
    {"name", "name = \"\"",
     "arm.toml:1: name: the text is empty; give the name under which clients find the arm, for "
     "example \"RX90\""},
    {"name", "name = \"A\\nB\"",
     "arm.toml:1: name: the text has a control character; give the name under which clients find "
     "the arm, for example \"RX90\""},
    {"place", "place = \"\\u007F\"",
     "arm.toml:9: place: the text has a control character; give a text that says where the arm "
     "stands, for example \"an RX90 stands on the floor\""},
    {"description", "description = [\"arm\"]",
     "arm.toml:2: description: a list does not fit here; give the name of the arm for people, for "
     "example \"Staeubli RX90\""},
    {"urdf", "urdf = \"rx91.urdf\"",
     "arm.toml:3: urdf: 'rx91.urdf' cannot be read (No such file or directory); give the path of "
     "the URDF file, relative to the folder of this file"},
    {"urdf", "urdf = \"broken.urdf\"",
     "arm.toml:3: urdf: 'broken.urdf': the text is not a URDF robot; the parser printed the reason "
     "above; correct that file, or base_link and flange_link in this file"},
    {"base_link", "base_link = \"base\"",
     "arm.toml:3: urdf: 'rx90.urdf': the URDF has no link 'base'; correct that file, or base_link "
     "and flange_link in this file"},
    {"flange_link", "flange_link = \"foot\"",
     "arm.toml:3: urdf: 'rx90.urdf': link 'foot' is not a descendant of link 'foot'; correct that "
     "file, or base_link and flange_link in this file"},
    {"flange_link", "flange = \"flange\"",
     "arm.toml:5: flange: this key is unknown; the keys here are name, description, urdf, "
     "base_link, flange_link, seconds_to_full_speed, seconds_to_full_acceleration, front_deg, "
     "start_deg, "
     "place, tool"},
    {"seconds_to_full_speed", "seconds_to_full_speed = 0",
     "arm.toml:6: seconds_to_full_speed: 0 is not above 0; give the time in s, above 0, in which a "
     "joint reaches its full speed: one for all, or a list with one for each joint"},
    {"seconds_to_full_speed", "seconds_to_full_speed = \"fast\"",
     "arm.toml:6: seconds_to_full_speed: a text does not fit here; give the time in s, above 0, in "
     "which a joint reaches its full speed: one for all, or a list with one for each joint"},
    {"seconds_to_full_speed", "seconds_to_full_speed = [0.25, 0.25]",
     "arm.toml:6: seconds_to_full_speed: the list has 2 values, but the arm has 6 joints (joint1, "
     "joint2, joint3, joint4, joint5, joint6); give the time in s, above 0, in which a joint "
     "reaches its full speed: one for all, or a list with one for each joint"},
    {"front_deg", "seconds_to_full_acceleration = 30",
     "arm.toml:7: seconds_to_full_acceleration: 30 is above 1; give the time in s, above 0 and at "
     "most 1, in which an acceleration rises to its limit"},
    {"front_deg", "front_deg = [0, -20, 110, 0, 0, 0]",
     "arm.toml:7: front_deg: rx90: 'front' is at a singularity of the arm; give joint positions "
     "with the elbow up, the wrist in front of the shoulder and the flange bent up"},
    {"front_deg", "front_deg = [0, -20, 110, 0, -145, 0]",
     "arm.toml:7: front_deg: joint 5 (joint5) is at -145 deg, outside its travel from -105 to 120 "
     "deg in the URDF file; give an angle inside it"},
    {"start_deg", "",
     "arm.toml:1: start_deg: this key is missing; give a list with an angle in degrees for each "
     "joint, at which the simulated arm starts"},
    {"start_deg", "start_deg = 90",
     "arm.toml:8: start_deg: a number does not fit here; give a list with an angle in degrees for "
     "each joint, at which the simulated arm starts"},
    {"start_deg", "start_deg = [0, -20, 110, 0, 90, true]",
     "arm.toml:8: start_deg: true or false does not fit here; give a list with an angle in degrees "
     "for each joint, at which the simulated arm starts"},
    {"start_deg", "start_deg = [0, -20, 110, 0, 90, nan]",
     "arm.toml:8: start_deg: a number is not finite; give a list with an angle in degrees for each "
     "joint, at which the simulated arm starts"},
    {"start_deg", "start_deg = [0, -20, 110, 0, 90]",
     "arm.toml:8: start_deg: the list has 5 values, but the arm has 6 joints (joint1, joint2, "
     "joint3, joint4, joint5, joint6); give a list with an angle in degrees for each joint, at "
     "which the simulated arm starts"},
    {"start_deg", "start_deg = [0, 200, 110, 0, 90, 0]",
     "arm.toml:8: start_deg: joint 2 (joint2) is at 200 deg, outside its travel from -137.5 to "
     "137.5 deg in the URDF file; give an angle inside it"},
    {"place", "place = 2026-11-27",
     "arm.toml:9: place: a date or time does not fit here; give a text that says where the arm "
     "stands, for example \"an RX90 stands on the floor\""},
    {"[tool]", "",
     "arm.toml:11: offset_mm: this key belongs to the table [tool]; write the line [tool] above "
     "the keys of the tool, at the end of this file"},
    {"[tool]", "[tools]",
     "arm.toml:10: tools: this key is unknown; the keys here are name, description, urdf, "
     "base_link, flange_link, seconds_to_full_speed, seconds_to_full_acceleration, front_deg, "
     "start_deg, "
     "place, tool"},
    {"offset_mm", "offset_mm = [0, 150]",
     "arm.toml:11: tool.offset_mm: the list has 2 values; give a list of x, y and z of the tool "
     "frame, seen from the flange, in mm"},
    {"offset_mm", "offset_mm = [0, -1e308, 0]",
     "arm.toml:11: tool.offset_mm: -1e+308 is beyond 1e6 mm; give a list of x, y and z of the tool "
     "frame, seen from the flange, in mm"},
    {"offset_mm", "offset = [0, 0, 0.15]",
     "arm.toml:11: tool.offset: this key is unknown; the keys here are tool.offset_mm, "
     "tool.offset_zyz_deg, tool.speed_m_per_s, tool.acceleration_m_per_s2, "
     "tool.turn_speed_deg_per_s, tool.turn_acceleration_deg_per_s2"},
    {"speed_m_per_s", "",
     "arm.toml:10: tool.speed_m_per_s: this key is missing; give the greatest speed of the tool in "
     "m/s, above 0"},
    {"speed_m_per_s", "speed_m_per_s = -1",
     "arm.toml:13: tool.speed_m_per_s: -1 is not above 0; give the greatest speed of the tool in "
     "m/s, above 0"},
    {"turn_speed_deg_per_s", "turn_speed_deg_per_s = inf",
     "arm.toml:15: tool.turn_speed_deg_per_s: a number is not finite; give the greatest speed in "
     "deg/s, above 0, with which the tool turns"},
};

TEST(ArmFile, ABadFileIsRefusedWithItsLineItsKeyAndWhatToDo) {
  for (const Bad& file : bad) {
    const Parsed arm = parse(good_but(file.key, file.line));
    ASSERT_FALSE(arm) << file.line;
    EXPECT_EQ(to_string(arm.error()), file.says);
  }
}

TEST(ArmFile, AFileWithoutATableForTheToolIsToldWhatIsMissingAndWhere) {
  const Parsed arm = parse(good.substr(0, good.find("[tool]")));
  ASSERT_FALSE(arm);
  EXPECT_EQ(to_string(arm.error()),
            "arm.toml:1: tool: this key is missing; give a table for the tool: add the line "
            "[tool] at the end of this file, and below it offset_mm, speed_m_per_s, "
            "acceleration_m_per_s2, turn_speed_deg_per_s and turn_acceleration_deg_per_s2");
}

TEST(ArmFile, WhatIsNotTomlIsRefusedWithItsLine) {
  const Parsed arm = parse(good_but("urdf", "urdf = rx90.urdf"));
  ASSERT_FALSE(arm);
  EXPECT_EQ(to_string(arm.error()).rfind("arm.toml:3: this is not TOML: ", 0), 0U)
      << to_string(arm.error());
}

TEST(ArmFile, AnArmWithoutASphericalWristHasNoFront) {
  const std::string urdf = R"(<robot name="hinge"><link name="foot"/><link name="flange"/>
    <joint name="hinge" type="revolute"><parent link="foot"/><child link="flange"/>
      <axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="0"/></joint></robot>)";
  std::string toml = good_but("front_deg", "front_deg = [0]");
  toml.replace(toml.find("start_deg = ["), 40, "start_deg = [0]#");
  const auto arm = parse_arm(toml, "arm.toml", [&](const std::filesystem::path&) {
    return tl::expected<std::string, std::string>(urdf);
  });
  ASSERT_FALSE(arm);
  EXPECT_EQ(to_string(arm.error()),
            "arm.toml:7: front_deg: this arm has no spherical wrist, so it has no configurations; "
            "leave this key out");
}

TEST(ArmFile, AFileThatIsNotThereIsRefusedWithItsPath) {
  const auto missing = read_arm("/nowhere/arm.toml");
  ASSERT_FALSE(missing);
  EXPECT_EQ(to_string(missing.error()),
            "/nowhere/arm.toml: the file cannot be read (No such file or directory); give the "
            "path of the TOML file of an arm");
  const auto folder = read_arm("/");
  ASSERT_FALSE(folder);
  EXPECT_EQ(to_string(folder.error()),
            "/: the file cannot be read (Is a directory); give the path of the TOML file of an "
            "arm");
  const auto endless = read_arm("/dev/zero");
  ASSERT_FALSE(endless);
  EXPECT_EQ(to_string(endless.error()),
            "/dev/zero: the file cannot be read (it is a pipe, a socket or a device, not a regular "
            "file); give the path of the TOML file of an arm");
}

class ArmOfTheTree : public ::testing::TestWithParam<const char*> {};

TEST_P(ArmOfTheTree, IsReadFromItsFolder) {
  const std::filesystem::path folder = ROBCL_SOURCE_DIR "/devices/arms";
  const auto arm = read_arm(folder / GetParam());
  ASSERT_TRUE(arm) << to_string(arm.error());
  EXPECT_EQ(arm->model.name() + ".toml", GetParam());
}

INSTANTIATE_TEST_SUITE_P(OfAll, ArmOfTheTree,
                         ::testing::Values("rx90.toml", "rx90l.toml", "puma560.toml",
                                           "iiwa14.toml"));

TEST(ArmsOfTheTree, TheRx90LReachesFurtherByItsForearm) {
  const std::filesystem::path folder = ROBCL_SOURCE_DIR "/devices/arms";
  EXPECT_NEAR(read_arm(folder / "rx90l.toml").value().model.reach(),
              parse_arm(rx90_files).value().model.reach() + 0.2, 1e-12);
}

}  // namespace
}  // namespace devices
