#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "gecos/media/forked.hpp"
#include "gecos/media/lcm.hpp"
#include "gecos/media/lcm/receiver.hpp"

struct _lcm_t;

namespace gecos::media {

/// One UDP port of a multicast group: sends through LCM, and hears what LCM sends. Defined in
/// lcm.cpp, the only file that knows LCM.
class LcmPort {
 public:
  using Take = std::function<void(ByteView datagram)>;

  static tl::expected<std::unique_ptr<LcmPort>, MediumError> open(const LcmOptions& options,
                                                                  std::uint16_t port);
  ~LcmPort();
  LcmPort(const LcmPort&) = delete;
  LcmPort& operator=(const LcmPort&) = delete;

  /// From now on datagrams of `channel` are given to `take`, by whoever calls pump(). Not beside
  /// pump().
  tl::expected<void, MediumError> subscribe(const std::string& channel, Take take);
  /// Readable when pump() has something to do; -1 before the first subscription.
  int descriptor() const { return receiver_ ? receiver_->descriptor() : -1; }
  /// Takes what has arrived, at most so many datagrams, never blocks; True: there may be more. Any
  /// thread; not from a `take`.
  bool pump(int most = 1024);
  /// Sends a datagram. False when the kernel refused it. Any thread.
  bool publish(const std::string& channel, ByteView datagram);

 private:
  struct Subscription {
    std::string channel;
    Take take;
  };
  LcmPort(_lcm_t* lcm, LcmOptions options, std::uint16_t port);

  _lcm_t* const lcm_;
  const LcmOptions options_;
  const std::uint16_t port_;
  std::optional<LcmReceiver> receiver_;
  std::vector<Subscription> subscriptions_;
  std::mutex mutex_;                    // one receives at a time
  std::atomic<bool> inherited_{false};  // this is a forked child
  const ForkWatch fork_watch_;
};

}  // namespace gecos::media
