#include "gecos/session/server_call.hpp"

#include "gecos/session/served_object.hpp"
#include "gecos/session/server_session.hpp"

namespace gecos::session {

ServerCall::ServerCall(std::shared_ptr<ServedObject> its_object,
                       std::shared_ptr<ServerSession> its_session,
                       const OperationDescription& its_operation, std::uint64_t its_counter,
                       Epoch its_epoch, ByteView arguments)
    : Ticket(its_session->id(), its_operation, arguments.size()),
      object(std::move(its_object)),
      session(std::move(its_session)),
      counter(its_counter),
      epoch(its_epoch),
      arguments_(arguments.begin(), arguments.end()) {}

const Caller& ServerCall::caller() const { return session->caller(); }

bool ServerCall::wait_interrupted_until(TimePoint until) {
  std::unique_lock lock(mutex_);
  const auto wanted = [this] { return interrupted(); };
  if (until == TimePoint::max()) {
    woken_.wait(lock, wanted);
    return true;
  }
  return woken_.wait_until(lock, until, wanted);
}

void ServerCall::interrupt() {
  {
    const std::lock_guard lock(mutex_);
    interrupted_.store(true, std::memory_order_release);
  }
  woken_.notify_all();
}

void ServerCall::progress(double its_fraction, ByteView its_feedback) {
  object->progressed(*this, its_fraction, its_feedback);
}

void ServerCall::finish(ByteView result) { object->answered(*this, result); }

void ServerCall::fail(Failure failure) { object->answered(*this, std::move(failure)); }

}  // namespace gecos::session
