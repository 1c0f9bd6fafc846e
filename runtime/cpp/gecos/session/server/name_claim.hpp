#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace gecos::session {

/// Records whether an object of this server still has its name, as far as the server knows.
///
/// Actor commands may start only while the broker confirms the name, or when no other process can
/// have the name. The reason: after a long pause another server may have the name, and two servers
/// must not move one robot. Each question to the broker has a number. A pause begins a new
/// question, because an answer to an older question says nothing about the time after the pause. A
/// time-out never permits commands. This class only records questions and answers; it does no I/O
/// and reads no clock.
///
/// Any thread may call standing(), waits() and refuses(). The object's mutex guards the other
/// functions.
class NameClaim {
 public:
  enum class Standing : std::uint8_t {
    Unregistered,  ///< no other process can have the name
    Asked,         ///< the broker was asked and has not answered yet: actor commands wait
    Unanswered,    ///< no broker answers: actor commands are refused
    Held,
    Taken,  ///< another server has the name
  };

  Standing standing() const { return standing_.load(std::memory_order_acquire); }
  /// Returns the number of the current question to the broker. Only an answer to this question
  /// counts.
  std::uint64_t question() const { return question_; }
  /// Begins a new question to the broker. From now on, answers to earlier questions are ignored.
  void ask() {
    ++question_;
    if (standing() != Standing::Taken) change(Standing::Asked);
  }

  // Each of the following functions records an answer of the broker, and returns whether the answer
  // has changed the result of standing().
  bool held(std::uint64_t question) {
    if (question != question_ || standing() == Standing::Unregistered) return false;
    why_.clear();
    return change(Standing::Held);
  }
  /// Records that a broker has answered but may still assign the name to another object.
  bool provisional() { return standing() == Standing::Unanswered && change(Standing::Asked); }
  bool unanswered(std::uint64_t question, std::string why) {
    const bool needed = waits() || standing() == Standing::Unanswered;
    if (question != question_ || !needed) return false;
    why_ = std::move(why);
    return change(Standing::Unanswered);
  }
  bool taken(std::string by) {
    why_ = std::move(by);
    return change(Standing::Taken);
  }

  /// True when actor commands must stay in the queue.
  bool waits() const { return standing() == Standing::Asked; }
  /// True when actor commands must end as NOT_STARTED.
  bool refuses() const {
    const Standing now = standing();
    return now == Standing::Unanswered || now == Standing::Taken;
  }
  /// Returns a text for people. It says why actor commands do not start, or that they may start.
  std::string text() const;

 private:
  bool change(Standing to) { return standing_.exchange(to, std::memory_order_acq_rel) != to; }

  std::atomic<Standing> standing_{Standing::Unregistered};  // publishes only itself
  std::uint64_t question_ = 0;
  std::string why_;
};

}  // namespace gecos::session
