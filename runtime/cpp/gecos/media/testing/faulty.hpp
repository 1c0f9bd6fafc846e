#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "gecos/base/clock.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// The faults of a simulated bad connection. A rate is from 0 to 1 and applies to each packet
/// independently.
struct Faults {
  std::uint64_t seed = 1;  ///< the same seed and the same packets give the same faults
  double loss = 0;
  double duplication = 0;
  double corruption = 0;  ///< flips one bit of a packet
  double reordering = 0;  ///< rate of packets that are held back, so that later ones arrive first
  Duration reordering_delay = std::chrono::milliseconds(2);
  Duration delay{};  ///< added to every packet; a satellite takes 250 ms
  /// A number of nanoseconds that is added to `delay`. A test may change the number while the
  /// program runs. The pointer may be null, and the caller owns the number.
  const std::atomic<Duration::rep>* more_delay = nullptr;
  /// While this flag is true, neither packets nor heartbeats arrive. The pointer may be null, and
  /// the caller owns the flag.
  const std::atomic<bool>* cut = nullptr;
};

/// Wraps a medium for tests. Its connections apply `faults` to the packets that they receive. If
/// the media of both sides are wrapped, packets of both directions have faults. Streams have no
/// faults.
///
/// `clock` measures the delays. A thread that sleeps on a connection wakes for a delayed packet in
/// real time. A test with a fake clock must therefore poll again after every step of the clock.
std::unique_ptr<Medium> make_faulty(std::unique_ptr<Medium> inner, Faults faults,
                                    const Clock& clock);

}  // namespace gecos::media
