// Serves RAIL: the C++ half of the pairs in test_pairs.py.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "gecos/gecos.hpp"
#include "lab/rail_sensor_server.hpp"

namespace {

constexpr double wall = 2.0;
constexpr double rail_end = 1.0;
constexpr double speed = 0.5;
constexpr auto tick = std::chrono::milliseconds(20);

class Rail : public lab::RailSensorServant {
  gecos::Result<void> travel(double target, gecos::Execution<>& run) override {
    if (target < 0 || target > rail_end) return tl::unexpected(lab::RailEnd{rail_end});
    const double start = position_;
    const auto began = std::chrono::steady_clock::now();
    while (position_ != target) {
      if (run.wait_interrupted(tick)) return tl::unexpected(gecos::Fault::interrupted());
      const std::chrono::duration<double> ridden = std::chrono::steady_clock::now() - began;
      const double step = std::min(speed * ridden.count(), std::abs(target - start));
      position_ = start + std::copysign(step, target - start);
      run.progress(step / std::abs(target - start));
      publish_beam(look());
    }
    return {};
  }
  gecos::Result<robcl::Distance> measure() override {
    if (!on_) return tl::unexpected(robcl::SensorFault{"the laser is off"});
    return look();
  }
  gecos::Result<robcl::Distance> beam() override { return look(); }
  gecos::Result<void> power(bool on) override {
    on_ = on;
    return {};
  }
  gecos::Result<robcl::Frame> base() override { return robcl::translate(position_, 0, 0); }
  gecos::Result<std::string> parent() override { return std::string(); }
  gecos::Result<void> mount(const std::string&, const robcl::Frame&) override {
    return tl::unexpected(robcl::MountRefused{"it is bolted to its rail"});
  }

  robcl::Distance look() const {
    return {.value = wall - position_,
            .valid = true,
            .lower = 0.05,
            .upper = 2.5,
            .stamp = static_cast<double>(gecos::unix_now_ns()) * 1e-9};
  }

  std::atomic<double> position_{0};  // written by the ride, read by the sensor lane
  std::atomic<bool> on_{true};
};

}  // namespace

int main() {
  gecos::Lab lab;
  Rail rail;
  gecos::Server server(lab);  // ends before what it serves
  if (auto served = server.add("RAIL", rail, {.simulated = true, .thread_safe = true}); !served) {
    std::fprintf(stderr, "%s\n", served.error().text.c_str());
    return 1;
  }
  std::puts("serving RAIL");
  std::fflush(stdout);
  server.run();
}
