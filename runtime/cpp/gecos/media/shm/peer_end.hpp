#pragma once

#include <atomic>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/buffers/ring.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/shm/memory.hpp"
#include "gecos/media/shm/shm.hpp"

namespace gecos::media::shm {

/// Wakes the other end of a connection. This object may live longer than the connection, because a
/// stream may still use it to wake its reader.
class PeerEnd final : public Sleeper {
 public:
  explicit PeerEnd(Descriptor socket) : socket_(std::move(socket)) {}

  int socket() const { return socket_.get(); }
  /// Sets the memory and the eventfd of the peer. If there is no eventfd, the socket is used to
  /// wake the peer.
  void know(Mapping mapping, Descriptor event);
  bool known() const { return known_.load(std::memory_order_acquire); }
  /// Returns the ring in the peer's memory. @pre known() is true
  RingMemory ring() const { return RingMemory::at(mapping_.data(), usual_slot_count); }
  void wake();
  void wake_if_asleep() override;
  /// Shuts the socket down. The peer then sees the end of the connection even if a stream still
  /// refers to this object.
  void hang_up();
  void forget();

 private:
  Descriptor socket_;
  Descriptor event_;
  Mapping mapping_;
  std::atomic<bool> known_{false};  // publishes mapping_ and event_
};

}  // namespace gecos::media::shm
