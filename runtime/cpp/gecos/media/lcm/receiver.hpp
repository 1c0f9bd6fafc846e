#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/lcm/lcm.hpp"

namespace gecos::media {

/// A message of LCM that came in one datagram.
struct LcmMessage {
  std::string_view channel;
  ByteView content;

  /// Returns nullopt for a piece of a larger message, and for a datagram that is not LCM's.
  static std::optional<LcmMessage> read(ByteView datagram);
};

/// Receives on a UDP port of a multicast group. LCM's own receiver runs a thread for each port,
/// which passes every message on through a pipe: two wake-ups where one will do. This one is a
/// socket, read by the thread that waits for it. One thread at a time.
class LcmReceiver {
 public:
  /// Fails with a text that says what to do.
  static tl::expected<LcmReceiver, MediumError> open(const LcmOptions& options, std::uint16_t port);

  /// The next message, if one is there: it lies in memory of ours until the next call.
  std::optional<LcmMessage> next();
  /// Readable when next() may give something.
  int descriptor() const { return socket_.get(); }
  void close() { socket_.reset(); }

 private:
  explicit LcmReceiver(Descriptor socket);

  Descriptor socket_;
  std::unique_ptr<std::byte[]> memory_;
};

/// What to run where multicast leads nowhere: " (no multicast route? run as root: …)".
std::string multicast_advice(const LcmOptions& options);

}  // namespace gecos::media
