// Uses an interface of one's own: oven.gidl beside this file. Needs 08_serve, which serves OVEN.

#include <iostream>

#include "gecos/gecos.hpp"
#include "oven_client.hpp"

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main() {
  gecos::Lab lab;
  auto oven = lab.create<plant::Oven>("OVEN");
  if (!oven) return fail(oven.error());
  const auto lease = gecos::actor(*oven);
  if (!lease) return fail(lease.error());

  const auto outside = oven->heat(600.0).get();  // outside its @range: is not sent
  if (!outside) std::cout << "600 K: " << outside.error() << std::endl;

  const auto refused = oven->heat(480.0).get();
  if (!refused) {
    const auto too_hot = refused.error().as<plant::TooHot>();  // declared by the interface
    if (!too_hot) return fail(refused.error());
    std::cout << "480 K: this oven goes up to " << too_hot->limit << " K" << std::endl;
  }

  const auto heated = oven->heat(350.0).get();
  if (!heated) return fail(heated.error());
  const auto temperature = oven->temperature().get();
  if (!temperature) return fail(temperature.error());
  std::cout << "350 K: the oven is at " << *temperature << " K" << std::endl;
}
