#include "gecos/base/thread.hpp"

#include <pthread.h>
#include <signal.h>

#include <memory>
#include <system_error>
#include <utility>

namespace gecos {

std::thread start_thread(const std::string& name, std::function<void()> run) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const auto restore = [](const sigset_t* mask) { pthread_sigmask(SIG_SETMASK, mask, nullptr); };
  const std::unique_ptr<const sigset_t, decltype(restore)> at_end(
      &before, restore);  // restores the mask, even when no thread can be started
  try {
    std::thread thread([run = std::move(run)] { run(); });
    pthread_setname_np(thread.native_handle(), name.substr(0, 15).c_str());
    return thread;
  } catch (const std::system_error& failed) {
    throw std::system_error(failed.code(),
                            "cannot start the thread " + name + " (see `ulimit -u`)");
  }
}

}  // namespace gecos
