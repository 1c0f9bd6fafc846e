#pragma once

#include <cstdint>

#include "gecos/base/bytes.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::session {

/// The way in which a session ends, as its client sees it. It decides the failure of the calls that
/// have no reply: see Withdrawal.
enum class Ending : std::uint8_t {
  Died,    ///< the medium reported that the server's process ended
  Closed,  ///< the server closed the session or its connection
  Silent,  ///< the server sent no heartbeats or no answers for too long; it may still run
  Broken,  ///< the server, or the memory shared with it, violated the rules of the medium
  ByUs,    ///< this program closed the session
};

/// Notified by the reading thread when the server or the medium ends the session.
class EndListener {
 public:
  /// The server said goodbye. `body`: the body of its Goodbye packet, which contains a reason
  /// (text_of).
  virtual void on_goodbye(ByteView body) = 0;
  /// The connection is lost, and all packets that were sent before the loss were read. `loss` is
  /// not None.
  virtual void on_loss(media::Loss loss) = 0;

 protected:
  ~EndListener() = default;
};

}  // namespace gecos::session
