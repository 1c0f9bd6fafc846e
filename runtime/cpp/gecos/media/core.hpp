#pragma once

#include <cstdint>

#include "gecos/base/clock.hpp"
#include "gecos/base/running_core.hpp"

namespace gecos::media {

/// What an end of a link says for the other end's waiting (waiting.hpp). A wrong statement costs
/// time and nothing else.
struct Whereabouts {
  std::int32_t core = unknown_core;  ///< from which it looked at the link last
  bool asleep = false;               ///< it sleeps until it is rung
  TimePoint rang_at{};               ///< when it rang this end last, by the steady clock
};

/// The core under a thread that waits; tests have cores of their own.
class Core {
 public:
  virtual ~Core() = default;
  virtual std::int32_t number() const = 0;
  /// Lets another thread that is ready have it first.
  virtual void yield() const = 0;

  /// The one that the calling thread runs on.
  static const Core& real();
};

}  // namespace gecos::media
