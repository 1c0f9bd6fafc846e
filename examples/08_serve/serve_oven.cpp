// Serves OVEN: the interface of 07_own_interface, a simulated oven below it.

#include <atomic>
#include <chrono>

#include "gecos/gecos.hpp"
#include "gecos/serve.hpp"
#include "oven_server.hpp"

using namespace std::chrono_literals;

namespace {

class SimulatedOven : public plant::OvenServant {
  gecos::Result<double> temperature() override { return temperature_.load(); }

  gecos::Result<void> heat(double to, gecos::Execution<>& run) override {
    if (to > hottest) return tl::unexpected(plant::TooHot{hottest});
    const double from = temperature_;
    for (int step = 1; step <= steps; ++step) {
      if (run.wait_interrupted(50ms)) return tl::unexpected(gecos::Fault::interrupted());
      temperature_ = from + (to - from) * step / steps;
      run.progress(static_cast<double>(step) / steps);
      publish_temperature(temperature_);
    }
    return {};
  }

  static constexpr double hottest = 450;  // K
  static constexpr int steps = 20;
  std::atomic<double> temperature_{293};  // K; heat() tells temperature(), which may run meanwhile
};

}  // namespace

int main() {
  gecos::Lab lab;
  SimulatedOven oven;
  // Until Ctrl-C.
  return gecos::serve(lab, {{"OVEN", oven, {.simulated = true, .thread_safe = true}}});
}
