#pragma once

#include <cstdint>
#include <string>

namespace gecos::session {

/// Whether an object of this server still holds its name, as far as the server knows.
///
/// Actor commands start only while the broker confirms the name, or when no other process can have
/// it: after a long pause another server may have the name, and two servers must not move one
/// robot. Each question to the broker has a number, and a pause begins a new question: an answer to
/// an older one says nothing about the time after it. No time-out permits commands. Pure.
class NameClaim {
 public:
  enum class Standing : std::uint8_t {
    Unregistered,  ///< no other process can have the name
    Asked,         ///< actor commands wait
    Unanswered,    ///< no broker answers: actor commands are not started
    Held,
    Taken,  ///< another server has the name
  };

  Standing standing() const { return standing_; }
  /// The number of the question that has to be answered.
  std::uint64_t question() const { return question_; }
  /// Begins a new question; answers to earlier questions are ignored.
  void ask() {
    ++question_;
    if (standing_ != Standing::Taken) standing_ = Standing::Asked;
  }

  // Answers of the broker. Each function returns whether the standing changed.
  bool held(std::uint64_t question) {
    if (question != question_ || standing_ == Standing::Unregistered) return false;
    why_.clear();
    return change(Standing::Held);
  }
  /// A broker answered, but may still assign the name to another object.
  bool provisional() { return standing_ == Standing::Unanswered && change(Standing::Asked); }
  bool unanswered(std::uint64_t question, std::string why) {
    const bool needed = standing_ == Standing::Asked || standing_ == Standing::Unanswered;
    if (question != question_ || !needed) return false;
    why_ = std::move(why);
    return change(Standing::Unanswered);
  }
  bool taken(std::string by) {
    why_ = std::move(by);
    return change(Standing::Taken);
  }

  /// Actor commands stay in the queue.
  bool waits() const { return standing_ == Standing::Asked; }
  /// Actor commands end NOT_STARTED.
  bool refuses() const { return standing_ == Standing::Unanswered || standing_ == Standing::Taken; }
  /// Readable text: why actor commands do not start, or that they do.
  std::string text() const;

 private:
  bool change(Standing to) {
    const bool news = standing_ != to;
    standing_ = to;
    return news;
  }

  Standing standing_ = Standing::Unregistered;
  std::uint64_t question_ = 0;
  std::string why_;
};

}  // namespace gecos::session
