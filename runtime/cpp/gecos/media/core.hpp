#pragma once

#include <cstdint>

#include "gecos/base/clock.hpp"
#include "gecos/base/running_core.hpp"

namespace gecos::media {

/// The values that an end of a connection publishes so that the other end can choose how to wait
/// (waiting.hpp). A wrong value only makes communication slower.
struct Whereabouts {
  std::int32_t core = unknown_core;  ///< core from which this end last polled the connection
  bool asleep = false;               ///< this end sleeps until it is notified
  TimePoint rang_at{};  ///< when this end last notified the other end, by the steady clock
};

/// Tells on which CPU core the calling thread runs. This class is an interface, so that tests can
/// replace it.
class Core {
 public:
  virtual ~Core() = default;
  virtual std::int32_t number() const = 0;
  /// Yields this core to another thread that is ready to run, if there is one.
  virtual void yield() const = 0;

  /// Returns the implementation of Core that asks the kernel.
  static const Core& real();
};

}  // namespace gecos::media
