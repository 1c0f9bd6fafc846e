#pragma once

#include <cstdint>
#include <string>

#include "gecos/base/bytes.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::session {

/// The way in which a session ended, as its client sees it. The ending decides how the calls
/// without a reply fail: see Withdrawal.
enum class Ending : std::uint8_t {
  Died,     ///< the medium reported that the server's process ended
  Closed,   ///< the server closed the session or its connection
  Revoked,  ///< the server closed the session, because it no longer admits this user
  Silent,   ///< the server sent no heartbeats or no answers for too long; it may still run
  Broken,   ///< the server, or the memory shared with it, violated the rules of the medium
  ByUs,     ///< this program closed the session
};

/// True if the server itself ended the session.
inline bool closed_by_server(Ending how) { return how == Ending::Closed || how == Ending::Revoked; }

/// How and why a session ended.
struct SessionLoss {
  Ending how = Ending::ByUs;
  std::string text{};
};

/// Notified by the reading thread when the server or the medium ends the session.
class EndListener {
 public:
  /// Called when the server has said goodbye. `flags` and `body` are those of the Goodbye packet.
  /// `flags` may be `revokes`; `body` contains the reason (text_of).
  virtual void on_goodbye(std::int8_t flags, ByteView body) = 0;
  /// Called when the connection is lost and all packets that were sent before the loss were read.
  /// `loss` is not None.
  virtual void on_loss(media::Loss loss) = 0;

 protected:
  ~EndListener() = default;
};

}  // namespace gecos::session
