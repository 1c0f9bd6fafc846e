#include "pulled_servant.hpp"

#include <string>
#include <utility>

namespace gecos::python {
namespace {

void refuse(Task& task) {
  auto* const arrived = std::get_if<Arrived>(&task);
  if (arrived == nullptr) return;
  arrived->call.fail({Detail::Rejected,
                      "'" + std::string(arrived->call.operation().name) +
                          "' was not started: the server is about to end",
                      {},
                      {}});
}

}  // namespace

void TaskQueue::push(Lane lane, Task task) {
  {
    const std::lock_guard lock(mutex_);
    if (!closed_) {
      lanes_[static_cast<std::size_t>(lane)].push_back(std::move(task));
      arrived_.notify_all();
      return;
    }
  }
  refuse(task);
}

std::optional<Task> TaskQueue::next(Lane lane, TimePoint until) {
  std::unique_lock lock(mutex_);
  auto& waiting = lanes_[static_cast<std::size_t>(lane)];
  arrived_.wait_until(lock, until, [&] { return closed_ || !waiting.empty(); });
  if (closed_ || waiting.empty()) return std::nullopt;
  Task task = std::move(waiting.front());
  waiting.pop_front();
  return task;
}

void TaskQueue::close() {
  std::array<std::deque<Task>, 2> unhandled;  // answered after the lock is gone
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    std::swap(unhandled, lanes_);
  }
  arrived_.notify_all();
  for (auto& lane : unhandled) {
    for (Task& task : lane) refuse(task);
  }
}

bool TaskQueue::closed() const {
  const std::lock_guard lock(mutex_);
  return closed_;
}

void PulledServant::gecos_dispatch(IncomingCall call) {
  const OperationDescription& operation = call.operation();
  const bool is_short =
      operation.status == access::Status::Sensor && !operation.cancelable && !operation.ordered;
  const Lane lane = operation.safety || is_short ? Lane::Sensor : Lane::Fifo;
  tasks_.push(lane, Arrived{number_, std::move(call)});
}

bool PulledServant::publish(FunctionCode code, ByteView sample, std::int64_t stamp_ns) {
  const StreamDescription* const stream = interface_.find_stream(code);
  if (stream == nullptr) return false;
  if (gecos_publisher_ != nullptr) gecos_publisher_->publish(*stream, sample, stamp_ns);
  return true;
}

}  // namespace gecos::python
