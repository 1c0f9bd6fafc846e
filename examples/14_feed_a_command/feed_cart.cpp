// Drives a cart by a stream of speeds, and stops sending. Needs serve_cart, which serves CART.

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
  auto speed = cart->speed(gecos::writer);
  if (!speed) return fail(speed.error());

  const auto outside = speed->send(3.0);  // outside its @range: is not sent
  if (!outside) std::cout << "3 m/s: " << outside.error().text << std::endl;

  const auto drive = cart->drive();
  speed->feeds(drive);  // its samples have no effect on another command
  for (int step = 0; step < 50; ++step) {
    const auto sent = speed->send(0.01 * step);  // m/s; has no effect after a stop
    if (!sent) return fail(sent.error().text);
    drive.wait_for(20ms);
  }
  // Nothing more is sent, as if this program hung: the cart stands by itself.
  const auto position = drive.get();
  if (!position) return fail(position.error());
  std::printf("driven to %.2f m\n", *position);
  const auto report = speed->report().get();
  if (!report) return fail(report.error());
  std::cout << report->admitted << " of 50 speeds were used, " << report->lost
            << " were replaced by newer ones" << std::endl;
}
