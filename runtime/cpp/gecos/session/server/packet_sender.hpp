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

/// Sends the packets of one session to its client, in order. Packets for which the connection has
/// no room wait here. Thread-safe.
class PacketSender {
 public:
  explicit PacketSender(media::Connection& connection) : connection_(connection) {}

  /// Sends a packet now, or as soon as the connection has room.
  void send(const wire::PacketHeader& header, ByteView body);
  /// Sends `packet` unless it still waits here since it was sent first.
  void send_again(const Bytes& packet);
  /// As `send`, for the reply `header` to a call. A result that the connection cannot carry, or for
  /// which there is no room, is replaced by a failure. `kept`: where the reply is kept; may be
  /// null.
  void reply(const wire::PacketHeader& header, ByteView result, ReplyCache* kept);
  void reply(const wire::PacketHeader& header, const Failure& failure, ReplyCache* kept);
  /// Sends a reply that was sent in another session, whatever waits here; one that the connection
  /// cannot carry is replaced by a failure.
  void reply_again(const wire::PacketHeader& header, ByteView body, ReplyCache* kept);
  /// Sends a packet at once, without waking a client that sleeps. Returns false, without sending
  /// it, when the connection has no room.
  bool send_quietly(const wire::PacketHeader& header, std::size_t size,
                    FunctionRef<void(wire::Encoder&)> encode);
  /// Sends packets that wait, as far as the connection has room.
  void flush();
  /// True when the client does not read its replies: more replies wait than a correct client can
  /// have requested.
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
