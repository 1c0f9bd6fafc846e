#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/lcm/lcm.hpp"

namespace gecos::media {

/// An LCM message that arrived in one datagram.
struct LcmMessage {
  std::string_view channel;
  ByteView content;

  /// Returns nullopt for a piece of a larger message, and for a datagram that is not from LCM.
  static std::optional<LcmMessage> read(ByteView datagram);
};

/// Receives on a UDP port of a multicast group. LCM's own receiver runs a thread for each port,
/// which passes every message on through a pipe: two wake-ups for each message. This class is a
/// socket that the waiting thread reads itself: one wake-up. One thread at a time.
class LcmReceiver {
 public:
  /// Fails with a text that tells the user what to do.
  static tl::expected<LcmReceiver, MediumError> open(const LcmOptions& options, std::uint16_t port);

  /// The next message, or nullopt when none has arrived. The message is valid until the next call.
  std::optional<LcmMessage> next();
  /// Readable when next() may return a message.
  int descriptor() const { return socket_.get(); }
  void close() { socket_.reset(); }

 private:
  explicit LcmReceiver(Descriptor socket);

  Descriptor socket_;
  std::unique_ptr<std::byte[]> memory_;
};

/// The commands to run when no multicast route exists: " (no multicast route? run as root: …)".
std::string multicast_advice(const LcmOptions& options);

}  // namespace gecos::media
