#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "gecos/base/fork_watch.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/lcm/lcm.hpp"
#include "gecos/media/lcm/receiver.hpp"
#include "gecos/media/sealed/network.hpp"

struct _lcm_t;

namespace gecos::media {

/// One UDP port of a multicast group. Sends datagrams through the LCM library, and receives
/// datagrams that LCM has sent. Only port.cpp may use the LCM library.
class LcmPort final : public DatagramPort {
 public:
  static tl::expected<std::unique_ptr<LcmPort>, MediumError> open(const LcmOptions& options,
                                                                  std::uint16_t port);
  ~LcmPort() override;
  LcmPort(const LcmPort&) = delete;
  LcmPort& operator=(const LcmPort&) = delete;

  tl::expected<std::uint64_t, MediumError> subscribe(const std::string& channel,
                                                     Take take) override;
  void unsubscribe(std::uint64_t subscription) override;
  int descriptor() const override { return descriptor_.load(); }
  bool pump(int most = 1024) override;
  bool publish(const std::string& channel, ByteView datagram) override;
  /// Returns whether this process is a forked child of the process that opened this port.
  bool inherited() const { return inherited_.load(std::memory_order_relaxed); }

 private:
  struct Subscription {
    std::uint64_t number = 0;
    Take take;
  };
  LcmPort(_lcm_t* lcm, LcmOptions options, std::uint16_t port);
  /// Must be called in a forked child: makes this port unusable there. Takes no lock, because the
  /// child has only one thread, and a thread of the parent may have held the mutex.
  void abandon() noexcept GECOS_NOT_ANALYSED;

  _lcm_t* const lcm_;
  const LcmOptions options_;
  const std::uint16_t port_;
  std::atomic<int> descriptor_{-1};  // set by the first subscribe()
  Mutex mutex_;  // held while a Subscription is called: one thread receives at a time
  std::optional<LcmReceiver> receiver_ GECOS_GUARDED_BY(mutex_);
  std::multimap<std::string, Subscription, std::less<>> subscriptions_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t last_number_ GECOS_GUARDED_BY(mutex_) = 0;
  std::atomic<bool> inherited_{false};  // true in a forked child
  const ForkWatch fork_watch_;
};

}  // namespace gecos::media
