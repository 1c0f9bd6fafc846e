#include "pulled_servant.hpp"

#include <string>
#include <utility>

namespace gecos::python {
namespace {

void refuse(Task& task) {
  auto* const call = std::get_if<IncomingCall>(&task);
  if (call == nullptr) return;
  call->fail(
      {Detail::Rejected,
       "'" + std::string(call->operation().name) + "' was not started: the server is about to end",
       {},
       {}});
}

Lane lane_of(const OperationDescription& operation) {
  const bool is_short =
      operation.status == access::Status::Sensor && !operation.cancelable && !operation.ordered;
  return operation.safety ? Lane::Safety : is_short ? Lane::Sensor : Lane::Fifo;
}

}  // namespace

void TaskQueue::push(Task task) {
  {
    const MutexLock lock(mutex_);
    if (!closed_) {
      waiting_.push_back(std::move(task));
      arrived_.notify_one();
      return;
    }
  }
  refuse(task);
}

std::optional<Task> TaskQueue::next() {
  for (;;) {
    std::optional<Task> task = pull();
    if (!task) return std::nullopt;
    auto* const call = std::get_if<IncomingCall>(&*task);
    if (call == nullptr || call->begin()) return task;
  }
}

std::optional<Task> TaskQueue::pull() {
  MutexLock lock(mutex_);
  while (!closed_ && waiting_.empty()) arrived_.wait(lock);
  if (closed_) return std::nullopt;
  Task task = std::move(waiting_.front());
  waiting_.pop_front();
  return task;
}

void TaskQueue::close() {
  std::deque<Task> unhandled;  // these calls are rejected after the lock is released
  {
    const MutexLock lock(mutex_);
    closed_ = true;
    std::swap(unhandled, waiting_);
  }
  arrived_.notify_all();
  for (Task& task : unhandled) refuse(task);
}

void PulledServant::gecos_dispatch(IncomingCall call) {
  queue(lane_of(call.operation())).push(std::move(call));
}

bool PulledServant::gecos_share_thread(const OperationDescription& one,
                                       const OperationDescription& other) const {
  return lane_of(one) == lane_of(other);
}

void PulledServant::close() {
  for (TaskQueue& lane : lanes_) lane.close();
}

bool PulledServant::publish(FunctionCode code, ByteView sample, std::int64_t stamp_ns) {
  const StreamDescription* const stream = interface_.find_stream(code);
  if (stream == nullptr) return false;
  gecos_publisher_.with(
      [&](session::Publisher& publisher) { publisher.publish(*stream, sample, stamp_ns); });
  return true;
}

tl::expected<Loan, std::string> PulledServant::lend(FunctionCode code, ByteView head,
                                                    std::size_t octets, ByteView tail) {
  const StreamDescription* const stream = interface_.find_stream(code);
  if (stream == nullptr) return tl::unexpected<std::string>("the interface has no such stream");
  const std::size_t counted = head.size() - 4;  // put_bulk() writes the count at the end of `head`
  return gecos_lend(*stream, {head.size() + octets + tail.size(), octets, octets},
                    [&](wire::Encoder& to) {
                      to.put_bytes(head.first(counted));
                      to.put_bulk({});
                      to.put_bytes(tail);
                    });
}

bool PulledServant::with_inward(FunctionCode code,
                                FunctionRef<void(session::InwardCore&)> use) const {
  const InwardDescription* const stream = interface_.find_inward_stream(code);
  if (stream == nullptr) return false;
  session::with_inward(*this, *stream, use);
  return true;
}

}  // namespace gecos::python
