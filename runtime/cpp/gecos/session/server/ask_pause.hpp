#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Whether the broker has refused to let a server connect.
enum class Asked : std::uint8_t { NotRefused, Refused };

/// The pause before a server asks the broker again: 200 ms. While the broker refuses the server,
/// each pause is twice as long as the one before, up to 2 s, so that the server does not fill the
/// audit of the broker, and is registered within about 2 s when an edit admits its user again.
class AskPause {
 public:
  static constexpr Duration shortest = std::chrono::milliseconds(200);
  static constexpr Duration longest = std::chrono::seconds(2);

  /// Returns the pause after an answer of the broker, or after no answer.
  Duration after(Asked asked) {
    next_ = asked == Asked::Refused ? std::min(2 * next_, longest) : shortest;
    return next_;
  }

 private:
  Duration next_ = shortest;
};

}  // namespace gecos::session
