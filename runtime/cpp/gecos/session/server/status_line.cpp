#include "gecos/session/server/status_line.hpp"

#include <algorithm>
#include <chrono>

#include "gecos/base/seconds.hpp"
#include "gecos/wire/layout.hpp"
#include "gecos/wire/text.hpp"

namespace gecos::session {
namespace {

/// Returns a function that is true for the request that arrived as the call `counter` of `session`.
auto is(SessionId session, std::uint64_t counter) {
  return
      [=](const auto& asked) { return asked.session->id() == session && asked.counter == counter; };
}

WaitingRequest shown(const StatusRequest& request, TimePoint now) {
  const Caller& caller = request.session->caller();
  WaitingRequest line;
  line.id = request.id;
  line.wanted = request.wanted;
  line.user = cut_to(caller.user, 64);
  line.host = cut_to(caller.host, 64);
  line.program = cut_to(caller.program, 128);
  line.pid = caller.pid;
  line.waited_for = to_seconds(now - request.arrived);
  line.expires_in = to_seconds(request.give_up - now);
  return line;
}

}  // namespace

std::string cut_to(std::string text, std::size_t longest) {
  while (text.size() > longest) text.pop_back();
  while (!wire::valid_utf8(text)) text.pop_back();
  return text;
}

Failure status_refusal(std::string reason, std::vector<Holder> holders) {
  StatusRefused refused;
  refused.reason = std::move(reason);
  refused.holders = std::move(holders);
  return {Detail::Fault, refused.reason, std::string(StatusRefused::type_name()),
          wire::to_bytes(refused)};
}

bool StatusLine::proving() const {
  return std::ranges::any_of(requests_,
                             [](const StatusRequest& request) { return !request.proof; });
}

StatusRequest* StatusLine::first_to_prove() {
  const auto found = std::ranges::find_if(
      requests_, [](const StatusRequest& request) { return !request.password.empty(); });
  return found == requests_.end() ? nullptr : &*found;
}

bool StatusLine::add(StatusRequest request) {
  if (requests_.size() < longest) {
    request.id = ++last_id_;
    request.arrived = clock_.now();
    requests_.push_back(std::move(request));
    return true;
  }
  request.session->reply(request.counter,
                         Failure{Detail::QueueFull,
                                 object_ + ": " + std::to_string(requests_.size()) +
                                     " requests for a status already wait; try again later",
                                 {},
                                 {}});
  return false;
}

StatusRequest* StatusLine::find(SessionId session, std::uint64_t counter) {
  const auto found = std::ranges::find_if(requests_, is(session, counter));
  return found == requests_.end() ? nullptr : &*found;
}

const StatusRequest* StatusLine::find(std::uint64_t id) const {
  const auto found = std::ranges::find_if(
      requests_, [&](const StatusRequest& request) { return request.id == id && waits(request); });
  return found == requests_.end() ? nullptr : &*found;
}

std::optional<std::size_t> StatusLine::place_of(SessionId session, std::uint64_t counter) const {
  if (questions_.waits(session, counter)) return 0;
  const auto found = std::ranges::find_if(requests_, is(session, counter));
  if (found == requests_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - requests_.begin());
}

bool StatusLine::end(std::vector<StatusRequest>::iterator request, const Failure& failure) {
  if (request == requests_.end()) return false;
  request->session->reply(request->counter, failure);
  requests_.erase(request);
  tell_places();
  return true;
}

bool StatusLine::end(SessionId session, std::uint64_t counter, const Failure& failure) {
  return questions_.end(session, counter, failure) ||
         end(std::ranges::find_if(requests_, is(session, counter)), failure);
}

void StatusLine::end_all(const Failure& failure) {
  for (const StatusRequest& request : std::exchange(requests_, {})) {
    request.session->reply(request.counter, failure);
  }
}

void StatusLine::forget(SessionId session) {
  std::erase_if(requests_,
                [&](const StatusRequest& asked) { return asked.session->id() == session; });
  questions_.forget(session);
  tell_places();
}

/// Returns whether `request` is shown to holders of the status, who may deny it.
bool StatusLine::waits(const StatusRequest& request) const {
  return request.proof && request.give_up > clock_.now();
}

// The functions below handle questions about waiting requests.

void StatusLine::ask(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                     const GecosObject_requests_arguments& asked) {
  questions_.add(session, counter, asked.after, asked.patience);
  reply_to_questions();
}

void StatusLine::reply(const OpenQuestions::Question& question) const {
  const TimePoint now = clock_.now();
  GecosObject_requests_result answer;
  for (const StatusRequest& request : requests_) {
    if (waits(request)) answer.result.push_back(shown(request, now));
  }
  question.session->reply(question.counter, layout::to_bytes(answer));
}

void StatusLine::reply_to_questions() {
  questions_.answer(
      [&](std::uint64_t known) {
        return std::ranges::any_of(requests_, [&](const StatusRequest& request) {
          return request.id > known && waits(request);
        });
      },
      [&](const OpenQuestions::Question& question) { reply(question); });
}

void StatusLine::on_tick() { reply_to_questions(); }

void StatusLine::tell_places() {
  for (std::size_t before = 0; before < requests_.size(); ++before) {
    StatusRequest& request = requests_[before];
    if (!request.proof || request.reported == before) continue;
    if (request.session->report_queued(request.counter, before)) request.reported = before;
  }
  reply_to_questions();
}

}  // namespace gecos::session
