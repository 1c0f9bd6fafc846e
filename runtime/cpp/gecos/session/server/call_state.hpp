#pragma once

#include <cassert>
#include <cstdint>
#include <optional>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/command.hpp"

namespace gecos::session {

/// Where one call stands at its server, from the queue until its handler has answered and returned.
/// It has a phase, which its handler moves, and its caller knows its outcome or not yet: a call can
/// end for its caller (stopped, lease lost, deadline over) while its handler goes on. Pure: time is
/// passed in.
class CallState {
 public:
  enum class Phase : std::uint8_t {
    Queued,    ///< waits in the queue of its object
    Taken,     ///< has left the queue; its handler has not begun
    Running,   ///< its handler has begun and has not answered
    Answered,  ///< its handler has answered; the handler's thread has not returned
    Finished,  ///< nothing of it runs, and its caller knows its outcome
  };
  enum class Reported : std::uint8_t { Nothing, Canceling, Outcome };
  enum class Event : std::uint8_t {
    Take,    ///< the queue gives it to a thread
    Begin,   ///< it is marked as started, directly before its handler begins
    Cancel,  ///< its caller wants its handler to end
    End,     ///< its caller is told an outcome that is not its handler's
    Answer,  ///< its handler answers. The first answer counts, and not after another outcome
    Return,  ///< the thread of its handler comes back
    Drop,    ///< its handler does not begin: its caller was told why
  };
  struct State {
    Phase phase = Phase::Queued;
    Reported reported = Reported::Nothing;
    bool returned = false;  ///< the thread came back without an answer: that follows
    bool operator==(const State&) const = default;
  };
  /// What an event has brought about.
  struct Change {
    bool report = false;    ///< its caller is to be told the outcome now
    bool finished = false;  ///< its successor may start
  };

  /// The state after `event`; nothing where that cannot happen.
  static constexpr std::optional<State> after(State state, Event event);

  /// `deadline` by the clock of `since_boot`; TimePoint::max(): none.
  void set_deadline(TimePoint deadline) { deadline_ = deadline; }
  /// @pre the event can happen now. `now` by the clock of `since_boot`, needed for Begin.
  Change on(Event event, TimePoint now = {}) {
    const auto next = after(state_, event);
    assert(next);
    if (!next) return {};
    const Change change{next->reported == Reported::Outcome && state_.reported != Reported::Outcome,
                        next->phase == Phase::Finished && state_.phase != Phase::Finished};
    state_ = *next;
    if (event == Event::Begin) begun_at_ = now;
    return change;
  }

  Phase phase() const { return state_.phase; }
  bool queued() const { return state_.phase == Phase::Queued; }
  /// Its caller knows its outcome.
  bool ended() const { return state_.reported == Reported::Outcome; }
  bool canceling() const { return state_.reported == Reported::Canceling; }
  /// The thread that was given it holds its lane no longer.
  bool returned() const { return state_.returned || state_.phase == Phase::Finished; }
  /// When its handler began; nothing where it has not.
  std::optional<TimePoint> begun_at() const { return begun_at_; }
  bool has_deadline() const { return deadline_ != TimePoint::max(); }
  bool overdue(TimePoint since_boot) const { return has_deadline() && since_boot >= deadline_; }
  /// What its caller reads of it. @pre !ended()
  Detail detail() const {
    return canceling() ? Detail::Canceling : queued() ? Detail::Queued : Detail::Executing;
  }

 private:
  State state_;
  TimePoint deadline_ = TimePoint::max();
  std::optional<TimePoint> begun_at_;
};

constexpr std::optional<CallState::State> CallState::after(State state, Event event) {
  const bool with_handler = state.phase == Phase::Taken || state.phase == Phase::Running;
  const bool ended = state.reported == Reported::Outcome;
  switch (event) {
    case Event::Take:
      if (state.phase != Phase::Queued) return std::nullopt;
      return State{Phase::Taken, state.reported, false};
    case Event::Begin:
      if (state.phase != Phase::Taken || ended) return std::nullopt;
      return State{Phase::Running, state.reported, state.returned};
    case Event::Cancel:
      if (!with_handler || state.reported != Reported::Nothing) return std::nullopt;
      return State{state.phase, Reported::Canceling, state.returned};
    case Event::End:
      if (ended) return std::nullopt;
      if (state.phase == Phase::Queued) return State{Phase::Finished, Reported::Outcome, false};
      return State{state.phase, Reported::Outcome, state.returned};
    case Event::Answer:
      if (state.phase == Phase::Answered || state.phase == Phase::Finished) return state;
      if (!with_handler) return std::nullopt;
      return State{state.returned ? Phase::Finished : Phase::Answered, Reported::Outcome, false};
    case Event::Return:
      if (state.phase == Phase::Answered) return State{Phase::Finished, Reported::Outcome, false};
      if (!with_handler || state.returned) return std::nullopt;
      return State{state.phase, state.reported, true};
    case Event::Drop:
      if (state.phase != Phase::Taken || state.returned || !ended) return std::nullopt;
      return State{Phase::Finished, Reported::Outcome, false};
  }
  return std::nullopt;
}

/// What the caller of a running call knows of its progress. Pure: time is passed in.
class CallProgress {
 public:
  /// Between two reports; of what comes more often the newest is sent.
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
