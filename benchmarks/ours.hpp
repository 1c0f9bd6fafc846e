// Our own round trips: packets of a medium with no session around them, and calls of a generated
// proxy.
#pragma once

#include <memory>

#include "benchmarks/rounds.hpp"
#include "gecos/media/kinds.hpp"

namespace gecos::benchmarks {

/// 64 bytes there and back over a medium, waiting as a session does.
std::unique_ptr<Pair> packets(media::Kind kind, Cores cores);

/// `LaserDistanceSensor::measure()`: the server is this program run again, with a broker of its own
/// in GECOS_RUNTIME_DIR.
std::unique_ptr<Pair> sensor_call(media::Kind kind, Cores cores);
/// The same call, from Python.
std::unique_ptr<Pair> sensor_call_from_python(media::Kind kind, Cores cores);

/// The server's side of a sensor call: says on descriptor `ready` that it can be called, then
/// serves until it is killed.
int serve_sensor(media::Kind kind, int ready);

}  // namespace gecos::benchmarks
