#pragma once

#include <atomic>
#include <cstddef>
#include <deque>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/command.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/protocol/receive_window.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Sends the packets of one session to its client, in order. When the connection has no room for a
/// packet, the packet waits in this object. Thread-safe.
class PacketSender {
 public:
  explicit PacketSender(media::Connection& connection) : connection_(connection) {}

  /// Sends a packet now, or as soon as the connection has room.
  void send(const wire::PacketHeader& header, ByteView body);
  /// Sends `packet` again, unless its first copy still waits in this object.
  void send_again(const Bytes& packet);
  /// Like `send`, for a reply to a call. If a result is too large for the connection, or there is
  /// no room for it, sends a failure instead. `kept`: a cache that also keeps the reply; may be
  /// null.
  void reply(const wire::PacketHeader& header, ByteView result, ReplyCache* kept);
  void reply(const wire::PacketHeader& header, const Failure& failure, ReplyCache* kept);
  /// Sends a reply that was sent in another session before, even when many packets wait to be sent
  /// in this session. A reply that is too large for the connection is replaced by a failure.
  void reply_again(const wire::PacketHeader& header, ByteView body, ReplyCache* kept);
  /// Sends a packet at once, without waking a client that sleeps. Does not send it and returns
  /// false when the connection has no room.
  bool send_quietly(const wire::PacketHeader& header, std::size_t size,
                    FunctionRef<void(wire::Encoder&)> encode);
  /// Sends the packets that wait, as many as the connection has room for. Returns whether none
  /// waits any more.
  bool flush();
  /// Returns true when more replies wait than a correct client can have requested. The client then
  /// does not read its replies.
  bool overrun() const { return overrun_.load(std::memory_order_relaxed); }
  /// Runs `use` while no other thread sends over the connection.
  void with_connection(FunctionRef<void(media::Connection&)> use);

 private:
  void write_reply(const wire::PacketHeader& header, ByteView body) GECOS_REQUIRES(mutex_);
  void keep_and_deliver(std::uint64_t counter, ReplyCache* kept) GECOS_REQUIRES(mutex_);
  void deliver(ByteView packet) GECOS_REQUIRES(mutex_);
  std::size_t carried() const { return connection_.capabilities().largest_packet; }

  media::Connection& connection_;
  FutexMutex mutex_;
  Bytes packet_ GECOS_GUARDED_BY(mutex_);               ///< encoding buffer, reused
  std::deque<Bytes> backlog_ GECOS_GUARDED_BY(mutex_);  ///< packets that wait for room
  std::size_t backlog_bytes_ GECOS_GUARDED_BY(mutex_) = 0;
  std::atomic<bool> overrun_{false};  // orders no other memory
};

}  // namespace gecos::session
