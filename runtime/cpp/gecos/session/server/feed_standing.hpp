#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "gecos/access/status.hpp"
#include "gecos/base/ids.hpp"

namespace gecos::session {

/// The right of one session to send samples on inward streams: the epoch under which the samples
/// are admitted, and whether the samples must wait. The object writes these values with its mutex
/// held, whenever a status begins or ends, the session ends, or a heartbeat is awaited. The ports
/// of inward streams read the values for each sample, without the mutex.
class FeedStanding {
 public:
  /// Returns the epoch under which samples of a stream that needs the status `needed` are admitted;
  /// nullopt when none are admitted.
  std::optional<Epoch> epoch(access::Status needed) const {
    const std::uint64_t epoch = epochs_[index(needed)].load(std::memory_order_acquire);
    if (epoch == 0) return std::nullopt;
    return Epoch{epoch};
  }
  void set(access::Status needed, std::optional<Epoch> epoch) {
    epochs_[index(needed)].store(epoch ? number(*epoch) : 0, std::memory_order_release);
  }
  /// From now on no samples are admitted.
  void clear() {
    for (auto& epoch : epochs_) epoch.store(0, std::memory_order_release);
  }
  /// True while the samples and calls of the session must wait for a heartbeat of the client.
  bool unheard() const { return unheard_.load(std::memory_order_acquire); }
  void set_unheard(bool unheard) { unheard_.store(unheard, std::memory_order_release); }

 private:
  static constexpr std::size_t index(access::Status status) {
    return static_cast<std::size_t>(status);
  }
  // The value 0 is no epoch: it means that no samples are admitted. Each atomic publishes
  // only itself, to the ports of inward streams.
  std::array<std::atomic<std::uint64_t>, 3> epochs_{};
  std::atomic<bool> unheard_{false};
};

}  // namespace gecos::session
