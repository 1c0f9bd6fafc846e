#pragma once

#include <cstdint>

#include "gecos/base/clock.hpp"
#include "gecos/base/running_core.hpp"

namespace gecos::media {

/// What an end of a link publishes so that the other end can choose how to wait (waiting.hpp). A
/// wrong value costs time and nothing else.
struct Whereabouts {
  std::int32_t core = unknown_core;  ///< from which it last polled the link
  bool asleep = false;               ///< it sleeps until it is notified
  TimePoint rang_at{};               ///< when it last notified this end, by the steady clock
};

/// The core under a thread that waits; tests have cores of their own.
class Core {
 public:
  virtual ~Core() = default;
  virtual std::int32_t number() const = 0;
  /// Lets another ready thread run on the core first.
  virtual void yield() const = 0;

  /// The core that the calling thread runs on.
  static const Core& real();
};

}  // namespace gecos::media
