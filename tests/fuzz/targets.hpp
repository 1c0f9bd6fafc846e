// What is fuzzed: each takes one input, and ends the program when something does not hold that has
// to hold whatever the other side does. `make fuzz` runs them under libFuzzer with sanitizers, and
// `make test` with a fixed set of inputs (fixed_inputs_test.cpp).
#pragma once

#include "gecos/base/bytes.hpp"

namespace gecos::fuzz {

/// Rings and streams in memory, and a connection over shm, whose other side scribbles between our
/// steps.
void try_rings(ByteView input);
/// A session, the client's side or the server's, whose peer sends what it likes.
void try_packets(ByteView input);
/// Samples of an inward stream, whose client sends what it likes.
void try_samples(ByteView input);
/// What arrives on a port of the lcm medium, from strangers and from a peer that has a key.
void try_datagrams(ByteView input);

}  // namespace gecos::fuzz
