#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>

#include "gecos/access/lease_table.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/protocol/call_table.hpp"
#include "gecos/session/protocol/peer_liveness.hpp"
#include "gecos/session/protocol/receive_window.hpp"
#include "gecos/session/server/intake.hpp"
#include "gecos/session/server/server_call.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Server side of one client's session with one object.
///
/// Only the thread that polls the server's links receives; sending takes a mutex of its own. The
/// comments below say what guards each member.
class ServerSession {
 public:
  ServerSession(std::unique_ptr<media::Link> link, std::shared_ptr<ObjectHost> object);
  ~ServerSession();
  ServerSession(const ServerSession&) = delete;
  ServerSession& operator=(const ServerSession&) = delete;

  media::Link& link() { return *link_; }
  const std::shared_ptr<ObjectHost>& object() const { return object_; }
  bool repeats() const { return repeats_; }

  /// Sets id and caller when the session is opened; both are constant after that.
  void greet(SessionId id, Caller caller) { id_ = id, caller_ = std::move(caller); }
  SessionId id() const { return id_; }
  bool greeted() const { return id_ != SessionId{}; }
  const Caller& caller() const { return caller_; }
  access::Client client() const {
    return {caller_.user, caller_.host, caller_.program, caller_.pid};
  }

  // With the object's mutex held.
  void reply(std::uint64_t counter, const Failure& failure);
  void reply(std::uint64_t counter, ByteView result, Epoch epoch = {});
  /// Replies with the answer that the call got in another session.
  void reply_as(std::uint64_t counter, const wire::PacketView& before);
  /// Sends the latest progress, or drops it when there is no room. Returns true when it was sent.
  bool report(const ServerCall& call, Detail detail, std::size_t position);

  // Any thread.
  /// Sends now, or as soon as the client has room; so do the replies above. Order is kept.
  void send(wire::PacketHeader header, ByteView body);
  void send_again(const Bytes& packet);
  void flush();
  /// True when the client does not take its answers: more of them wait than a correct client can
  /// have asked for.
  bool overrun() const { return overrun_.load(std::memory_order_relaxed); }
  tl::expected<std::uint32_t, std::string> share(const StreamDescription& stream);
  void unshare(std::uint32_t id);

  // The poller.
  bool active = true;
  unsigned quiet_looks = 0;  ///< 0: a packet came since the last `retire_idle`
  TimePoint last_heard{};

  std::atomic<bool> gone{false};  // publishes nothing but itself: the poller forgets the session

  // Guarded by the object's mutex.
  CallTable<ServerCall> calls;
  Intake intake;
  /// Replies over a medium that loses packets, and replies made after the link is gone: the client
  /// may ask for them again, then in another session.
  const std::shared_ptr<ReplyCache> replies = std::make_shared<ReplyCache>();
  std::map<FunctionCode, std::uint32_t> subscriptions;  ///< stream and the id it is shared under
  /// The epoch since which this session has held a status; its own stops renew the status.
  std::uint64_t held_from = std::numeric_limits<std::uint64_t>::max();
  /// The highest counter marked as started, by lane (start_words.hpp).
  std::array<std::uint64_t, media::shared_word_count> marked{};
  std::size_t commands = 0;    ///< actor commands that have not ended
  std::size_t unreturned = 0;  ///< calls that wait, or whose handler has not answered and returned
  bool left = false;           ///< said goodbye
  bool closed = false;         ///< its link is gone
  bool parted_in_order = false;  ///< its link is gone, and its calls still run
  PeerLiveness liveness;
  /// This process was suspended, or the client is silent: no call of the session starts before the
  /// client's next heartbeat.
  bool awaited = false;
  std::uint64_t heartbeats_before = 0;  ///< when the wait began: only a later one ends it

 private:
  void deliver(ByteView packet) GECOS_REQUIRES(send_mutex_);

  const std::unique_ptr<media::Link> link_;
  const std::shared_ptr<ObjectHost> object_;
  const bool repeats_;
  SessionId id_{};
  Caller caller_;

  FutexMutex send_mutex_;
  Bytes packet_ GECOS_GUARDED_BY(send_mutex_);               ///< reused
  std::deque<Bytes> backlog_ GECOS_GUARDED_BY(send_mutex_);  ///< packets that found no room
  std::size_t backlog_bytes_ GECOS_GUARDED_BY(send_mutex_) = 0;
  std::atomic<bool> overrun_{false};  // publishes nothing but itself
};

}  // namespace gecos::session
