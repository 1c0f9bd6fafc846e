// The paper's first example: a server for a laser distance sensor.
// Run `gecos broker` first, then this, then any of the clients beside it.

#include <cmath>

#include "gecos/gecos.hpp"
#include "gecos/serve.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/laser_distance_sensor_server.hpp"

namespace {

/// A sensor that looks at a wall which sways: it needs no hardware.
class SwayingWall : public robcl::LaserDistanceSensorServant {
  gecos::Result<robcl::Distance> measure() override {
    if (!on_) return tl::unexpected(robcl::SensorFault{"the laser is off: call power(true)"});
    const double now = static_cast<double>(gecos::unix_now_ns()) * 1e-9;
    const robcl::Distance distance{.value = 0.5 + 0.1 * std::sin(now),
                                   .valid = true,
                                   .lower = 0.05,
                                   .upper = 2.0,
                                   .stamp = now};
    publish_beam(distance);
    return distance;
  }
  gecos::Result<robcl::Distance> beam() override { return measure(); }
  gecos::Result<void> power(bool on) override {
    on_ = on;
    return {};
  }
  gecos::Result<robcl::Frame> base() override { return base_; }
  gecos::Result<std::string> parent() override { return std::string(); }
  gecos::Result<void> mount(const std::string& carrier, const robcl::Frame& offset) override {
    if (!carrier.empty()) {
      return tl::unexpected(
          robcl::MountRefused{"this sensor stands on the floor, not on " + carrier});
    }
    base_ = offset;
    return {};
  }

  bool on_ = true;
  robcl::Frame base_;
};

}  // namespace

int main() {
  gecos::Lab lab;
  SwayingWall sensor;
  return gecos::serve(lab, {{"LASER", sensor, {.simulated = true}}});  // until Ctrl-C
}
