#include <unistd.h>

#include <atomic>
#include <exception>
#include <string>
#include <thread>
#include <utility>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/thread.hpp"
#include "gecos/listener.hpp"

namespace gecos::session {
namespace {

/// Calls a function of the program and logs any exception that it throws, because no caller can
/// catch it. `what`: the function and its stream, for the log.
void run_logged(const std::string& what, FunctionRef<void()> call) {
  try {
    call();
  } catch (const std::exception& error) {
    log_error("client", what + " threw: " + error.what() + "; catch the exception in the callback");
  } catch (...) {
    log_error("client", what +
                            " threw something that is no std::exception; catch it in the "
                            "callback");
  }
}

}  // namespace

/// The state shared with the thread. It outlives the ListenerThread when a callback destroys that
/// object.
struct ListenerThread::Shared {
  Shared(const std::shared_ptr<StreamCore>& of, Calls called)
      : stream(of), title(of->title()), calls(std::move(called)) {}
  void run();
  void end(StreamEnd how);

  const pid_t owner = getpid();
  const std::weak_ptr<StreamCore> stream;  ///< kept open by `calls`
  const std::string title;
  Calls calls;                      ///< used by the thread only
  std::atomic<bool> closed{false};  // orders no other memory
  Mutex mutex;
  std::thread thread GECOS_GUARDED_BY(mutex);
};

void ListenerThread::Shared::run() {
  for (;;) {
    const auto got = calls.read();
    if (closed.load(std::memory_order_relaxed)) break;
    if (got) {
      run_logged("the callback of the " + title, [this] { calls.give(); });
      continue;
    }
    if (got.error() == StreamEnd::Late) continue;
    // The wait has no limit, so it ends with Nothing only because close() has ended it.
    if (got.error() != StreamEnd::Nothing) end(got.error());
    break;
  }
  calls = {};
}

void ListenerThread::Shared::end(StreamEnd how) {
  const auto open = stream.lock();
  const std::string text = open ? open->loss_text() : std::string();
  if (calls.end) {
    run_logged("the callback for the end of the " + title, [&] { calls.end(how, text); });
  } else if (!text.empty()) {
    log_error("client", "the callback of the " + title + " gets no more samples: " + text);
  }
}

ListenerThread::ListenerThread(const std::shared_ptr<StreamCore>& stream, Calls calls)
    : shared_(std::make_shared<Shared>(stream, std::move(calls))) {
  const MutexLock lock(shared_->mutex);
  shared_->thread = start_thread("gecos-listener", [shared = shared_] { shared->run(); });
}

ListenerThread::~ListenerThread() { leave(); }

ListenerThread& ListenerThread::operator=(ListenerThread&& other) noexcept {
  if (this == &other) return *this;
  leave();
  shared_ = std::move(other.shared_);
  return *this;
}

void ListenerThread::close() {
  if (shared_ == nullptr || getpid() != shared_->owner) return;
  shared_->closed.store(true, std::memory_order_relaxed);
  if (const auto open = shared_->stream.lock()) open->stop_waiting();
  std::thread thread;
  {
    const MutexLock lock(shared_->mutex);
    if (shared_->thread.get_id() == std::this_thread::get_id()) return;
    thread = std::move(shared_->thread);
  }
  if (thread.joinable()) thread.join();
}

/// Ends the thread, or leaves it to end by itself if it is the calling thread. A forked child has
/// no such thread, and the mutex may stay locked for ever there, so the child leaks the state.
void ListenerThread::leave() {
  if (shared_ == nullptr) return;
  if (getpid() != shared_->owner) {
    static_cast<void>(new std::shared_ptr<Shared>(std::move(shared_)));
    return;
  }
  close();
  const MutexLock lock(shared_->mutex);
  if (shared_->thread.joinable()) shared_->thread.detach();
}

}  // namespace gecos::session
