// What hears and says anything on lcm, and settings with keys of a test's own.
#pragma once

#include "gecos/media/lcm/lcm.hpp"
#include "gecos/media/lcm/port.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "media_under_test.hpp"

namespace gecos::media {

/// Hears all that is sent to a channel of a port.
class Recorder {
 public:
  Recorder(std::uint16_t port, const std::string& channel)
      : port_(LcmPort::open({}, port).value()) {
    const auto heard = port_->subscribe(channel, [this](ByteView datagram) {
      all_.emplace_back(datagram.begin(), datagram.end());
    });
    if (!heard) throw std::runtime_error(heard.error().text);
  }
  /// What came so far, at least one of `kind`.
  std::vector<Bytes> of(DatagramKind kind) {
    for (;;) {
      look();
      std::vector<Bytes> found;
      for (const Bytes& datagram : all_) {
        const auto header = DatagramHeader::read(datagram);
        if (header && header->kind == kind) found.push_back(datagram);
      }
      if (!found.empty()) return found;
      const std::array<int, 1> one{port_->descriptor()};
      if (sleep_on(one, too_late()) == Wake::TimedOut) return found;
    }
  }
  void look() {
    while (port_->pump()) continue;
  }
  const std::vector<Bytes>& all() const { return all_; }
  const LcmPort& port() const { return *port_; }
  void say(const std::string& channel, ByteView datagram) { port_->publish(channel, datagram); }

 private:
  std::vector<Bytes> all_;
  const std::unique_ptr<LcmPort> port_;
};

inline LcmOptions with_keys(const ScratchDirectory& directory, const std::string& whose = "keys") {
  LcmOptions options;
  options.well_known_port = port_of_this_process();
  options.key_directory = directory.path() + "/" + whose;
  return options;
}

}  // namespace gecos::media
