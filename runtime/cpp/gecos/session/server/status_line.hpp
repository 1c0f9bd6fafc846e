#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gecos/access/proof.hpp"
#include "gecos/object_calls.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/server/open_questions.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// A request for the status of one object. The request has no reply yet.
struct StatusRequest {
  std::shared_ptr<ServerSession> session;
  std::uint64_t counter = 0;
  Status wanted = Status::ACTOR;
  double patience = 0;  ///< as the client gave it, in s
  TimePoint give_up{};
  TimePoint arrived{};
  std::uint64_t id = 0;      ///< the id by which holders deny the request; set by StatusLine::add
  access::Proof password{};  ///< empty if there is none, or since the derivation of `proof` began
  std::optional<access::Proof> proof{};  ///< nullopt until it is derived from the password
  bool compared = false;  ///< the password of the request was wrong and was counted as wrong
  /// How many requests wait before this request, as last reported to the client.
  std::optional<std::size_t> reported{};
};

/// Returns the beginning of `text` that is at most `longest` bytes long and valid UTF-8.
std::string cut_to(std::string text, std::size_t longest);
/// Returns a failure with the exception StatusRefused, which has the reason and the holders.
Failure status_refusal(std::string reason, std::vector<Holder> holders);

/// The waiting requests for the status of one object, in the order of their arrival, and the
/// clients that asked to be told of such requests. Not thread-safe: the object's mutex guards it.
class StatusLine {
 public:
  StatusLine(std::string object, const Clock& clock)
      : object_(std::move(object)),
        clock_(clock),
        questions_(object_ + ": too many questions about requests for the status", clock) {}

  /// Maximum number of waiting requests. A correct client has one request at a time.
  static constexpr std::size_t longest = 64;

  bool empty() const { return requests_.empty(); }
  /// Returns whether a request or a question about requests waits.
  bool somebody_waits() const { return !requests_.empty() || !questions_.empty(); }
  std::size_t size() const { return requests_.size(); }
  /// Returns whether a request has a password from which its proof is not derived yet.
  bool proving() const;
  /// Returns the first request for which the derivation of the proof has not begun; otherwise null.
  StatusRequest* first_to_prove();

  /// Appends `request`. When too many requests wait already, refuses `request` and returns false.
  bool add(StatusRequest request);
  /// Returns the waiting request of `session` whose counter is `counter`; null if there is none.
  StatusRequest* find(SessionId session, std::uint64_t counter);
  /// Returns the request with this id if it is shown to holders of the status; otherwise null.
  const StatusRequest* find(std::uint64_t id) const;
  /// Returns how many requests wait before the request `counter` of `session`. Returns 0 if the
  /// call `counter` is not a request but a question about requests, and nullopt if no such call
  /// waits.
  std::optional<std::size_t> place_of(SessionId session, std::uint64_t counter) const;
  /// Removes the call `counter` of `session`, which is a request or a question about requests, and
  /// replies with `failure`. Returns false when no such call waits.
  bool end(SessionId session, std::uint64_t counter, const Failure& failure);
  /// Removes all requests and replies with `failure` to each.
  void end_all(const Failure& failure);
  /// Removes the requests and questions of `session` without a reply.
  void forget(SessionId session);

  /// Replies with the list of the waiting requests. While no request has a larger id than
  /// `asked.after`, the reply waits, at most `asked.patience` seconds.
  void ask(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
           const GecosObject_requests_arguments& asked);
  /// Replies to the questions that have waited for too long.
  void on_tick();
  /// Replies to all questions with `failure`.
  void end_questions(const Failure& failure) { questions_.end_all(failure); }

  /// Calls `answer(request, before)` for each request in order, where `before` is the number of
  /// earlier requests that remain. Removes the requests for which `answer` returns true.
  template <class Answer>
  void remove_if(Answer answer) {
    std::vector<StatusRequest> stay;
    for (StatusRequest& request : std::exchange(requests_, {})) {
      if (!answer(request, stay.size())) stay.push_back(std::move(request));
    }
    requests_ = std::move(stay);
  }

  /// Tells each client how many requests are before its own request, if that number has changed.
  /// Replies to each question about requests that a new request answers.
  void tell_places();

 private:
  bool waits(const StatusRequest& request) const;
  void reply(const OpenQuestions::Question& question) const;
  void reply_to_questions();
  bool end(std::vector<StatusRequest>::iterator request, const Failure& failure);

  const std::string object_;
  const Clock& clock_;
  std::vector<StatusRequest> requests_;
  OpenQuestions questions_;
  std::uint64_t last_id_ = 0;
};

}  // namespace gecos::session
