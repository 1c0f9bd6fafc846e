#include "gecos/session/server/call_state.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace gecos::session {
namespace {

using Event = CallState::Event;
using Phase = CallState::Phase;
using State = CallState::State;
using Reported = CallState::Reported;

constexpr std::array events{Event::Take,   Event::Begin,  Event::Cancel, Event::End,
                            Event::Answer, Event::Return, Event::Drop};
constexpr std::array event_names{"Take", "Begin", "Cancel", "End", "Answer", "Return", "Drop"};

/// "T-" is Taken with its thread inside and a caller who knows nothing; "R+c" is Running, its
/// thread has returned, and the caller reads CANCELING; "!" is a caller who knows the outcome.
std::string name(const State& state) {
  static constexpr std::array phases{"Q", "T", "R", "A", "F"};
  std::string text = phases.at(static_cast<std::size_t>(state.phase));
  if (state.phase == Phase::Taken || state.phase == Phase::Running) {
    text += state.returned ? "+" : "-";
  }
  if (state.reported == Reported::Canceling) text += "c";
  if (state.reported == Reported::Outcome) text += "!";
  return text;
}

std::string name(const std::optional<State>& state) { return state ? name(*state) : ""; }

/// All states that a call can come to.
std::vector<State> reachable() {
  std::vector<State> found{State{}};
  for (std::size_t at = 0; at < found.size(); ++at) {
    for (const Event event : events) {
      const auto next = CallState::after(found[at], event);
      if (next && std::ranges::find(found, *next) == found.end()) found.push_back(*next);
    }
  }
  return found;
}

struct Row {
  std::string from;
  std::array<std::string, events.size()> to;  ///< by event; empty: it cannot happen
};

// Take, Begin, Cancel, End, Answer, Return, Drop
const std::vector<Row> transitions{
    {"Q", {"T-", "", "", "F!", "", "", ""}},
    {"T-", {"", "R-", "T-c", "T-!", "A!", "T+", ""}},
    {"T-c", {"", "R-c", "", "T-!", "A!", "T+c", ""}},
    {"T-!", {"", "", "", "", "A!", "T+!", "F!"}},
    {"T+", {"", "R+", "T+c", "T+!", "F!", "", ""}},
    {"T+c", {"", "R+c", "", "T+!", "F!", "", ""}},
    {"T+!", {"", "", "", "", "F!", "", ""}},
    {"R-", {"", "", "R-c", "R-!", "A!", "R+", ""}},
    {"R-c", {"", "", "", "R-!", "A!", "R+c", ""}},
    {"R-!", {"", "", "", "", "A!", "R+!", ""}},
    {"R+", {"", "", "R+c", "R+!", "F!", "", ""}},
    {"R+c", {"", "", "", "R+!", "F!", "", ""}},
    {"R+!", {"", "", "", "", "F!", "", ""}},
    {"A!", {"", "", "", "", "A!", "F!", ""}},
    {"F!", {"", "", "", "", "F!", "", ""}},
};

TEST(CallState, EveryEventInEveryStateLeadsWhereTheTableSays) {
  const auto states = reachable();
  ASSERT_EQ(states.size(), transitions.size());
  for (const State& state : states) {
    const auto row = std::ranges::find(transitions, name(state), &Row::from);
    ASSERT_NE(row, transitions.end()) << name(state);
    for (std::size_t at = 0; at < events.size(); ++at) {
      EXPECT_EQ(name(CallState::after(state, events.at(at))), row->to.at(at))
          << event_names.at(at) << " in " << row->from;
    }
  }
}

TEST(CallState, AnOutcomeIsToldOnceAndNeverTakenBack) {
  for (const State& state : reachable()) {
    if (state.reported != Reported::Outcome) continue;
    for (const Event event : events) {
      const auto next = CallState::after(state, event);
      if (!next) continue;
      EXPECT_EQ(next->reported, Reported::Outcome) << name(state);
    }
  }
}

TEST(CallState, EveryCallCanStillFinish) {
  for (State state : reachable()) {
    const std::string from = name(state);
    for (const Event event : {Event::Take, Event::Answer, Event::Return}) {
      state = CallState::after(state, event).value_or(state);
    }
    EXPECT_EQ(state.phase, Phase::Finished) << from;
  }
}

TEST(CallState, ACallThatEndsInTheQueueIsToldAndFinishedAtOnce) {
  CallState call;
  const auto change = call.on(Event::End);
  EXPECT_TRUE(change.report);
  EXPECT_TRUE(change.finished);
  EXPECT_FALSE(call.begun_at());
}

TEST(CallState, AnAnswerAfterTheEndIsNotToldAndFreesTheLane) {
  CallState call;
  const TimePoint begun{std::chrono::seconds(7)};
  call.on(Event::Take);
  call.on(Event::Begin, begun);
  EXPECT_EQ(call.begun_at(), begun);
  EXPECT_TRUE(call.on(Event::End).report);
  EXPECT_FALSE(call.on(Event::Return).finished);
  const auto change = call.on(Event::Answer);
  EXPECT_FALSE(change.report);
  EXPECT_TRUE(change.finished);
  EXPECT_FALSE(call.on(Event::Answer).finished) << "the second answer counts for nothing";
}

TEST(CallState, ItsCallerReadsWhereItStands) {
  CallState call;
  EXPECT_EQ(call.detail(), Detail::Queued);
  call.on(Event::Take);
  EXPECT_EQ(call.detail(), Detail::Executing);
  call.on(Event::Cancel);
  EXPECT_EQ(call.detail(), Detail::Canceling);
}

TEST(CallState, IsOverdueFromItsDeadlineOn) {
  CallState call;
  EXPECT_FALSE(call.overdue(TimePoint::max()));
  const TimePoint deadline{std::chrono::seconds(3)};
  call.set_deadline(deadline);
  EXPECT_FALSE(call.overdue(deadline - Duration{1}));
  EXPECT_TRUE(call.overdue(deadline));
}

TEST(CallState, MissesItsStartUnlessItHasBegun) {
  CallState call;
  EXPECT_FALSE(call.has_deadline());
  const TimePoint start_by{std::chrono::seconds(3)};
  call.set_start_by(start_by);
  EXPECT_TRUE(call.has_deadline());
  EXPECT_FALSE(call.overdue(start_by - Duration{1}));
  EXPECT_TRUE(call.overdue(start_by));
  EXPECT_TRUE(call.misses_start(start_by));
  call.on(Event::Take);
  call.on(Event::Begin, start_by - Duration{1});
  EXPECT_FALSE(call.overdue(TimePoint::max())) << "it started in time and may take long";
  call.set_deadline(start_by);
  EXPECT_TRUE(call.overdue(start_by));
  EXPECT_FALSE(call.misses_start(start_by));
}

TEST(CallProgress, IsSentAtMostOnceInAWhileAndTheNewestCounts) {
  CallProgress progress;
  const TimePoint start{std::chrono::seconds(1)};
  EXPECT_FALSE(progress.due(start)) << "there is none yet";
  progress.note(0.25, {});
  ASSERT_TRUE(progress.due(start));
  progress.sent(start);
  progress.note(0.5, {});
  progress.note(0.75, {});
  EXPECT_FALSE(progress.due(start + CallProgress::between - Duration{1}));
  EXPECT_TRUE(progress.due(start + CallProgress::between));
  EXPECT_EQ(progress.fraction(), 0.75);
}

}  // namespace
}  // namespace gecos::session
