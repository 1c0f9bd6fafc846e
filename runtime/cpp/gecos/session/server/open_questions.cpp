#include "gecos/session/server/open_questions.hpp"

#include <algorithm>
#include <string>

#include "gecos/base/seconds.hpp"

namespace gecos::session {
namespace {

/// Returns a function that is true for the question that arrived as the call `counter` of
/// `session`.
auto is_question(SessionId session, std::uint64_t counter) {
  return [=](const OpenQuestions::Question& question) {
    return question.session->id() == session && question.counter == counter;
  };
}

}  // namespace

void OpenQuestions::add(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                        std::uint64_t after, double patience) {
  if (const std::string why = too_many(session->caller()); !why.empty()) {
    return session->reply(counter, Failure{Detail::QueueFull, why, {}, {}});
  }
  questions_.push_back({session, counter, after, clock_.now() + from_seconds(patience)});
}

std::string OpenQuestions::too_many(const Caller& program) const {
  const auto own =
      static_cast<std::size_t>(std::ranges::count_if(questions_, [&](const Question& question) {
        const Caller& other = question.session->caller();
        return other.user == program.user && other.host == program.host &&
               other.incarnation == program.incarnation;
      }));
  if (own >= most_of_program) {
    return about_ + ": " + std::to_string(own) + " questions of " + program.program + " (pid " +
           std::to_string(program.pid) + " on " + program.host +
           ") already wait; ask again when one of these questions has been answered";
  }
  if (questions_.size() < most) return "";
  return about_ + ": " + std::to_string(questions_.size()) +
         " questions already wait; ask again later";
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
