#include "gecos/access/object_presence.hpp"

#include <gtest/gtest.h>

namespace gecos::access {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint noon{1000s};

/// The presence of an object in the zone CELL, which has reported at `noon` that anna is there.
struct InCell : ObjectPresence {
  InCell() : ObjectPresence("CELL") { report(true, 1, noon); }
  bool report(bool present, std::uint64_t spell, TimePoint now) {
    return take({present, spell, present ? "anna has checked in" : "DOOR is open; close it"}, now,
                now);
  }
};

TEST(ObjectPresence, IsNotRequiredOfAnObjectInNoZone) {
  const ObjectPresence nowhere("");
  EXPECT_FALSE(nowhere.required());
  EXPECT_TRUE(nowhere.present(noon));
}

TEST(ObjectPresence, IsAbsentBeforeTheFirstReport) {
  const ObjectPresence unheard("CELL");
  EXPECT_FALSE(unheard.present(noon));
  EXPECT_EQ(unheard.text(noon),
            "nobody is known to be present in zone CELL: the zone has not reported yet; wait a "
            "moment, or start its server");
}

TEST(ObjectPresence, LastsASecondAfterAReport) {
  InCell object;
  EXPECT_TRUE(object.present(noon + 999ms));
  EXPECT_FALSE(object.on_tick(noon + 999ms));
  EXPECT_EQ(object.text(noon), "a person is present in zone CELL: anna has checked in");
  EXPECT_FALSE(object.present(noon + 1s));
  EXPECT_TRUE(object.on_tick(noon + 1s)) << "the loss is announced";
  EXPECT_FALSE(object.on_tick(noon + 1s)) << "and once";
  EXPECT_EQ(object.text(noon + 1s),
            "nobody is known to be present in zone CELL: the zone has been silent for 1 s; check "
            "that its server runs");
}

TEST(ObjectPresence, EndsWithAReportThatSaysSo) {
  InCell object;
  EXPECT_TRUE(object.report(false, 1, noon + 100ms));
  EXPECT_FALSE(object.present(noon + 100ms));
  EXPECT_EQ(object.text(noon + 100ms),
            "nobody is known to be present in zone CELL: DOOR is open; close it");
}

TEST(ObjectPresence, CountsAgainOnlyASecondAfterALoss) {
  InCell object;
  EXPECT_TRUE(object.report(false, 1, noon));
  EXPECT_FALSE(object.report(true, 2, noon + 999ms));
  EXPECT_FALSE(object.present(noon + 999ms));
  EXPECT_EQ(object.text(noon + 999ms),
            "a person is present again in zone CELL, but presence counts only 1 s after it was "
            "lost; wait and command again");
  EXPECT_FALSE(object.report(true, 2, noon + 1s));
  EXPECT_TRUE(object.present(noon + 1s));
}

TEST(ObjectPresence, ThatIsLostAgainBeforeItCountsWaitsAnewForASecond) {
  for (const bool blinks : {false, true}) {
    InCell object;
    EXPECT_TRUE(object.report(false, 1, noon));
    EXPECT_FALSE(object.report(true, 2, noon + 500ms));
    if (!blinks) {
      EXPECT_FALSE(object.report(false, 2, noon + 900ms)) << "no command can run";
    }
    // A command that was issued at 700 ms may still be on its way.
    EXPECT_FALSE(object.report(true, 3, noon + 900ms));
    object.report(true, 3, noon + 1400ms);
    EXPECT_FALSE(object.present(noon + 1400ms));
    object.report(true, 3, noon + 1900ms);
    EXPECT_TRUE(object.present(noon + 1900ms));
  }
}

TEST(ObjectPresence, ThatFallsSilentBeforeItCountsWaitsAnewForASecond) {
  InCell object;
  EXPECT_TRUE(object.report(false, 1, noon));
  EXPECT_FALSE(object.report(true, 2, noon + 100ms));
  EXPECT_FALSE(object.report(true, 2, noon + 1100ms));
  EXPECT_FALSE(object.present(noon + 1100ms));
}

TEST(ObjectPresence, AReportFromTheFutureCountsForASecondFromItsReceipt) {
  InCell object;
  object.take({true, 1, "anna has checked in"}, noon + 24h, noon);
  EXPECT_TRUE(object.present(noon + 999ms));
  EXPECT_FALSE(object.present(noon + 1s));
}

TEST(ObjectPresence, ALossThatNoReportShowedIsFoundByTheSpell) {
  InCell object;
  EXPECT_TRUE(object.report(true, 2, noon + 100ms));
  EXPECT_FALSE(object.present(noon + 100ms));
}

TEST(ObjectPresence, AReportThatComesLateDoesNotCount) {
  InCell object;
  EXPECT_TRUE(object.take({true, 1, "anna has checked in"}, noon - 2s, noon + 100ms));
  EXPECT_FALSE(object.present(noon + 100ms));
}

TEST(ObjectPresence, OfAnotherZoneIsNotKnown) {
  InCell object;
  EXPECT_TRUE(object.enter("HALL", noon));
  EXPECT_FALSE(object.present(noon));
  EXPECT_FALSE(object.report(true, 1, noon + 999ms));
  EXPECT_FALSE(object.present(noon + 999ms)) << "a command may still be on its way";
  EXPECT_FALSE(object.report(true, 1, noon + 1s));
  EXPECT_TRUE(object.present(noon + 1s));
}

TEST(ObjectPresence, IsLostByAnObjectThatEntersAZone) {
  ObjectPresence object("");
  EXPECT_TRUE(object.enter("CELL", noon)) << "its commands began without a person";
  EXPECT_TRUE(object.required());
  EXPECT_FALSE(object.present(noon));
}

TEST(ObjectPresence, IsForgottenWhenTheObjectHearsNoMore) {
  InCell object;
  EXPECT_TRUE(object.forget("the session with its server ended", noon));
  EXPECT_FALSE(object.present(noon));
}

}  // namespace
}  // namespace gecos::access
