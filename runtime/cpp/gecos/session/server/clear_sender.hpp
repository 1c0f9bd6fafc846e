#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string_view>

#include "gecos/base/bytes.hpp"
#include "gecos/base/function_ref.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::session {

/// Sends the samples of one @open_stream in clear, as messages that LCM tools decode. Not
/// thread-safe.
class ClearSender {
 public:
  /// `fingerprint`: the LCM fingerprint of the samples
  explicit ClearSender(std::uint64_t fingerprint) : fingerprint_(fingerprint) {}

  /// Sends later samples on `channel`, in place of an earlier channel of the same medium.
  void add(std::string_view medium, std::unique_ptr<media::OpenChannel> channel);
  /// Allows or forbids sending; at first, sending is allowed. Returns whether this call has changed
  /// that.
  bool allow(bool allowed);
  /// Sends `sample` on all channels. Calls `too_large` for each medium that cannot carry it.
  ///
  /// Each channel sends one UDP datagram (or its fragments) without an answer. The call waits only
  /// while the send buffer of the socket is full, until the network card of this host has sent a
  /// part of the buffer. No reader can make the call wait.
  void send(ByteView sample, FunctionRef<void(std::string_view medium)> too_large);
  /// Drops all channels. After this call, `send` sends nothing.
  void end() { channels_.clear(); }

 private:
  const std::uint64_t fingerprint_;
  bool allowed_ = true;
  /// The channel of each medium.
  std::map<std::string_view, std::unique_ptr<media::OpenChannel>> channels_;
  Bytes message_;
};

}  // namespace gecos::session
