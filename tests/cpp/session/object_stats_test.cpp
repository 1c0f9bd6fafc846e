// What an object tells of the calls and samples that it has counted.
#include <algorithm>
#include <map>

#include "object_host_bench.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;

using OutcomesSeen = std::map<Detail, std::uint64_t>;

OutcomesSeen outcomes_in(const std::vector<gecos::OutcomeCount>& counted) {
  OutcomesSeen all;
  for (const auto& [detail, calls] : counted) all[gecos::detail_from(detail).value()] = calls;
  return all;
}

gecos::OperationStats counts_of(const gecos::ObjectStats& stats, std::string_view operation) {
  const auto found =
      std::ranges::find(stats.operations, operation, &gecos::OperationStats::operation);
  return found == stats.operations.end() ? gecos::OperationStats{} : *found;
}

class CountsOfAnObject : public probe::OverMedia {};
PROBE_OVER_MEDIA(CountsOfAnObject);

TEST_P(CountsOfAnObject, AreThoseOfItsCallsBySessionAndOperation) {
  const auto robot = connect(lab_);
  const auto other = connect(second_lab_);
  for (int each = 0; each < 40; ++each) ASSERT_TRUE(robot.read().get());
  for (int each = 0; each < 2; ++each) ASSERT_TRUE(other.read().get());
  EXPECT_EQ(other.set(1).get().error().detail, Detail::Denied);
  {
    const auto lease = gecos::actor(robot);
    ASSERT_TRUE(lease) << lease.error();
    ASSERT_TRUE(robot.set(2).get());
    auto move = robot.move(1);
    servant_.await_moves(1);
    move.cancel();
    EXPECT_EQ(move.get().error().detail, Detail::Canceled);
  }
  servant_.await_event("interrupted 1");

  const auto told = gecos::stats(other).get();
  ASSERT_TRUE(told) << told.error();
  EXPECT_GT(told->served_for, 0);
  EXPECT_EQ(counts_of(*told, "read").begun, 42u);
  EXPECT_EQ(outcomes_in(counts_of(*told, "read").ended), (OutcomesSeen{{Detail::Done, 42}}));
  EXPECT_GT(counts_of(*told, "read").median, 0);
  EXPECT_GE(counts_of(*told, "read").worst, counts_of(*told, "read").percentile_99);
  EXPECT_EQ(counts_of(*told, "set").begun, 1u);
  EXPECT_EQ(outcomes_in(counts_of(*told, "set").ended),
            (OutcomesSeen{{Detail::Done, 1}, {Detail::Denied, 1}}));
  EXPECT_EQ(outcomes_in(counts_of(*told, "move").ended), (OutcomesSeen{{Detail::Canceled, 1}}));
  EXPECT_EQ(told->operations.size(), 3u) << "the others were not called";

  ASSERT_EQ(told->sessions.size(), 2u);
  EXPECT_EQ(told->sessions[0].pid, getpid());
  EXPECT_EQ(told->sessions[0].medium, to_string(GetParam()));
  EXPECT_EQ(told->sessions[0].begun, 42u) << "the oldest session comes first";
  EXPECT_EQ(outcomes_in(told->sessions[0].ended),
            (OutcomesSeen{{Detail::Done, 41}, {Detail::Canceled, 1}}));
  EXPECT_EQ(told->sessions[1].begun, 2u);
  EXPECT_EQ(outcomes_in(told->sessions[1].ended),
            (OutcomesSeen{{Detail::Done, 2}, {Detail::Denied, 1}}));
}

TEST_P(CountsOfAnObject, AreThoseOfItsSamplesAndTheirReaders) {
  const auto robot = connect(lab_);
  servant_.publish(1);
  auto level = robot.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  for (int each = 2; each <= 3; ++each) servant_.publish(each);
  const auto read = gecos::stats(robot).get();
  ASSERT_TRUE(read) << read.error();
  ASSERT_EQ(read->streams.size(), 1u);
  EXPECT_EQ(read->streams[0].stream, "level");
  EXPECT_EQ(read->streams[0].samples, 3u);
  EXPECT_EQ(read->streams[0].bytes, 12u);
  EXPECT_EQ(read->streams[0].dropped, 0u);
  EXPECT_EQ(read->streams[0].readers, 1u);
}

TEST_P(CountsOfAnObject, KeepTheCallsOfClientsThatHaveLeft) {
  const auto robot = connect(lab_);
  {
    gecos::Lab brief(probe::patient());
    ASSERT_TRUE(connect(brief).read().get());
  }
  ASSERT_TRUE(settles([&] { return gecos::stats(robot).get().value().sessions.size() == 1; }));
  EXPECT_EQ(counts_of(gecos::stats(robot).get().value(), "read").begun, 1u);
}

}  // namespace

namespace gecos::session {
namespace {

class StatsOf : public ServedObjects {
 protected:
  ObjectStats stats() {
    call(1000 + ++asked_, GecosObjectInterface::stats.code);
    const auto packet = wire::decode_packet(connection_->sent.back());
    auto result = layout::from_bytes<GecosObject_stats_result>(packet->body);
    EXPECT_TRUE(result);
    return result ? result->result : ObjectStats{};
  }
  void tick() { object_->on_tick(clock_.now()); }

 private:
  std::uint64_t asked_ = 0;
};

TEST_F(StatsOf, CallsThatMissTheirDeadlineNameTheDeadline) {
  servant_.keep = true;
  auto header = header_of(wire::PacketKind::Call, 1, probe::read_code);
  header.deadline = 1s;
  take(header);
  clock_.suspend(2s);
  tick();
  ASSERT_EQ(reply_to(1), Detail::TimedOut);
  const ObjectStats told = stats();
  EXPECT_EQ(counts_of(told, "read").deadline_missed, 1u);
  EXPECT_EQ(counts_of(told, "read").start_by_missed, 0u);
  EXPECT_EQ(told.sessions.at(0).deadline_missed, 1u);
  EXPECT_EQ(outcomes_in(counts_of(told, "read").ended), (OutcomesSeen{{Detail::TimedOut, 1}}));
}

TEST_F(StatsOf, CallsThatMissTheirStartNameTheStart) {
  servant_.queues = servant_.keep = true;
  call(1, probe::prompt_code);
  clock_.suspend(2h);
  tick();
  ASSERT_EQ(reply_to(1), Detail::Expired);
  const ObjectStats told = stats();
  EXPECT_EQ(counts_of(told, "prompt").begun, 0u);
  EXPECT_EQ(counts_of(told, "prompt").start_by_missed, 1u);
  EXPECT_EQ(counts_of(told, "prompt").deadline_missed, 0u);
  EXPECT_EQ(told.sessions.at(0).start_by_missed, 1u);
}

TEST_F(StatsOf, AHandlerThatRunsDuringATickIsTimedAlthoughOthersLikeItAreNot) {
  for (std::uint64_t each = 1; each <= 17; ++each) call(each, probe::read_code);
  ASSERT_EQ(timed_weight(17), 0u);
  servant_.keep = true;
  call(18, probe::read_code);
  tick();
  clock_.suspend(3s);
  servant_.kept.at(0).finish({});
  EXPECT_GE(counts_of(stats(), "read").worst, 3.0);
  EXPECT_LT(counts_of(stats(), "read").median, 3.0);
}

TEST_F(StatsOf, CallsOfUnknownOperationsAreCountedForTheirSessionAlone) {
  call(1, probe::missing_code);
  ASSERT_EQ(reply_to(1), Detail::UnknownOperation);
  const ObjectStats told = stats();
  EXPECT_EQ(outcomes_in(told.sessions.at(0).ended), (OutcomesSeen{{Detail::UnknownOperation, 1}}));
  EXPECT_TRUE(told.operations.empty());
}

}  // namespace
}  // namespace gecos::session
