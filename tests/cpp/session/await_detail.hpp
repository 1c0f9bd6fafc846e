#pragma once

#include <stdexcept>
#include <string>
#include <thread>

#include "gecos/command.hpp"

namespace probe {

/// Returns once `command` stands at `wanted`, a detail of a command that runs; throws when it has
/// ended. Asks again and again: only the end of a command wakes who waits for it.
template <class Command>
void await_detail(const Command& command, gecos::Detail wanted) {
  for (;;) {
    const gecos::Detail now = command.progress().detail;
    if (now == wanted) return;
    if (project(now) != gecos::State::Running) {
      throw std::runtime_error("the command ended as " + std::string(to_string(now)) +
                               " and was awaited as " + std::string(to_string(wanted)));
    }
    std::this_thread::yield();
  }
}

}  // namespace probe
