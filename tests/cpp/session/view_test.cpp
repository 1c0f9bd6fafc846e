// What a visitor sees of the broker's list, and what a watcher makes of it.
#include "gecos/broker/view.hpp"

#include <gtest/gtest.h>

#include "gecos/session/client/list_view.hpp"

namespace gecos::broker {
namespace {

constexpr TimePoint now{std::chrono::hours(2)};
const access::UserAtHost anna{"anna", "cell"};

class AVisitor : public ::testing::Test {
 protected:
  static Entry named(const std::string& name, std::uint64_t boot) {
    Entry entry;
    entry.name = name;
    entry.interface_name = "robcl::Rx90";
    entry.boot = boot;
    return entry;
  }
  /// Each server has a session of its own, with the number of its life.
  void enlist(const std::string& name, std::uint64_t boot, std::vector<std::string> users) {
    ASSERT_TRUE(directory_.enlist({boot, boot, Duration::zero()}, named(name, boot), now));
    admit(name, boot, std::move(users));
  }
  void admit(const std::string& name, std::uint64_t boot, std::vector<std::string> users) {
    book_.set(name, {{{"gecos", "cell"}, boot, true}, ++number_, {std::move(users), {}, ""}},
              directory_.revision().number);
  }
  View view() const { return View(directory_, book_, anna); }
  View of_everything() const { return View(directory_, book_, std::nullopt); }
  /// What the watcher is told next, as "+RX90 -LASER ".
  std::string news() {
    const ListChanges answer = view().changes(watcher_.revision(), now);
    std::string text;
    for (const Registration& one : watcher_.take(answer, now)) {
      const bool gone = one.presence == Presence::GONE;
      const bool silent = one.presence == Presence::SILENT;
      text += (gone ? "-" : silent ? "?" : "+") + one.entry.name + " ";
    }
    return text;
  }

  Directory directory_{now - std::chrono::seconds(60),
                       {std::chrono::seconds(1), std::chrono::seconds(10), 0x1234}};
  access::VisitorBook book_;
  session::ListView watcher_;
  std::uint64_t number_ = 0;
};

TEST_F(AVisitor, SeesWhatAdmitsTheUserAndOthersSeeEverything) {
  enlist("RX90", 1, {"anna"});
  enlist("LASER", 2, {});
  EXPECT_EQ(view().list().size(), 1u);
  EXPECT_EQ(view().query("robcl::Rx90").size(), 1u);
  EXPECT_TRUE(view().look_up("RX90"));
  const auto hidden = view().look_up("LASER");
  ASSERT_FALSE(hidden);
  EXPECT_EQ(hidden.error().known, std::vector<std::string>{"RX90"});
  EXPECT_EQ(view().look_up("NOBODY").error().known, hidden.error().known);
  EXPECT_EQ(of_everything().list().size(), 2u);
  EXPECT_EQ(of_everything().revision(), directory_.revision());
  EXPECT_TRUE(of_everything().look_up("LASER"));
  EXPECT_EQ(of_everything().changes({}, now).changed.size(), 2u);
}

TEST_F(AVisitor, IsToldOfItsOwnChangesAlone) {
  enlist("RX90", 1, {"anna"});
  EXPECT_EQ(news(), "+RX90 ");
  enlist("LASER", 2, {});
  EXPECT_EQ(news(), "");
  ASSERT_TRUE(directory_.withdraw(2, "LASER"));
  EXPECT_EQ(news(), "");
  directory_.end_session(1, now);
  EXPECT_EQ(news(), "?RX90 ");
  EXPECT_EQ(view().silent(now).size(), 1u);
  EXPECT_FALSE(view().changes(watcher_.revision(), now).whole) << "it is not told everything again";
}

TEST_F(AVisitor, IsToldThatAnObjectIsHiddenOrShownAlthoughNothingElseChanged) {
  enlist("RX90", 1, {"anna"});
  enlist("LASER", 2, {"anna"});
  EXPECT_EQ(news(), "+LASER +RX90 ");
  const auto before = directory_.revision();
  admit("LASER", 2, {});
  EXPECT_EQ(news(), "-LASER ");
  admit("LASER", 2, {"anna"});
  EXPECT_EQ(news(), "+LASER ");
  EXPECT_EQ(directory_.revision(), before);
}

TEST_F(AVisitor, IsNotToldWhatHappenedWhileTheObjectWasHidden) {
  enlist("RX90", 1, {"anna"});
  EXPECT_EQ(news(), "+RX90 ");
  ASSERT_TRUE(directory_.withdraw(1, "RX90"));
  enlist("RX90", 2, {});
  ASSERT_TRUE(directory_.withdraw(2, "RX90"));
  enlist("RX90", 3, {"anna"});
  const auto answer = view().changes(watcher_.revision(), now);
  ASSERT_EQ(answer.changed.size(), 1u);
  EXPECT_EQ(answer.changed[0].entry.boot, 3u);
}

TEST_F(AVisitor, WhoInventsARevisionIsToldNothingFromBeforeTheListsNamedTheUser) {
  enlist("RX90", 1, {});
  ASSERT_TRUE(directory_.withdraw(1, "RX90"));
  enlist("LASER", 2, {"anna"});
  enlist("RX90", 3, {"anna"});
  const ListRevision seen = view().revision();
  for (std::uint64_t invented = 0; invented < seen.number; ++invented) {
    const ListChanges answer = view().changes({seen.life, invented}, now);
    EXPECT_TRUE(answer.whole) << invented;
    for (const auto& one : answer.changed) EXPECT_NE(one.entry.boot, 1u) << invented;
  }
  EXPECT_TRUE(view().changes(seen, now).changed.empty());
  EXPECT_TRUE(view().changes({seen.life, seen.number + 1}, now).whole);
}

TEST_F(AVisitor, WhoKnewTheWholeListGetsItsOwnOne) {
  enlist("RX90", 1, {"anna"});
  enlist("LASER", 2, {});
  watcher_.take(of_everything().changes({}, now), now);
  EXPECT_EQ(news(), "-LASER ");
}

}  // namespace
}  // namespace gecos::broker
