// What a watcher is told of the answers of one broker and of its successor.
#include "gecos/session/client/list_view.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr TimePoint begin{std::chrono::hours(1)};

Registration online(const std::string& name, std::uint64_t boot = 7) {
  Registration one;
  one.entry.name = name;
  one.entry.boot = boot;
  one.entry.interface_name = "robcl::Rx90";
  one.entry.bases = {"robcl::Manipulator"};
  return one;
}

Registration with(Presence presence, Registration one) {
  one.presence = presence;
  return one;
}

std::vector<std::string> told(const std::vector<Registration>& news) {
  std::vector<std::string> texts;
  for (const Registration& one : news)
    texts.push_back(one.entry.name + " " + std::string(to_string(one.presence)));
  return texts;
}
using Told = std::vector<std::string>;

/// A view that knows ARM, GRIPPER and LASER of the broker with the life 1.
class Watcher : public ::testing::Test {
 protected:
  Watcher() {
    take({{1, 3}, true, 60, {online("ARM"), online("GRIPPER"), online("LASER")}}, begin);
  }
  Told take(const ListChanges& answer, TimePoint now) { return told(view_.take(answer, now)); }
  ListView view_;
};

TEST_F(Watcher, IsToldOfEachChangeInItsOrder) {
  const ListChanges answer{{1, 6},
                           false,
                           61,
                           {with(Presence::SILENT, online("ARM")), online("ARM"),
                            with(Presence::GONE, online("LASER"))}};
  EXPECT_EQ(take(answer, begin), (Told{"ARM SILENT", "ARM ONLINE", "LASER GONE"}));
  EXPECT_EQ(view_.revision(), (ListRevision{1, 6}));
  EXPECT_TRUE(take({{1, 6}, false, 62, {}}, begin).empty());
  EXPECT_EQ(view_.skipped(), 0u);
}

TEST_F(Watcher, ThatIsTooFarBehindIsToldTheResultAndHowManyChangesItSkipped) {
  EXPECT_EQ(take({{1, 2003}, true, 99, {online("ARM"), online("GRIPPER", 8)}}, begin),
            (Told{"GRIPPER ONLINE", "LASER GONE"}));
  EXPECT_EQ(view_.skipped(), 2000u);
}

TEST_F(Watcher, IsToldNothingWhenItsBrokerIsRestartedAndEveryServerReturns) {
  EXPECT_TRUE(take({{2, 0}, true, 0.1, {}}, begin).empty());
  EXPECT_TRUE(take({{2, 1}, false, 0.4, {online("ARM")}}, begin).empty());
  EXPECT_TRUE(take({{2, 3}, false, 0.8, {online("LASER"), online("GRIPPER")}}, begin).empty());
  EXPECT_TRUE(view_.missing(begin + seconds(9)).empty());
  EXPECT_EQ(view_.next_check(), std::nullopt);
}

TEST_F(Watcher, IsToldWhichServersDoNotReturnToTheNextBroker) {
  EXPECT_TRUE(take({{2, 1}, true, 0.5, {online("ARM")}}, begin).empty());
  EXPECT_EQ(view_.next_check(), begin + seconds(2));
  EXPECT_TRUE(view_.missing(begin + milliseconds(1999)).empty());
  EXPECT_EQ(told(view_.missing(begin + seconds(2))), (Told{"GRIPPER GONE", "LASER GONE"}));
  EXPECT_TRUE(view_.missing(begin + seconds(3)).empty());
}

TEST_F(Watcher, IsToldAtOnceWhenTheNextBrokerHasRunForLong) {
  EXPECT_EQ(take({{2, 9}, true, 2.5, {online("ARM"), online("LAMP")}}, begin),
            (Told{"LAMP ONLINE", "GRIPPER GONE", "LASER GONE"}));
}

TEST_F(Watcher, IsToldWhenANameReturnsWithAnotherServer) {
  EXPECT_EQ(take({{2, 1}, true, 0.1, {online("ARM", 8)}}, begin), (Told{"ARM ONLINE"}));
}

TEST_F(Watcher, WaitsForServersAnewWhenTheNextBrokerIsRestartedToo) {
  EXPECT_TRUE(take({{2, 0}, true, 0.1, {}}, begin).empty());
  EXPECT_TRUE(take({{3, 0}, true, 0.1, {}}, begin + seconds(2)).empty());
  EXPECT_EQ(view_.next_check(), begin + milliseconds(4400));
}

TEST(WatcherOfAnInterface, IsToldOfItsObjectsOnly) {
  ListView view("robcl::Manipulator");
  Registration lamp = online("LAMP");
  lamp.entry.interface_name = "robcl::Device";
  lamp.entry.bases.clear();
  EXPECT_EQ(told(view.take({{1, 2}, true, 9, {online("ARM"), lamp}}, begin)), Told{"ARM ONLINE"});
  EXPECT_TRUE(view.take({{1, 3}, false, 9, {with(Presence::GONE, lamp)}}, begin).empty());
  Registration other = lamp;
  other.entry.name = "ARM";
  EXPECT_EQ(told(view.take({{1, 5}, false, 9, {other}}, begin)), Told{"ARM GONE"});
}

}  // namespace
}  // namespace gecos::session
