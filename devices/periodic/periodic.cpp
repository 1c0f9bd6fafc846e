#include "periodic/periodic.hpp"

#include <pthread.h>
#include <signal.h>

#include <chrono>
#include <utility>

namespace devices {

Periodic::Periodic(gecos::Duration period, std::function<void(double)> work) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);  // inherited by the thread
  thread_ = std::jthread([period, work = std::move(work)](const std::stop_token& stop) {
    gecos::TimePoint last = std::chrono::steady_clock::now();
    while (!stop.stop_requested()) {
      gecos::TimePoint next = last + period;
      const gecos::TimePoint now = std::chrono::steady_clock::now();
      if (now > next + period) next += (now - next) / period * period;
      std::this_thread::sleep_until(next);
      work(std::chrono::duration<double>(next - last).count());
      last = next;
    }
  });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace devices
