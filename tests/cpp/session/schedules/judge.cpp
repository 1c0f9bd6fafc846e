#include "schedules/judge.hpp"

#include <algorithm>
#include <utility>

namespace gecos::session::schedules {
namespace {

std::string milliseconds(Duration time) {
  return std::to_string(std::chrono::duration<double, std::milli>(time).count()) + " ms";
}

/// Nobody answered: only the client's own judgement.
bool nobody_answered(Detail detail) {
  return detail == Detail::OutcomeUnknown || detail == Detail::ServerCrashed;
}

/// Ends that say: its handler does not begin, neither before nor after.
bool says_not_started(Detail detail) {
  return project(detail) == State::ConnectionFailed || detail == Detail::QueueFull ||
         detail == Detail::Expired || detail == Detail::Denied || detail == Detail::Rejected;
}

/// At most one such handler of an object runs at a time.
bool runs_alone(const OperationDescription& operation) {
  return operation.status != access::Status::Sensor && !operation.parallel;
}

/// Any number of such handlers of an object may run at a time.
bool runs_beside_others(const OperationDescription& operation) {
  return operation.status != access::Status::Sensor && operation.parallel;
}

}  // namespace

std::size_t Judge::issued(const OperationDescription& operation, TimePoint now, Duration deadline) {
  Entry entry;
  entry.operation = &operation;
  if (deadline > Duration{}) entry.deadline = now + deadline;
  trace_(now, "issued", commands_.size(), operation.name, deadline.count());
  commands_.push_back(std::move(entry));
  return commands_.size() - 1;
}

void Judge::client_stood_still(Duration length) {
  for (Entry& entry : commands_) {
    if (entry.deadline != TimePoint::max()) entry.deadline += length;
  }
}

void Judge::look(TimePoint now) {
  for (Entry& entry : commands_) {
    if (entry.ended || !entry.core || !entry.core->terminal()) continue;
    entry.ended = now;
    entry.end = entry.core->progress().detail;
    trace_(now, "end of", &entry - commands_.data(), entry.end,
           entry.end == Detail::Done ? "" : entry.core->failure().text);
  }
}

void Judge::began(std::size_t number, TimePoint marked, TimePoint now, int freeze) {
  Entry& entry = commands_.at(number);
  trace_(now, "begins", number, "marked at", marked.time_since_epoch().count());
  if (++entry.begun > 1) alarm(number, "began twice");
  if (marked > entry.deadline) {
    alarm(number, "was marked " + milliseconds(marked - entry.deadline) + " after its deadline");
  }
  if (drains_) return;
  if (!parted_ && died_ && woke_ && *died_ + oldest_sign_of_life < *woke_ && marked > *woke_) {
    alarm(number, "was marked though its client died before the server went on");
  }
  if (!entry.ended || now < *entry.ended) return;
  if (marked > *entry.ended + news_take_) {
    return alarm(number,
                 "was marked " + milliseconds(marked - *entry.ended) + " after its end was told");
  }
  if (!nobody_answered(entry.end)) return alarm(number, "began after its end");
  ++begun_in_vain_;
  if (runs_alone(*entry.operation) && ++vain_by_freeze_[freeze] > 1)
    alarm(number, "is the second that began in vain after one freeze");
  if (runs_beside_others(*entry.operation) && ++vain_beside_others_[freeze] > running_beside())
    alarm(number, "is one more that began in vain after one freeze than run beside each other");
}

/// How many @parallel commands run, each on a thread of its own that a freeze may hold before the
/// handler.
std::size_t Judge::running_beside() const {
  return static_cast<std::size_t>(std::ranges::count_if(commands_, [](const Entry& entry) {
    return runs_beside_others(*entry.operation) && entry.begun != 0 && !entry.finished;
  }));
}

bool Judge::all_ended() const {
  return std::ranges::all_of(commands_, [](const Entry& entry) { return entry.ended.has_value(); });
}

void Judge::sum_up() {
  for (std::size_t number = 0; number < commands_.size(); ++number) {
    const Entry& entry = commands_[number];
    if (died_) continue;
    if (!entry.ended) {
      alarm(number, "has no end");
      continue;
    }
    const Detail now = entry.core->progress().detail;
    if (now != entry.end) alarm(number, "ends as " + std::string(to_string(now)) + " now");
    if (says_not_started(entry.end) && entry.begun != 0) alarm(number, "was started");
    if (entry.end == Detail::Done && !entry.finished) alarm(number, "has not finished");
  }
}

void Judge::alarm(std::size_t number, const std::string& what) {
  const Entry& entry = commands_[number];
  const std::string end = entry.ended ? std::string(to_string(entry.end)) : "open";
  alarms_.push_back("command " + std::to_string(number) + " (" +
                    std::string(entry.operation->name) + ", " + end + ") " + what);
}

}  // namespace gecos::session::schedules
