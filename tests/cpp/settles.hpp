#pragma once

#include <chrono>
#include <thread>

/// Whether `holds` within ten seconds. It is asked again and again: for what nobody can be told of,
/// as what the kernel shows of a process under /proc, or what somebody else has noticed. Whoever
/// has a descriptor, a condition or a line waits for that.
template <class Holds>
bool settles(Holds holds) {
  constexpr std::chrono::microseconds between_questions(200);  // leaves the processor to others
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!holds()) {
    if (std::chrono::steady_clock::now() >= give_up) return false;
    std::this_thread::sleep_for(between_questions);
  }
  return true;
}
