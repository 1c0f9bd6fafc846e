// Serves OVEN until Ctrl-C. Run `gecos broker` first.

#include <iostream>

#include "gecos/gecos.hpp"
#include "plant/oven_server.hpp"

namespace {

constexpr double limit_kelvin = 500.0;

/// An oven that has its set temperature at once.
class Oven : public plant::OvenServant {
  gecos::Result<double> temperature() override { return temperature_; }
  gecos::Result<void> heat(double to) override {
    if (to > limit_kelvin) return tl::unexpected(plant::TooHot{limit_kelvin});
    temperature_ = to;
    return {};
  }
  gecos::Result<robcl::Frame> base() override { return base_; }
  gecos::Result<std::string> parent() override { return std::string(); }
  gecos::Result<void> mount(const std::string& carrier, const robcl::Frame& offset) override {
    if (!carrier.empty()) return tl::unexpected(robcl::MountRefused{"an oven stands on the floor"});
    base_ = offset;
    return {};
  }

  double temperature_ = 293.0;  ///< K
  robcl::Frame base_;
};

}  // namespace

int main() {
  gecos::Lab lab;
  Oven oven;
  gecos::Server server(lab);  // ends before what it serves
  if (auto served = server.add("OVEN", oven, {.simulated = true}); !served) {
    std::cerr << served.error().text << '\n';
    return 1;
  }
  std::cout << "OVEN is ready" << std::endl;
  server.run();
}
