#include "gecos/access/roster_history.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace gecos::access {
namespace {

using namespace std::chrono_literals;

constexpr SessionId first_client{1};
constexpr SessionId second_client{2};
constexpr std::uint64_t history_start = 5000;

class RosterHistoryTest : public ::testing::Test {
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
  void note(std::string_view why_ended = {}) { history.note(table.roster(), now, why_ended); }
  /// Returns the changes after `number`, each as `user kind`.
  std::vector<std::string> told(std::uint64_t number) {
    std::vector<std::string> lines;
    for (const RosterChange& change : history.after(number)) {
      const char* const kinds[] = {"acquired", "releasing", "taken over", "given back", "ended"};
      lines.push_back(change.holder.client.user + " " +
                      kinds[static_cast<std::size_t>(change.kind)]);
    }
    return lines;
  }
  using Lines = std::vector<std::string>;

  TimePoint now{10s};
  LeaseTable table{IncarnationId{7}, 500ms};
  RosterHistory history{history_start};
};

TEST_F(RosterHistoryTest, TellsEachChangeOnceAndInOrder) {
  acquire(first_client);
  acquire(second_client);
  EXPECT_EQ(told(history_start), Lines({"ada acquired", "bob acquired"}));
  const std::uint64_t known = history.newest();
  table.take_over(second_client, now);
  note();
  table.give_back(second_client);
  note();
  release(first_client);
  EXPECT_EQ(told(known), Lines({"bob taken over", "bob given back", "ada ended"}));
  EXPECT_EQ(told(history.newest()), Lines());
}

TEST_F(RosterHistoryTest, TellsAStatusThatBeganAndEndedBetweenTwoQuestions) {
  acquire(first_client);
  now += 2s;
  release(first_client);
  EXPECT_EQ(told(history_start), Lines({"ada acquired", "ada ended"}));
  const RosterChange end = history.after(history_start).back();
  EXPECT_EQ(end.at - end.holder.since, 2s);
  EXPECT_EQ(end.why, "released");
}

TEST_F(RosterHistoryTest, TellsThatAHolderIsReleasingAndThatItHasAcquiredAgain) {
  acquire(first_client);
  release(first_client, LeaseTable::Commands::Pending);
  acquire(first_client);
  release(first_client, LeaseTable::Commands::Pending);
  table.drained(first_client);
  note("released");
  EXPECT_EQ(told(history_start),
            Lines({"ada acquired", "ada releasing", "ada acquired", "ada releasing", "ada ended"}));
}

TEST_F(RosterHistoryTest, TellsAHigherStatusAndIsSilentAboutASignOfLife) {
  acquire(first_client);
  acquire(first_client, Status::Master);
  now += 100ms;
  table.renew(first_client, now);
  note();
  EXPECT_EQ(told(history_start), Lines({"ada acquired", "ada acquired"}));
  EXPECT_EQ(history.after(history_start).back().holder.status, Status::Master);
}

TEST_F(RosterHistoryTest, TellsEveryHolderThatAStopEnds) {
  acquire(first_client);
  acquire(second_client);
  const std::uint64_t known = history.newest();
  table.stop(SessionId{}, "eve broke it");
  note("eve broke it");
  EXPECT_EQ(told(known), Lines({"ada ended", "bob ended"}));
  for (const RosterChange& change : history.after(known)) EXPECT_EQ(change.why, "eve broke it");
}

TEST_F(RosterHistoryTest, TellsAllThatIsKeptToAClientOfAnotherServer) {
  acquire(first_client);
  for (const std::uint64_t other : {std::uint64_t{0}, history_start - 1, history_start + 2}) {
    EXPECT_EQ(told(other), Lines({"ada acquired"})) << other;
  }
}

TEST_F(RosterHistoryTest, ShowsByItsNumbersHowManyChangesAReaderMissed) {
  for (std::size_t turn = 0; turn < RosterHistory::kept; ++turn) {
    acquire(first_client);
    release(first_client);
  }
  const auto changes = history.after(history_start + 1);
  ASSERT_EQ(changes.size(), RosterHistory::kept);
  EXPECT_EQ(changes.front().number, history_start + 1 + RosterHistory::kept);
  EXPECT_EQ(changes.back().number, history.newest());
}

}  // namespace
}  // namespace gecos::access
