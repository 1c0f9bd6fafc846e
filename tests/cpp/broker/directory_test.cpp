#include "gecos/broker/directory.hpp"

#include <gtest/gtest.h>

namespace gecos::broker {
namespace {

constexpr std::uint64_t ada = 1;
constexpr std::uint64_t bob = 2;

Entry named(const std::string& name) {
  Entry entry;
  entry.name = name;
  entry.interface_name = "robcl::Rx90";
  entry.user = "ada";
  entry.hostname = "lab1";
  entry.pid = 4711;
  entry.boot = 7;
  return entry;
}

TEST(Directory, FindsWhatWasEnlisted) {
  Directory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  EXPECT_EQ(directory.look_up("RX90")->pid, 4711);
  EXPECT_EQ(directory.list().size(), 1u);
}

TEST(Directory, NamesWhatItKnowsWhenAskedForSomethingElse) {
  Directory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  ASSERT_TRUE(directory.enlist(bob, 7, named("LASER")));
  const auto missing = directory.look_up("RX91");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().name, "RX91");
  EXPECT_EQ(missing.error().known, (std::vector<std::string>{"LASER", "RX90"}));
}

TEST(Directory, GivesANameToOneServerAtATime) {
  Directory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  Entry of_another = named("RX90");
  of_another.boot = 8;
  const auto taken = directory.enlist(bob, 8, of_another);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().by, "a robcl::Rx90 of ada on lab1, pid 4711");
  EXPECT_TRUE(directory.enlist(ada, 7, named("RX90"))) << "its own session may say it again";
}

TEST(Directory, AServerThatLostItsSessionTakesItsNameIntoTheNextOne) {
  Directory directory;
  const std::uint64_t lost = 1;
  const std::uint64_t next = 2;
  ASSERT_TRUE(directory.enlist(lost, 7, named("RX90")));
  ASSERT_TRUE(directory.enlist(next, 7, named("RX90")));
  EXPECT_TRUE(directory.end_session(lost).empty()) << "noticed late, and it has nothing any more";
  EXPECT_FALSE(directory.withdraw(lost, "RX90"));
  EXPECT_TRUE(directory.look_up("RX90"));
  EXPECT_TRUE(directory.withdraw(next, "RX90"));
}

TEST(Directory, NobodyTakesAServersNameByRepeatingWhatItSaid) {
  Directory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  EXPECT_FALSE(directory.enlist(bob, 8, *directory.look_up("RX90")));
  EXPECT_TRUE(directory.end_session(bob).empty());
}

TEST(Directory, RefusesASecondObjectOfTheSameSessionUnderOneName) {
  Directory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  Entry second = named("RX90");
  second.addresses = {"shm:/run/gecos/other.sock"};
  EXPECT_FALSE(directory.enlist(ada, 7, second));
  EXPECT_TRUE(directory.look_up("RX90")->addresses.empty()) << "the first one stays";
}

TEST(Directory, LetsOnlyWhoEnlistedItWithdrawIt) {
  Directory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  EXPECT_FALSE(directory.withdraw(bob, "RX90"));
  EXPECT_TRUE(directory.withdraw(ada, "RX90"));
  EXPECT_FALSE(directory.look_up("RX90"));
}

TEST(Directory, DropsWhatASessionEnlistedWhenItEnds) {
  Directory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  ASSERT_TRUE(directory.enlist(ada, 7, named("GRIPPER")));
  ASSERT_TRUE(directory.enlist(bob, 7, named("LASER")));
  EXPECT_EQ(directory.end_session(ada), (std::vector<std::string>{"GRIPPER", "RX90"}));
  EXPECT_TRUE(directory.look_up("LASER"));
  EXPECT_TRUE(directory.enlist(bob, 7, named("RX90")));
}

}  // namespace
}  // namespace gecos::broker
