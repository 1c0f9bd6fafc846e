// Serves CART, a simulated cart that is driven by a stream of speeds: for 14 and 15.

#include <chrono>
#include <cmath>

#include "cart_server.hpp"
#include "gecos/gecos.hpp"
#include "gecos/serve.hpp"

using namespace std::chrono_literals;

namespace {

class SimulatedCart : public plant::CartServant {
  gecos::Result<double> drive(gecos::Execution<>& run) override {
    const auto feeding = speed().feeds(run);  // from now on, only speeds for this command count
    double now = 0;                           // m/s
    while (!run.wait_interrupted(cycle)) {
      if (const auto newer = speed().newest()) now = newer->value;
      if (speed().expired()) return position_;  // the client may have hung: stand
      position_ += now * std::chrono::duration<double>(cycle).count();
      if (std::abs(position_) > end) {
        position_ = std::copysign(end, now);
        publish_bumped({.at = position_});
        return position_;
      }
    }
    return tl::unexpected(gecos::Fault::interrupted());
  }

  static constexpr auto cycle = 20ms;
  static constexpr double end = 0.5;  // m, of the rail in both directions
  double position_ = 0;               // m
};

}  // namespace

int main() {
  gecos::Lab lab;
  SimulatedCart cart;
  return gecos::serve(lab, {{"CART", cart, {.simulated = true}}});  // until Ctrl-C
}
