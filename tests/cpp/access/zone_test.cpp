#include "gecos/access/zone.hpp"

#include <gtest/gtest.h>

namespace gecos::access {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint morning{1000s};

/// A zone with the button GRIP and the door DOOR, which has reported at `morning` that it is
/// closed.
struct Cell : Zone {
  Cell() : Zone("CELL", {{"GRIP"}, {"DOOR"}}, 0) { door("DOOR", true, morning); }
  bool present(TimePoint now) { return verdict(now).present; }
  bool check_in_anna(Duration stay, TimePoint now) {
    return show("K7P", now) == true && check_in("K7P", "anna", stay, now).has_value();
  }
};

TEST(Zone, ChecksInNobodyWhoseNameIsNoName) {
  Cell cell;
  ASSERT_TRUE(cell.show("K7P", morning));
  for (const char* const name : {"", " ", "anna\ngecos: RX90 is ready", "\x1b[2J"}) {
    EXPECT_FALSE(cell.check_in("K7P", name, 1min, morning)) << name;
  }
  EXPECT_TRUE(cell.check_in("K7P", "Ännchen", 1min, morning)) << "the code was not used up";
}

TEST(Zone, IsEmptyUntilAPersonIsKnownToBeThere) {
  Cell cell;
  EXPECT_EQ(
      cell.verdict(morning).why,
      "no person has checked in or holds a button; call show_code() of CELL, read the code in "
      "the laboratory, and call check_in(), or hold GRIP");
  EXPECT_TRUE(cell.button("GRIP", true, morning));
  EXPECT_EQ(cell.verdict(morning), (Zone::Verdict{true, 1, "GRIP is held"}));
}

TEST(Zone, AReportOfAButtonCountsForASecond) {
  Cell cell;
  cell.button("GRIP", true, morning);
  cell.door("DOOR", true, morning + 500ms);
  EXPECT_TRUE(cell.present(morning + 999ms));
  EXPECT_FALSE(cell.present(morning + 1s));
}

TEST(Zone, AnOpenOrSilentDoorIsAVeto) {
  Cell cell;
  ASSERT_TRUE(cell.check_in_anna(10min, morning));
  EXPECT_EQ(cell.verdict(morning).why, "anna has checked in");
  EXPECT_EQ(cell.verdict(morning + 1s).why, "DOOR is open or silent; close it");
  cell.door("DOOR", true, morning + 2s);
  EXPECT_TRUE(cell.present(morning + 2s));
  cell.door("DOOR", false, morning + 2100ms);
  EXPECT_FALSE(cell.present(morning + 2100ms));
}

TEST(Zone, ADoorThatOpensBetweenTwoVerdictsBeginsANewSpell) {
  Cell cell;
  ASSERT_TRUE(cell.check_in_anna(10min, morning));
  EXPECT_EQ(cell.verdict(morning).spell, 1u);
  cell.door("DOOR", false, morning + 10ms);
  cell.door("DOOR", true, morning + 20ms);
  EXPECT_EQ(cell.verdict(morning + 30ms).spell, 2u);
}

TEST(Zone, ASilenceBetweenTwoReportsBeginsANewSpellToo) {
  Cell cell;
  cell.button("GRIP", true, morning);
  cell.door("DOOR", true, morning + 900ms);
  cell.button("GRIP", true, morning + 1s);
  EXPECT_EQ(cell.verdict(morning + 1s).spell, 2u);
}

TEST(Zone, AStayEndsAfterThirtyMinutesAtTheLatest) {
  Cell cell;
  ASSERT_TRUE(cell.check_in_anna(5h, morning));
  cell.door("DOOR", true, morning + 30min - 1ms);
  EXPECT_TRUE(cell.present(morning + 30min - 1ms));
  EXPECT_FALSE(cell.present(morning + 30min));
}

TEST(Zone, ACodeIsGoodForOneCheckInWithinAMinute) {
  Cell cell;
  EXPECT_EQ(cell.check_in("", "anna", 1min, morning).error(),
            "no code is shown; call show_code() of CELL, and read the code in the laboratory");
  EXPECT_EQ(cell.show("K7P", morning), true);
  EXPECT_EQ(cell.show("R2D", morning + 59s), false) << "K7P is still good";
  EXPECT_FALSE(cell.check_in("K7P", "anna", 1min, morning + 60s));
  EXPECT_EQ(cell.show("R2D", morning + 60s), true);
  EXPECT_TRUE(cell.check_in("R2D", "anna", 1min, morning + 61s));
  EXPECT_FALSE(cell.check_in("R2D", "ben", 1min, morning + 61s));
}

TEST(Zone, AfterFiveWrongCodesNoneIsAcceptedForAMinute) {
  Cell cell;
  EXPECT_EQ(cell.show("K7P", morning), true);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(cell.check_in("wrong", "anna", 1min, morning));
  EXPECT_EQ(cell.check_in("K7P", "anna", 1min, morning + 20s).error(),
            "CELL accepts no code for 40 s, because too many codes were wrong");
  EXPECT_FALSE(cell.show("R2D", morning + 59s));
  EXPECT_EQ(cell.show("R2D", morning + 60s), true);
  EXPECT_TRUE(cell.check_in("R2D", "anna", 1min, morning + 60s));
}

TEST(Zone, WhoChecksOutIsGone) {
  Cell cell;
  ASSERT_TRUE(cell.check_in_anna(10min, morning));
  EXPECT_TRUE(cell.check_out("anna", morning));
  EXPECT_FALSE(cell.present(morning));
  EXPECT_FALSE(cell.check_out("anna", morning));
}

TEST(Zone, KnowsOnlyItsOwnSources) {
  Cell cell;
  EXPECT_FALSE(cell.button("DOOR", true, morning));
  EXPECT_FALSE(cell.door("GRIP", true, morning));
  EXPECT_FALSE(cell.button("HALL", true, morning));
}

}  // namespace
}  // namespace gecos::access
