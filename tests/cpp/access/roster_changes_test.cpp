#include "gecos/access/roster_changes.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace gecos::access {
namespace {

using namespace std::chrono_literals;

constexpr SessionId first_client{1};
constexpr SessionId second_client{2};
constexpr std::uint64_t first_known = 5000;

class RosterChangesTest : public ::testing::Test {
 protected:
  void acquire(SessionId who, Status wanted = Status::Actor) {
    const Client client{who == first_client ? "ada" : "bob", "lab1", "grip_block", 4711};
    EXPECT_TRUE(table.acquire(who, client, wanted, plain_proof("two hands"), now));
    note();
  }
  void release(SessionId who, LeaseTable::Commands commands = LeaseTable::Commands::None) {
    table.release(who, table.epoch(), commands);
    note("released");
  }
  void note(std::string_view why_ended = {}) { changes.note(table.roster(), now, why_ended); }
  /// Returns the changes after `number`, each as `user kind`.
  std::vector<std::string> told(std::uint64_t number) {
    std::vector<std::string> lines;
    for (const RosterChange& change : changes.after(number)) {
      const char* const kinds[] = {"acquired", "releasing", "taken over", "given back", "ended"};
      lines.push_back(change.holder.client.user + " " +
                      kinds[static_cast<std::size_t>(change.kind)]);
    }
    return lines;
  }
  using Lines = std::vector<std::string>;

  TimePoint now{10s};
  LeaseTable table{IncarnationId{7}, 500ms};
  RosterChanges changes{first_known};
};

TEST_F(RosterChangesTest, TellsEachChangeOnceAndInOrder) {
  acquire(first_client);
  acquire(second_client);
  EXPECT_EQ(told(first_known), Lines({"ada acquired", "bob acquired"}));
  const std::uint64_t known = changes.newest();
  table.take_over(second_client, now);
  note();
  table.give_back(second_client);
  note();
  release(first_client);
  EXPECT_EQ(told(known), Lines({"bob taken over", "bob given back", "ada ended"}));
  EXPECT_EQ(told(changes.newest()), Lines());
}

TEST_F(RosterChangesTest, TellsAStatusThatBeganAndEndedBetweenTwoQuestions) {
  acquire(first_client);
  now += 2s;
  release(first_client);
  EXPECT_EQ(told(first_known), Lines({"ada acquired", "ada ended"}));
  const RosterChange end = changes.after(first_known).back();
  EXPECT_EQ(end.at - end.holder.since, 2s);
  EXPECT_EQ(end.why, "released");
}

TEST_F(RosterChangesTest, TellsThatAHolderIsReleasingAndThatItHasAcquiredAgain) {
  acquire(first_client);
  release(first_client, LeaseTable::Commands::Pending);
  acquire(first_client);
  release(first_client, LeaseTable::Commands::Pending);
  table.drained(first_client);
  note("released");
  EXPECT_EQ(told(first_known),
            Lines({"ada acquired", "ada releasing", "ada acquired", "ada releasing", "ada ended"}));
}

TEST_F(RosterChangesTest, TellsAHigherStatusAndIsSilentAboutASignOfLife) {
  acquire(first_client);
  acquire(first_client, Status::Master);
  now += 100ms;
  table.renew(first_client, now);
  note();
  EXPECT_EQ(told(first_known), Lines({"ada acquired", "ada acquired"}));
  EXPECT_EQ(changes.after(first_known).back().holder.status, Status::Master);
}

TEST_F(RosterChangesTest, TellsEveryHolderThatAStopEnds) {
  acquire(first_client);
  acquire(second_client);
  const std::uint64_t known = changes.newest();
  table.stop(SessionId{}, "eve broke it");
  note("eve broke it");
  EXPECT_EQ(told(known), Lines({"ada ended", "bob ended"}));
  for (const RosterChange& change : changes.after(known)) EXPECT_EQ(change.why, "eve broke it");
}

TEST_F(RosterChangesTest, TellsAllThatIsKeptToAClientOfAnotherServer) {
  acquire(first_client);
  for (const std::uint64_t other : {std::uint64_t{0}, first_known - 1, first_known + 2}) {
    EXPECT_EQ(told(other), Lines({"ada acquired"})) << other;
  }
}

TEST_F(RosterChangesTest, ShowsByItsNumbersHowManyChangesAReaderMissed) {
  for (std::size_t turn = 0; turn < RosterChanges::kept; ++turn) {
    acquire(first_client);
    release(first_client);
  }
  const auto left = changes.after(first_known + 1);
  ASSERT_EQ(left.size(), RosterChanges::kept);
  EXPECT_EQ(left.front().number, first_known + 1 + RosterChanges::kept);
  EXPECT_EQ(left.back().number, changes.newest());
}

}  // namespace
}  // namespace gecos::access
