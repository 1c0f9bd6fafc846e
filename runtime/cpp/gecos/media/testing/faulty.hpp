#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "gecos/base/clock.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// The faults of a connection. Rates are from 0 to 1 and apply to each packet independently.
struct Faults {
  std::uint64_t seed = 1;  ///< the same seed and the same packets give the same faults
  double loss = 0;
  double duplication = 0;
  double corruption = 0;  ///< flips one bit of a packet
  double reordering = 0;  ///< held back by `reordering_delay`, so later packets arrive first
  Duration reordering_delay = std::chrono::milliseconds(2);
  Duration delay{};  ///< added to every packet; a satellite takes 250 ms
  /// While true, neither packets nor heartbeats arrive. Not owned; may be null.
  const std::atomic<bool>* cut = nullptr;
};

/// A test double. Wraps a medium so that its connections apply `faults` to the packets that they
/// receive; if both sides are wrapped, packets of both directions have faults. Streams are not
/// affected.
///
/// Delays are measured by `clock`. A thread that sleeps on a connection is woken for a delayed
/// packet in real time; with a fake clock, poll again after every step.
std::unique_ptr<Medium> make_faulty(std::unique_ptr<Medium> inner, Faults faults,
                                    const Clock& clock);

}  // namespace gecos::media
