#include "gecos/session/process/callbacks.hpp"

#include <unistd.h>

#include <deque>
#include <exception>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/thread.hpp"

namespace gecos::session {

void run_callback(const std::function<void()>& callback) {
  try {
    callback();
  } catch (const std::exception& error) {
    log_error("session", std::string("a callback of a command threw: ") + error.what() +
                             "; catch the exception in the callback");
  } catch (...) {
    log_error("session",
              "a callback of a command threw something that is no std::exception; catch it in "
              "the callback");
  }
}

/// The state shared with the callback thread. It outlives the Callbacks object when a callback
/// destroys that object.
struct Callbacks::Shared {
  void run();

  const pid_t owner = getpid();
  Mutex mutex;
  ConditionVariable changed;
  std::deque<std::function<void()>> waiting GECOS_GUARDED_BY(mutex);
  bool ended GECOS_GUARDED_BY(mutex) = false;
  std::thread thread GECOS_GUARDED_BY(mutex);
};

void Callbacks::Shared::run() {
  MutexLock lock(mutex);
  for (;;) {
    while (!ended && waiting.empty()) changed.wait(lock);
    if (waiting.empty()) return;
    {
      const auto next = std::move(waiting.front());
      waiting.pop_front();
      lock.unlock();
      run_callback(next);
    }
    lock.lock();
  }
}

Callbacks::Callbacks() : shared_(std::make_shared<Shared>()) {}

Callbacks::~Callbacks() {
  std::thread thread;
  {
    const MutexLock lock(shared_->mutex);
    shared_->ended = true;
    thread = std::move(shared_->thread);
  }
  shared_->changed.notify_one();
  if (!thread.joinable()) return;
  if (thread.get_id() == std::this_thread::get_id() || getpid() != shared_->owner) {
    thread.detach();  // the thread does not exist in a forked child
  } else {
    thread.join();
  }
}

void Callbacks::post(std::function<void()> callback) {
  const MutexLock lock(shared_->mutex);
  shared_->waiting.push_back(std::move(callback));
  if (!shared_->thread.joinable()) {
    try {
      shared_->thread = start_thread("gecos-callbacks", [shared = shared_] { shared->run(); });
    } catch (const std::system_error& failed) {
      log_error("session",
                std::string("no thread could be created for the callbacks of commands (") +
                    failed.what() +
                    "); these callbacks wait until the next command with a callback ends");
    }
  }
  shared_->changed.notify_one();
}

}  // namespace gecos::session
