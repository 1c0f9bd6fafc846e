#include "gecos/media/sealed/network.hpp"

#include <array>
#include <charconv>
#include <cstdlib>
#include <map>
#include <memory>
#include <string_view>
#include <utility>

#include "gecos/base/mutex.hpp"
#include "gecos/media/lcm/lcm.hpp"
#include "gecos/media/lcm/port.hpp"
#include "gecos/media/registration.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/stream.hpp"

namespace gecos::media {
namespace {

/// The number of ports on which the connections of one process receive. If the process has few
/// connections, each connection has a port of its own, and a packet wakes only the thread that
/// waits for this packet. If the process has many connections, they share ports, so that the
/// process needs neither a socket nor a system call for each connection.
constexpr std::size_t reply_ports = 8;

/// Opens the UDP ports of a multicast group.
class LcmNetwork final : public DatagramNetwork, public std::enable_shared_from_this<LcmNetwork> {
 public:
  explicit LcmNetwork(LcmOptions options) : options_(std::move(options)) {}

  const Capabilities& capabilities() const override { return lcm_capabilities; }
  const std::string& name() const override { return options_.group; }
  std::size_t largest_datagram() const override { return largest_lcm_packet + sample_overhead; }

  tl::expected<std::unique_ptr<DatagramPort>, MediumError> open(std::uint16_t port) const override {
    return LcmPort::open(options_, port);
  }

  tl::expected<std::shared_ptr<DatagramPort>, MediumError> shared(
      std::uint16_t port) const override {
    const MutexLock lock(mutex_);
    std::weak_ptr<LcmPort>& known = ports_[port];
    if (auto open = known.lock(); open != nullptr && !open->inherited()) return open;
    std::erase_if(ports_,
                  [&](const auto& one) { return one.first != port && one.second.expired(); });
    auto opened = LcmPort::open(options_, port);
    if (!opened) return tl::unexpected(std::move(opened.error()));
    std::shared_ptr<LcmPort> shared(std::move(*opened));
    known = shared;
    return shared;
  }

  std::uint16_t draw_reply_port() const override {
    const MutexLock lock(mutex_);
    std::uint16_t& port = reply_ports_.at(next_reply_port_++ % reply_ports);
    const auto known = ports_.find(port);
    // The number of a port that is no longer open is not used again: the network may still carry
    // packets for it.
    if (known == ports_.end() || known->second.expired()) port = draw_port();
    return port;
  }

  std::shared_ptr<const DatagramNetwork> named(const std::string& name) const override {
    if (name == options_.group) return shared_from_this();
    LcmOptions there = options_;
    there.group = name;
    return std::make_shared<const LcmNetwork>(std::move(there));
  }

  std::string advice() const override {
    return options_.ttl == 0
               ? "; GECOS_LCM_TTL is 0, so packets of this program stay on this host: to reach "
                 "another host, each program needs a GECOS_LCM_TTL of 1 or more"
               : "; a server on another host is reached only if its own GECOS_LCM_TTL "
                 "is 1 or more";
  }

 private:
  const LcmOptions options_;
  mutable Mutex mutex_;
  /// The ports that connections may still use, by their port numbers.
  mutable std::map<std::uint16_t, std::weak_ptr<LcmPort>> ports_ GECOS_GUARDED_BY(mutex_);
  mutable std::array<std::uint16_t, reply_ports> reply_ports_ GECOS_GUARDED_BY(mutex_){};
  mutable std::size_t next_reply_port_ GECOS_GUARDED_BY(mutex_) = 0;
};

/// Opens the medium with the TTL in the environment variable GECOS_LCM_TTL.
tl::expected<std::unique_ptr<Medium>, MediumError> open_lcm() {
  LcmOptions options;
  if (const char* const set = std::getenv("GECOS_LCM_TTL"); set != nullptr && *set != '\0') {
    const std::string_view text(set);
    const auto [end, failed] = std::from_chars(text.begin(), text.end(), options.ttl);
    if (failed != std::errc{} || end != text.end() || options.ttl < 0 || options.ttl > 255) {
      return tl::unexpected(
          MediumError{"lcm: GECOS_LCM_TTL is '" + std::string(text) +
                      "'; it says how many routers a packet may pass, 0 (this host alone) to 255"});
    }
  }
  return make_lcm(options);
}

}  // namespace

std::unique_ptr<Medium> make_lcm(LcmOptions options) {
  SealedOptions sealed{.well_known_port = options.well_known_port,
                       .open_port = options.open_port,
                       .key_directory = options.key_directory,
                       .rekey = options.rekey,
                       .clock = options.clock};
  sealed.network = std::make_shared<const LcmNetwork>(std::move(options));
  return make_sealed(std::move(sealed));
}

const Registration lcm_registration{lcm_capabilities, open_lcm};

}  // namespace gecos::media
