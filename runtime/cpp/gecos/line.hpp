#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "gecos/object.hpp"

/// The connection of a proxy, measured while the program runs.
namespace gecos {

/// Returns the state of the connection of `proxy`. Does not wait.
LineState line_state(const Object& proxy);

/// Reports when the connection of a proxy becomes degraded, and when it recovers. A connection is
/// degraded while its round trip exceeds the smallest `latency` that the `@qos` of the interface or
/// of a member demands, with the class SOFT_REALTIME or HARD_REALTIME. A single slow answer is not
/// reported: all answers within one second must be slow, or all fast. With
/// `on_degraded="failover"`, also reports that the proxy has moved to another medium, or why it
/// stays. A LineWatch keeps the session open. Not thread-safe.
class LineWatch {
 public:
  /// Reports the changes from now on.
  explicit LineWatch(const Object& proxy);

  /// Waits at most `patience` for the next change, and returns the state after the change. Returns
  /// nullopt when there is no change, and at once when the session is lost or closed. After several
  /// changes since the last call, returns the state after the last change.
  std::optional<LineState> next(Duration patience);

 private:
  std::shared_ptr<session::ClientSession> session_;
  std::uint64_t changes_;  ///< number of reported changes
};

}  // namespace gecos
