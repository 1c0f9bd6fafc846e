// Drives a cart until its server says that it has bumped. Needs 14's serve_cart.

#include <cstdio>
#include <iostream>

#include "cart_client.hpp"
#include "gecos/gecos.hpp"

using namespace std::chrono_literals;

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main() {
  gecos::Lab lab;
  const auto cart = lab.create<plant::Cart>("CART");
  if (!cart) return fail(cart.error());
  const auto lease = gecos::actor(*cart);
  if (!lease) return fail(lease.error());
  auto bumped = cart->bumped(gecos::stream);  // hears all events from now on
  if (!bumped) return fail(bumped.error());

  for (const double towards : {0.5, -0.5}) {  // m/s
    auto speed = cart->speed(gecos::writer);
    if (!speed) return fail(speed.error());
    const auto drive = cart->drive();
    speed->feeds(drive);
    while (drive.wait_for(20ms) == gecos::State::Running) {
      if (const auto sent = speed->send(towards); !sent) return fail(sent.error().text);
    }
    if (const auto driven = drive.get(); !driven) return fail(driven.error());
    const auto event = bumped->next(1s);
    if (!event) return fail(event.error());
    std::printf("bumped at %+.1f m; %llu bumps were missed\n", event->value.at,
                static_cast<unsigned long long>(event->lost));
  }
}
