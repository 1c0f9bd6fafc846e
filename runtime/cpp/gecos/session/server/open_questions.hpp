#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// Calls that ask for news, for example for the changes of the holders of a status that came after
/// the newest change known to the caller. While there is no news for a call, the call waits in this
/// object. Not thread-safe: the object's mutex guards it.
class OpenQuestions {
 public:
  struct Question {
    std::shared_ptr<ServerSession> session;
    std::uint64_t counter = 0;
    std::uint64_t after = 0;  ///< the number of the newest change or request that the caller knows
    TimePoint give_up{};
  };

  /// `about`: the beginning of the text of a refusal, for example "RX90: too many questions about
  /// requests".
  OpenQuestions(std::string about, const Clock& clock) : about_(std::move(about)), clock_(clock) {}

  /// Maximum number of questions of all programs together, and of one program. A correct proxy has
  /// one question at a time.
  static constexpr std::size_t most = 64;
  static constexpr std::size_t most_of_program = 8;

  /// Keeps a question for at most `patience` seconds, until `answer` replies to it. Refuses the
  /// question if the program of the caller, or all programs together, already have too many
  /// questions.
  void add(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
           std::uint64_t after, double patience);
  bool empty() const { return questions_.empty(); }
  bool waits(SessionId session, std::uint64_t counter) const;
  /// Removes a question and replies with `failure`. Returns false when no such question waits.
  bool end(SessionId session, std::uint64_t counter, const Failure& failure);
  void end_all(const Failure& failure);
  /// Removes the questions of `session` without a reply.
  void forget(SessionId session);

  /// Calls `reply(question)` for each question that has waited for long enough or for which
  /// `is_news(question.after)` is true. Removes these questions.
  template <class IsNews, class Reply>
  void answer(IsNews is_news, Reply reply) {
    std::erase_if(questions_, [&](const Question& question) {
      const bool answered = question.give_up <= clock_.now() || is_news(question.after);
      if (answered) reply(question);
      return answered;
    });
  }

 private:
  /// Returns why this program may not have another question; an empty text when it may.
  std::string too_many(const Caller& program) const;

  const std::string about_;
  const Clock& clock_;
  std::vector<Question> questions_;
};

}  // namespace gecos::session
