#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "gecos/media/lcm/lcm.hpp"
#include "gecos/media/lcm/receiver.hpp"
#include "gecos/media/parts/fork_watch.hpp"
#include "gecos/media/sealed/network.hpp"

struct _lcm_t;

namespace gecos::media {

/// One UDP port of a multicast group: sends through LCM, and receives the datagrams that LCM sends.
/// Only port.cpp may use the LCM library.
class LcmPort final : public DatagramPort {
 public:
  static tl::expected<std::unique_ptr<LcmPort>, MediumError> open(const LcmOptions& options,
                                                                  std::uint16_t port);
  ~LcmPort() override;
  LcmPort(const LcmPort&) = delete;
  LcmPort& operator=(const LcmPort&) = delete;

  tl::expected<void, MediumError> subscribe(const std::string& channel, Take take) override;
  int descriptor() const override { return receiver_ ? receiver_->descriptor() : -1; }
  bool pump(int most = 1024) override;
  bool publish(const std::string& channel, ByteView datagram) override;

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
  std::mutex mutex_;                    // one thread receives at a time
  std::atomic<bool> inherited_{false};  // true in a forked child
  const ForkWatch fork_watch_;
};

}  // namespace gecos::media
