#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "gecos/base/mutex.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/network.hpp"

namespace gecos::media {

/// Returns a datagram of `client` that carries one message, encrypted by `sealer`.
Bytes sealed_datagram(crypto::Sealer& sealer, std::uint64_t client, InnerHeader what,
                      ByteView body);

/// Encrypts and sends the messages of one end of a connection. Any thread may use a SealedSender.
class SealedSender {
 public:
  /// The limits for packets that are sent before the channel is open. Such packets are held until
  /// the channel opens. A packet that would exceed a limit is dropped, as if the network had lost
  /// it.
  static constexpr std::size_t most_held = 64;
  static constexpr std::size_t most_bytes_held = 1024 * 1024;

  SealedSender(std::shared_ptr<DatagramPort> port, std::string channel, std::uint64_t client,
               std::uint16_t reply_port);

  /// Sets the sealer and sends the packets that were held. Must be called at most once.
  void open(crypto::Sealer sealer);
  bool is_open();
  /// Encrypts `head` and `body` as one message in `memory`, and sends the message. While the
  /// channel is not open, holds packets and drops other messages. Returns false when the kernel
  /// refused the datagram.
  bool send(InnerHeader what, ByteView head, ByteView body, Bytes& memory);
  /// Sends a datagram of the handshake, which is not encrypted. The datagram consists of
  /// header(kind) and `frame`.
  bool send_bare(DatagramKind kind, ByteView frame);
  /// Returns the header of a handshake datagram. The handshake authenticates this header.
  std::array<std::byte, DatagramHeader::bytes> header(DatagramKind kind) const;
  /// Changes to the next key when the present key has been used for long enough. Must be called
  /// with every heartbeat.
  void on_tick(TimePoint now);

 private:
  const std::shared_ptr<DatagramPort> port_;
  const std::string channel_;
  const std::uint64_t client_;
  const std::uint16_t reply_port_;
  Mutex mutex_;
  std::optional<crypto::Sealer> sealer_ GECOS_GUARDED_BY(mutex_);
  std::deque<Bytes> held_ GECOS_GUARDED_BY(mutex_);
  std::size_t bytes_held_ GECOS_GUARDED_BY(mutex_) = 0;
};

}  // namespace gecos::media
