#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "gecos/crypto/transport.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/network.hpp"

namespace gecos::media {

/// Where one end of a link sends: seals and publishes. Any thread.
class SealedSender {
 public:
  /// What is sent before the channel is open waits for it, up to these; more is lost, as on a
  /// network.
  static constexpr std::size_t most_held = 64;
  static constexpr std::size_t most_bytes_held = 1024 * 1024;

  SealedSender(std::shared_ptr<DatagramPort> port, std::string channel, std::uint64_t client,
               std::uint16_t reply_port);

  /// From now on `sealer` seals; what was held goes out. Once.
  void open(crypto::Sealer sealer);
  bool is_open();
  /// Seals head and body in `memory` and sends them; holds packets while it is not open, and drops
  /// everything else. False when the kernel refused it.
  bool send(InnerHeader what, ByteView head, ByteView body, Bytes& memory);
  /// Sends what no handshake has sealed, with the same header.
  bool send_bare(DatagramKind kind, ByteView frame);
  /// The header of such a datagram, which the handshake is bound to.
  std::array<std::byte, DatagramHeader::bytes> header(DatagramKind kind) const;
  /// With every beat: goes over to the next key when it is due.
  void on_tick(TimePoint now);

 private:
  void write(InnerHeader what, ByteView head, ByteView body, Bytes& memory) const;
  void seal(Bytes& datagram);

  const std::shared_ptr<DatagramPort> port_;
  const std::string channel_;
  const std::uint64_t client_;
  const std::uint16_t reply_port_;
  std::mutex mutex_;  // guards what follows
  std::optional<crypto::Sealer> sealer_;
  std::deque<Bytes> held_;
  std::size_t bytes_held_ = 0;
};

}  // namespace gecos::media
