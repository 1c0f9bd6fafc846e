#pragma once

#include <algorithm>
#include <chrono>

#include "gecos/base/clock.hpp"
#include "gecos/session/protocol/broker_answer.hpp"

namespace gecos::session {

/// The pause before a server asks the broker again: 200 ms. While the broker refuses the server,
/// each pause is twice as long as the previous pause, up to 2 s, so that the server does not fill
/// the audit of the broker. Once the lab file admits the server's user again, the server is
/// registered within about 2 s.
class AskPause {
 public:
  static constexpr Duration shortest = std::chrono::milliseconds(200);
  static constexpr Duration longest = std::chrono::seconds(2);

  Duration after(BrokerAnswer answer) {
    next_ = answer == BrokerAnswer::Refused ? std::min(2 * next_, longest) : shortest;
    return next_;
  }

 private:
  Duration next_ = shortest;
};

}  // namespace gecos::session
