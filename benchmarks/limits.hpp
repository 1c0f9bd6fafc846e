// The limits beside which our own numbers stand: what a ring, a socket and LCM do with nothing of
// ours around them. Each carries 64 bytes to another process and back.
#pragma once

#include <memory>

#include "benchmarks/rounds.hpp"

namespace gecos::benchmarks {

/// Ring in shared memory, spinning without ever giving the core away. Hopeless on one core.
std::unique_ptr<Pair> raw_spinning_ring(Cores cores);
/// The same, giving the core away after every look.
std::unique_ptr<Pair> raw_yielding_ring(Cores cores);
/// A Unix stream socket, blocking.
std::unique_ptr<Pair> raw_unix_socket(Cores cores);
/// LCM with a handler on each side, blocking in lcm_handle.
std::unique_ptr<Pair> raw_lcm(Cores cores);

}  // namespace gecos::benchmarks
