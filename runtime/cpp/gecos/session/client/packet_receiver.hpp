#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "gecos/session/client/call_sender.hpp"
#include "gecos/session/client/ending.hpp"
#include "gecos/session/client/lease_state.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Handles the packets that the server of one session sends. Only the thread that reads the
/// connection may call `take`; any thread may call the other functions.
class PacketReceiver {
 public:
  /// `end` is notified when the server says goodbye.
  PacketReceiver(SessionId id, const media::Capabilities& medium, CallSender& calls,
                 LeaseState& leases, EndListener& end)
      : id_(id), reliable_(medium.reliable), calls_(calls), leases_(leases), end_(end) {}

  /// Handles one packet. Returns the command that the packet ended, or null. The caller must notify
  /// the threads that wait for that command.
  std::shared_ptr<PendingCommand> take(ByteView bytes);

  /// Returns the number of packets of the session received so far.
  std::uint64_t heard() const { return heard_.load(std::memory_order_relaxed); }
  /// Returns true when a reply was lost although the medium is reliable. The connection is then
  /// broken.
  bool answer_lost() const { return answer_lost_.load(); }
  /// Returns true when the server has said goodbye, or has acknowledged the goodbye of this
  /// program.
  bool goodbye_heard() const { return goodbye_heard_.load(); }

 private:
  std::shared_ptr<PendingCommand> take_reply(const wire::PacketView& packet);
  void take_progress(const wire::PacketView& packet);

  const SessionId id_;
  const bool reliable_;  ///< the medium loses no packets
  CallSender& calls_;
  LeaseState& leases_;
  EndListener& end_;
  std::atomic<std::uint64_t> heard_{0};     // orders no other memory
  std::atomic<bool> answer_lost_{false};    // orders no other memory
  std::atomic<bool> goodbye_heard_{false};  // orders no other memory
};

}  // namespace gecos::session
