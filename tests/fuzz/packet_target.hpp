#pragma once

#include "gecos/base/clock.hpp"
#include "gecos/session/process/runtime.hpp"
#include "script.hpp"

namespace gecos::fuzz {

/// The server's side, with two clients.
void try_served(Script script);
/// The client's side, from its greeting on.
void try_connected(Script script);

/// One clock for all inputs; it only advances.
inline FakeClock& the_clock() {
  static FakeClock clock;
  return clock;
}
inline const std::shared_ptr<session::Runtime>& the_runtime() {
  static const auto runtime = session::Runtime::make({}, the_clock()).value();
  return runtime;
}

}  // namespace gecos::fuzz
