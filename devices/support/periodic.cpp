#include "devices/support/periodic.hpp"

#include <chrono>
#include <utility>

#include "devices/support/cycle_timer.hpp"

namespace devices {
namespace {

using std::chrono::steady_clock;

/// Calls `work` once every `period` until `stop` is requested. `clock` is null if the cycles run in
/// real time.
void run(const std::stop_token& stop, LabClock* clock, gecos::Duration period,
         const std::function<void(double)>& work) {
  CycleTimer timer(period, clock == nullptr ? 1 : clock->speed(), steady_clock::now());
  while (!stop.stop_requested()) {
    const CycleTimer::Cycle cycle = timer.next(steady_clock::now());
    if (clock != nullptr) clock->set_reached(timer.reached());
    std::this_thread::sleep_until(cycle.begins);
    work(cycle.seconds);
  }
}

}  // namespace

Periodic::Periodic(gecos::Duration period, std::function<void(double)> work)
    : thread_([period, work = std::move(work)](const std::stop_token& stop) {
        run(stop, nullptr, period, work);
      }) {}

Periodic::Periodic(LabClock& clock, gecos::Duration period, std::function<void(double)> work,
                   std::function<void()> begin)
    : thread_([&clock, period, work = std::move(work),
               begin = std::move(begin)](const std::stop_token& stop) {
        begin();
        run(stop, &clock, period, work);
      }) {}

}  // namespace devices
