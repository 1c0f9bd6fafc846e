#pragma once

#include <deque>
#include <memory>

#include "gecos/media/shm/control.hpp"
#include "gecos/media/shm/memory.hpp"

namespace gecos::media::shm {

/// Sends control messages over a socket, in order. Messages for which the socket has no room wait
/// in this queue. Not thread-safe.
class ControlQueue {
 public:
  struct Unsent {
    ControlMessage message;
    std::shared_ptr<SealedMemory> memory;  ///< owns the descriptor until it is sent; may be null
  };
  /// The caller owns `socket`. After the caller has closed `socket`, it must not call any function
  /// of this object.
  explicit ControlQueue(int socket) : socket_(socket) {}

  /// Sends a message now or in a later call of `flush`. Returns false and drops the message when
  /// too many messages wait.
  bool send(Unsent unsent);
  /// Sends the waiting messages, as far as the socket has room.
  void flush();

 private:
  static constexpr std::size_t most_unsent = 256;

  const int socket_;
  std::deque<Unsent> unsent_;
};

}  // namespace gecos::media::shm
