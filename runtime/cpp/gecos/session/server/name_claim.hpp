#pragma once

#include <cstdint>
#include <string>

namespace gecos::session {

/// What a server knows of the claim of one of its objects to its name.
///
/// Actor commands start only while the claim is held, or where no broker was ever told of it: after
/// a long pause another server may have the name, and two servers must not move one robot. Each
/// question to the broker has a number, and a pause begins a new one: an answer to an older
/// question says nothing about what came after it. No time-out opens it. Pure.
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
  /// From now on an answer is needed, and those to earlier questions do not count.
  void ask() {
    ++question_;
    if (standing_ != Standing::Taken) standing_ = Standing::Asked;
  }

  // Answers. Each gives whether that is news.
  bool held(std::uint64_t question) {
    if (question != question_ || standing_ == Standing::Unregistered) return false;
    why_.clear();
    return change(Standing::Held);
  }
  /// A broker answers, and may still give the name to another object.
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
  /// For people: why actor commands do not start, or that they do.
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
