#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "gecos/object.hpp"

/// The connection of a proxy, measured while the program runs.
namespace gecos {

/// Returns the state of the connection of `proxy`. Does not wait.
LineState line_state(const Object& proxy);

/// Reports when the connection of a proxy becomes degraded, and when it recovers. It is degraded
/// while its round trip exceeds the smallest `latency` that the interface of the proxy or a member
/// of it demands, with the class SOFT_REALTIME or HARD_REALTIME. A single slow answer is no change:
/// all answers within one second must agree. Keeps the session open. Not thread-safe.
class LineWatch {
 public:
  /// Reports the changes from now on.
  explicit LineWatch(const Object& proxy);

  /// Waits at most `patience` for the next change and returns the state after it; nullopt when
  /// there is none, and at once when the session is lost or closed. When several changes came since
  /// the last call, returns the state after the last of them.
  std::optional<LineState> next(Duration patience);

 private:
  std::shared_ptr<session::ClientSession> session_;
  std::uint64_t changes_;  ///< that were reported
};

}  // namespace gecos
