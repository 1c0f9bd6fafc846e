#include "devices/support/periodic.hpp"

#include <chrono>
#include <utility>

namespace devices {

Periodic::Periodic(gecos::Duration period, std::function<void(double)> work,
                   std::function<void()> begin) {
  thread_ = std::jthread(
      [period, work = std::move(work), begin = std::move(begin)](const std::stop_token& stop) {
        begin();
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
}

}  // namespace devices
