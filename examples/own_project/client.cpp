// Heats OVEN, asks for too much, and says how warm it is.

#include <iostream>

#include "gecos/gecos.hpp"
#include "plant/oven_client.hpp"

int main() {
  gecos::Lab lab;
  auto oven = lab.create<plant::Oven>("OVEN");
  if (!oven) {
    std::cerr << oven.error() << '\n';
    return 1;
  }
  const auto lease = gecos::actor(*oven);  // until the end of main no other program heats it
  if (!lease) {
    std::cerr << lease.error() << '\n';
    return 1;
  }
  if (auto done = oven->heat(400.0).get(); !done) {
    std::cerr << done.error() << '\n';
    return 1;
  }
  if (const auto refused = oven->heat(600.0).get(); !refused) {
    const auto too_hot = refused.error().as<plant::TooHot>();  // else it failed otherwise
    if (too_hot) std::cout << "not above " << too_hot->limit << " K\n";
  }
  const auto temperature = oven->temperature().get();
  if (!temperature) {
    std::cerr << temperature.error() << '\n';
    return 1;
  }
  std::cout << "it is at " << *temperature << " K\n";
}
