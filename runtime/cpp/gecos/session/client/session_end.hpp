#pragma once

#include <atomic>
#include <string>

#include "gecos/session/client/call_sender.hpp"
#include "gecos/session/client/connection_reader.hpp"
#include "gecos/session/client/ending.hpp"
#include "gecos/session/client/packet_receiver.hpp"
#include "gecos/session/client/session_failover.hpp"
#include "gecos/session/protocol/handshake.hpp"

namespace gecos::session {

/// Ends one session. A session ends because the program closes it, because its server or connection
/// is lost, or because its server no longer answers. Thread-safe.
class SessionEnd final : public EndListener {
 public:
  SessionEnd(media::Connection& connection, const Welcome& welcome, CallSender& calls,
             PacketReceiver& receiver, ConnectionReader& reader, SessionFailover& failover);

  /// True when this program has closed the session or is closing it.
  bool closed() const { return closed_.load(std::memory_order_relaxed); }
  /// Ends the session in order. Waits at most `patience` for the server's acknowledgement. If the
  /// acknowledgement arrives, the commands that were sent still run. Otherwise the calls are
  /// withdrawn: commands that have not started never start, unless the withdrawal does not reach
  /// the server.
  void close(Duration patience);
  /// Ends the session for the reason `text`. Each command that has no reply ends, or is sent again
  /// in another session. Does nothing when the session is lost already.
  void lose(Ending how, const std::string& text);

  void on_goodbye(std::int8_t flags, ByteView body) override;
  void on_loss(media::Loss loss) override;

 private:
  media::Connection& connection_;
  const Welcome& welcome_;
  CallSender& calls_;
  PacketReceiver& receiver_;
  ConnectionReader& reader_;
  SessionFailover& failover_;
  const bool reliable_;              ///< the medium loses no packets
  std::atomic<bool> closed_{false};  // orders no other memory
  /// True while this program closes the session and waits for the server's goodbye. Orders no other
  /// memory.
  std::atomic<bool> awaits_goodbye_{false};
};

}  // namespace gecos::session
