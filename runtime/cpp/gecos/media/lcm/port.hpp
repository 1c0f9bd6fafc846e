#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gecos/media/forked.hpp"
#include "gecos/media/lcm.hpp"

struct _lcm_t;

namespace gecos::media {

/// One UDP port of a multicast group, through LCM. Defined in lcm.cpp, the only file that knows LCM.
class LcmPort {
 public:
  using Take = std::function<void(ByteView datagram)>;

  static tl::expected<std::unique_ptr<LcmPort>, MediumError> open(const LcmOptions& options,
                                                                  std::uint16_t port);
  ~LcmPort();
  LcmPort(const LcmPort&) = delete;
  LcmPort& operator=(const LcmPort&) = delete;

  /// From now on datagrams of `channel` are given to `take`, by whoever calls pump(). Not beside pump().
  tl::expected<void, MediumError> subscribe(const std::string& channel, Take take);
  /// Readable when pump() has something to do; -1 before the first subscription.
  int descriptor() const { return descriptor_; }
  /// Takes what has arrived, never blocks; True: there may be more. Any thread; not from a `take`.
  bool pump();
  /// Sends a datagram. False when the kernel refused it. Any thread.
  bool publish(const std::string& channel, ByteView datagram);

 private:
  struct Subscription;
  LcmPort(_lcm_t* lcm, std::uint16_t port, std::string advice);
  void close_on_exec();

  _lcm_t* const lcm_;
  const std::uint16_t port_;
  const std::string advice_;  // when it cannot receive
  int descriptor_ = -1;
  int receiving_socket_ = -1;          // LCM's own
  std::mutex mutex_;                   // lcm_handle runs once at a time
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::atomic<bool> inherited_{false};  // in a forked child LCM's thread does not exist
  const ForkWatch fork_watch_;
};

}  // namespace gecos::media
