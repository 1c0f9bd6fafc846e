#pragma once

#include <cstdint>
#include <memory>

#include "gecos/session/client/context.hpp"

namespace gecos::session {

/// Waits for changes of the broker's list. Reads the stream on which the broker publishes the
/// number of each change, and subscribes again with each new broker. A Lab that is closed ends the
/// wait within 100 ms. Not thread-safe.
class BrokerNews {
 public:
  explicit BrokerNews(std::shared_ptr<Context> lab) : lab_(std::move(lab)) {}

  /// Waits until the broker's list may have changed since the last call of this function, or until
  /// `deadline`. If no broker answers, the call may take up to 2 s longer. Returns whether the list
  /// may have changed: the broker has published a change, or another broker has taken its place.
  /// Returns true at least once a second, because the medium may have lost a sample, and because a
  /// broker of an older version publishes no changes.
  bool wait(TimePoint deadline);

 private:
  enum class Heard : std::uint8_t { News, Nothing };
  Heard subscribe(TimePoint deadline);

  const std::shared_ptr<Context> lab_;
  std::shared_ptr<ClientConnection> broker_;  ///< publishes `revisions_`
  std::shared_ptr<StreamCore> revisions_;     ///< null when the broker publishes no changes
  RawSample sample_;
  static constexpr Duration shortest_pause = std::chrono::milliseconds(20);
  /// The pause between two searches for a broker. Grows to 160 ms, or to 1 s while a broker refuses
  /// this program.
  Duration pause_ = shortest_pause;
};

}  // namespace gecos::session
