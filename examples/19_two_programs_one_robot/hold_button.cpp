// Stands for the dead-man button of a person in the laboratory: reports that it is held, until
// someone presses Return. A silent button counts as released after 1 s, so a report is repeated.

#include <poll.h>
#include <unistd.h>

#include <iostream>

#include "gecos/gecos.hpp"
#include "gecos/presence_client.hpp"

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main() {
  gecos::Lab lab;
  auto zone = lab.create<gecos::Zone>("CELL");
  if (!zone) return fail(zone.error());
  pollfd input{STDIN_FILENO, POLLIN, 0};
  bool said = false;
  do {
    if (const auto held = zone->report_button("BUTTON", true).get(); !held)
      return fail(held.error());
    if (!said) std::cout << "the button is held" << std::endl;
    said = true;
  } while (poll(&input, 1, 300) == 0);
  const auto released = zone->report_button("BUTTON", false).get();
  if (!released) return fail(released.error());
  std::cout << "the button is released" << std::endl;
}
