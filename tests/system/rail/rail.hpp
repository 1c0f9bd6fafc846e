// The rail of test_pairs.py, as the servers in C++ have it.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <string>

#include "gecos/gecos.hpp"
#include "lab/rail_sensor_server.hpp"

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

  static constexpr double wall = 2.0;  // m
  static constexpr double rail_end = 1.0;
  static constexpr double speed = 0.5;  // m/s
  static constexpr auto tick = std::chrono::milliseconds(20);

  std::atomic<double> position_{0};  // written by the ride, read by the sensor lane
  std::atomic<bool> on_{true};
};
