#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/lcm/lcm.hpp"

namespace gecos::media {

/// An LCM message that fits in one datagram.
struct LcmMessage {
  std::string_view channel;
  ByteView content;

  /// Reads a message from a datagram. Returns nullopt for a piece of a larger message, and for a
  /// datagram that is not from LCM.
  static std::optional<LcmMessage> read(ByteView datagram);
};

/// Receives LCM messages on a UDP port of a multicast group. The receiver of the LCM library has a
/// thread for each port, which passes every message on through a pipe, so that each message needs
/// two wake-ups. With this class, the waiting thread reads the socket itself, so that a message
/// needs only one wake-up. Only one thread at a time may use a receiver.
class LcmReceiver {
 public:
  /// Opens the port. On failure, the error text tells the user what to do.
  static tl::expected<LcmReceiver, MediumError> open(const LcmOptions& options, std::uint16_t port);

  /// Returns the next message, or nullopt when no message has arrived. The message is valid until
  /// the next call.
  std::optional<LcmMessage> next();
  /// Returns the file descriptor that is readable when next() may return a message.
  int descriptor() const { return socket_.get(); }
  void close() { socket_.reset(); }

 private:
  explicit LcmReceiver(Descriptor socket);

  Descriptor socket_;
  std::unique_ptr<std::byte[]> memory_;
};

/// Returns a hint for an error text: the commands to run if the cause is a missing multicast route.
/// The hint is a text such as " (no multicast route? run as root: …)".
std::string multicast_advice(const LcmOptions& options);

}  // namespace gecos::media
