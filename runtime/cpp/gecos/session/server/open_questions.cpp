#include "gecos/session/server/open_questions.hpp"

#include <algorithm>
#include <chrono>

namespace gecos::session {
namespace {

/// Returns a predicate for the question with this counter in this session.
auto is_question(SessionId session, std::uint64_t counter) {
  return [=](const OpenQuestions::Question& question) {
    return question.session->id() == session && question.counter == counter;
  };
}

/// Converts seconds to a Duration. Returns about 30 years for longer times, including infinity.
Duration patience_of(double seconds) {
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(std::min(1e9, seconds)));
}

}  // namespace

void OpenQuestions::add(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                        std::uint64_t after, double patience) {
  if (questions_.size() < most) {
    questions_.push_back({session, counter, after, clock_.now() + patience_of(patience)});
    return;
  }
  session->reply(counter, Failure{Detail::QueueFull,
                                  about_ + ": " + std::to_string(questions_.size()) +
                                      " already wait; ask again later",
                                  {},
                                  {}});
}

bool OpenQuestions::waits(SessionId session, std::uint64_t counter) const {
  return std::ranges::any_of(questions_, is_question(session, counter));
}

bool OpenQuestions::end(SessionId session, std::uint64_t counter, const Failure& failure) {
  const auto found = std::ranges::find_if(questions_, is_question(session, counter));
  if (found == questions_.end()) return false;
  found->session->reply(counter, failure);
  questions_.erase(found);
  return true;
}

void OpenQuestions::end_all(const Failure& failure) {
  for (const Question& question : std::exchange(questions_, {})) {
    question.session->reply(question.counter, failure);
  }
}

void OpenQuestions::forget(SessionId session) {
  std::erase_if(questions_,
                [&](const Question& question) { return question.session->id() == session; });
}

}  // namespace gecos::session
