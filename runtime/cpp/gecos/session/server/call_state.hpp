#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <optional>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/command.hpp"

namespace gecos::session {

/// The state of one call at its server, from the queue until its handler has answered and returned.
/// `phase` says how far the handler is; `reported` says what was sent to the caller. The caller may
/// already have the outcome (stopped, lease lost, deadline passed) while the handler still runs.
/// Reads no clock: the caller passes the current time.
class CallState {
 public:
  enum class Phase : std::uint8_t {
    Queued,    ///< the call waits in the queue of its object
    Taken,     ///< the call has left the queue; its handler has not begun
    Running,   ///< the handler has begun and has not answered
    Answered,  ///< the handler has answered; its thread has not returned
    Finished,  ///< the handler no longer runs, and the outcome was sent to the caller
  };
  enum class Reported : std::uint8_t { Nothing, Canceling, Outcome };
  enum class Event : std::uint8_t {
    Take,    ///< the queue hands the call to a thread
    Begin,   ///< the call is marked as started, directly before its handler begins
    Cancel,  ///< the caller requests cancellation
    End,     ///< an outcome that does not come from the handler is sent to the caller
    Answer,  ///< the handler answers; its answer is sent if no outcome was sent before
    Return,  ///< the thread of the handler returns
    Drop,    ///< the handler will not begin; the reason was sent to the caller
  };
  struct State {
    Phase phase = Phase::Queued;
    Reported reported = Reported::Nothing;
    bool returned = false;  ///< the handler's thread returned before the call was answered
    bool operator==(const State&) const = default;
  };
  /// What the server must do after an event.
  struct Change {
    bool report = false;    ///< the outcome must be sent to the caller now
    bool finished = false;  ///< the next call may start
  };

  /// Returns the state after `event`; nullopt when `event` cannot happen in `state`.
  static constexpr std::optional<State> after(State state, Event event) {
    return apply(event, state) ? std::optional(state) : std::nullopt;
  }

  /// `deadline`: a moment of Clock::since_boot; TimePoint::max() for no deadline.
  void set_deadline(TimePoint deadline) { deadline_ = deadline; }
  /// `start_by`: the latest start, a moment of Clock::since_boot; TimePoint::max() for none.
  void set_start_by(TimePoint start_by) { start_by_ = start_by; }
  /// Applies `event`. `now`: the current time of Clock::since_boot, needed only for Begin. @pre
  /// `event` can happen in the current state
  Change on(Event event, TimePoint now = {}) {
    const bool ended_before = ended();
    const bool finished_before = state_.phase == Phase::Finished;
    const bool possible = apply(event, state_);
    assert(possible);
    if (!possible) return {};
    if (event == Event::Begin) begun_at_ = now;
    return {.report = ended() && !ended_before,
            .finished = state_.phase == Phase::Finished && !finished_before};
  }

  Phase phase() const { return state_.phase; }
  bool queued() const { return state_.phase == Phase::Queued; }
  /// True when the outcome was reported to the caller.
  bool ended() const { return state_.reported == Reported::Outcome; }
  bool canceling() const { return state_.reported == Reported::Canceling; }
  /// Returns true when no thread runs the handler any more, so that the call occupies no thread of
  /// its lane.
  bool returned() const { return state_.returned || state_.phase == Phase::Finished; }
  /// Returns the time at which the handler began; nullopt before that.
  std::optional<TimePoint> begun_at() const { return begun_at_; }
  /// Returns true when the call has a deadline or a latest start, so that it ends even if it never
  /// starts.
  bool has_deadline() const { return std::min(deadline_, start_by_) != TimePoint::max(); }
  /// Returns true when the deadline has passed, or when a call that has not begun has missed its
  /// latest start.
  bool overdue(TimePoint since_boot) const {
    return (deadline_ != TimePoint::max() && since_boot >= deadline_) || misses_start(since_boot);
  }
  /// Returns true when the latest start has passed and the handler has not begun.
  bool misses_start(TimePoint since_boot) const {
    return start_by_ != TimePoint::max() && !begun_at_ && since_boot >= start_by_;
  }
  /// Returns the detail of the call as its caller sees it, for example Queued. @pre !ended()
  Detail detail() const {
    return canceling() ? Detail::Canceling : queued() ? Detail::Queued : Detail::Executing;
  }

 private:
  /// Changes `state` by `event`. Returns false, and changes nothing, when `event` cannot happen in
  /// `state`. The members are changed in place, because a copy of three bytes that were just
  /// written makes the processor wait.
  static constexpr bool apply(Event event, State& state);

  State state_;
  TimePoint deadline_ = TimePoint::max();
  TimePoint start_by_ = TimePoint::max();
  std::optional<TimePoint> begun_at_;
};

constexpr bool CallState::apply(Event event, State& state) {
  const bool with_handler = state.phase == Phase::Taken || state.phase == Phase::Running;
  const bool ended = state.reported == Reported::Outcome;
  const auto finish = [&state] {
    state.phase = Phase::Finished;
    state.reported = Reported::Outcome;
    state.returned = false;
  };
  switch (event) {
    case Event::Take:
      if (state.phase != Phase::Queued) return false;
      state.phase = Phase::Taken;
      return true;
    case Event::Begin:
      if (state.phase != Phase::Taken || ended) return false;
      state.phase = Phase::Running;
      return true;
    case Event::Cancel:
      if (!with_handler || state.reported != Reported::Nothing) return false;
      state.reported = Reported::Canceling;
      return true;
    case Event::End:
      if (ended) return false;
      if (state.phase == Phase::Queued) state.phase = Phase::Finished;
      state.reported = Reported::Outcome;
      return true;
    case Event::Answer:
      if (state.phase == Phase::Answered || state.phase == Phase::Finished) return true;
      if (!with_handler) return false;
      state.phase = state.returned ? Phase::Finished : Phase::Answered;
      state.reported = Reported::Outcome;
      state.returned = false;
      return true;
    case Event::Return:
      if (state.phase == Phase::Answered) {
        finish();
        return true;
      }
      if (!with_handler || state.returned) return false;
      state.returned = true;
      return true;
    case Event::Drop:
      if (state.phase != Phase::Taken || state.returned || !ended) return false;
      finish();
      return true;
  }
  return false;
}

/// The progress of a running call, as reported to its caller. Reads no clock: the caller passes the
/// current time.
class CallProgress {
 public:
  /// Minimum time between two reports. When the handler reports more often, only its newest report
  /// is sent.
  static constexpr Duration between = std::chrono::milliseconds(2);

  void note(double fraction, ByteView feedback) {
    fraction_ = fraction;
    feedback_.assign(feedback.begin(), feedback.end());
    unsent_ = true;
  }
  bool due(TimePoint now) const { return unsent_ && now >= sent_at_ + between; }
  void sent(TimePoint now) {
    unsent_ = false;
    sent_at_ = now;
  }
  double fraction() const { return fraction_; }
  const Bytes& feedback() const { return feedback_; }

 private:
  double fraction_ = 0;
  Bytes feedback_;
  bool unsent_ = false;
  TimePoint sent_at_{};
};

}  // namespace gecos::session
