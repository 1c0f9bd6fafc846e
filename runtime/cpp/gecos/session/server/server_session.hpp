#pragma once

#include <array>
#include <atomic>
#include <limits>
#include <map>
#include <memory>

#include "gecos/access/lease_table.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/protocol/call_table.hpp"
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/session/protocol/peer_liveness.hpp"
#include "gecos/session/protocol/receive_window.hpp"
#include "gecos/session/server/blend_chain.hpp"
#include "gecos/session/server/call_statistics.hpp"
#include "gecos/session/server/feed_standing.hpp"
#include "gecos/session/server/heartbeat_looks.hpp"
#include "gecos/session/server/intake.hpp"
#include "gecos/session/server/packet_sender.hpp"
#include "gecos/session/server/server_call.hpp"
#include "gecos/session/server/visit.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {

/// Server side of one client's session with one object.
///
/// Only the thread that polls the server's connections may receive packets. Any thread may send.
/// This class has more members than other classes, because the other classes of the server store
/// their data about one session here and so need no tables of their own. Comments say what guards
/// each member.
class ServerSession {
 public:
  ServerSession(std::unique_ptr<media::Connection> connection, std::shared_ptr<ObjectHost> object);
  ~ServerSession();
  ServerSession(const ServerSession&) = delete;
  ServerSession& operator=(const ServerSession&) = delete;

  media::Connection& connection() { return *connection_; }
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

  // The functions below require the object's mutex.

  /// Replies to the call `counter` with `failure`. `because_of`: if the call was not carried out
  /// because an earlier command failed, the counter of that earlier command; otherwise 0.
  void reply(std::uint64_t counter, const Failure& failure, std::uint64_t because_of = 0);
  void reply(std::uint64_t counter, ByteView result);
  /// Replies to the call `counter` with `before`, the reply that this call had in an earlier
  /// session.
  void reply_as(std::uint64_t counter, const wire::PacketView& before);
  /// Sends the latest progress of `call`. Returns true when it was sent, false when the connection
  /// has no room.
  bool report(const ServerCall& call, Detail detail, std::size_t position);
  /// Tells the client that its call `counter` waits and that `position` calls are before it.
  /// Returns whether the packet was sent.
  bool report_queued(std::uint64_t counter, std::size_t position);

  // Any thread may call the functions below.

  /// Sends a packet now, or as soon as the connection has room. Packets, replies included, are sent
  /// in order.
  void send(wire::PacketHeader header, ByteView body);
  PacketSender& sender() { return sender_; }
  tl::expected<Subscription, std::string> share(const StreamDescription& stream);
  void unshare(std::uint32_t id);

  /// Only the polling thread uses the following members.
  struct Polled {
    bool active = true;        ///< the connection is polled
    unsigned quiet_looks = 0;  ///< 0: a packet came since the last ActiveSessions::retire_idle
    TimePoint last_heard{};
  };
  Polled polled;

  /// Used only by the maintenance thread.
  HeartbeatLooks looks;

  Visit visit;

  // When true, the polling thread removes the session. Orders no other memory.
  std::atomic<bool> gone{false};

  // Guarded by the object's mutex.
  CallTable<ServerCall> calls;
  BlendChain chain;
  Intake intake;
  /// The replies that the client may request again. Over a medium that loses packets, these are all
  /// replies. Otherwise they are the replies made after the connection was lost, which the client
  /// requests in another session.
  const std::shared_ptr<ReplyCache> replies = std::make_shared<ReplyCache>();
  /// Whether the session may feed inward streams now, and under which epoch. Written while the
  /// object's mutex is held.
  const std::shared_ptr<FeedStanding> standing = std::make_shared<FeedStanding>();
  /// The streams to which the client has subscribed. The key is the code of a stream, the value is
  /// the id of the stream on the connection.
  std::map<FunctionCode, std::uint32_t> subscriptions;
  /// The epoch under which this session acquired its status. The status continues under a higher
  /// epoch after a `stop` that the session itself has called.
  std::uint64_t held_from = std::numeric_limits<std::uint64_t>::max();
  /// The epoch of the session's status, if it is newer than the epoch that the client got with the
  /// grant. Every reply then tells the client the newer epoch. Otherwise Epoch{}.
  Epoch renewed{};
  /// For each lane, the highest counter that was marked as started (start_words.hpp).
  std::array<std::uint64_t, media::shared_word_count> marked{};
  CallCounts counts;
  TimePoint greeted_at{};        ///< when the session was opened
  std::size_t commands = 0;      ///< number of actor commands that have not ended
  std::size_t unreturned = 0;    ///< number of calls whose phase is not Finished (CallState)
  bool left = false;             ///< the client said goodbye
  bool closed = false;           ///< the connection is lost or closed
  bool parted_in_order = false;  ///< the connection ended in order, so its calls still run
  std::string parted_because;    ///< completes "the client …", which says why the status is lost
  /// What the server knows from the client's heartbeats.
  struct Heartbeats {
    PeerLiveness liveness;
    /// True after this process was suspended or while the client is silent: no call of the session
    /// may start before the client's next heartbeat.
    bool awaited = false;
    /// Number of heartbeats received when `awaited` was set; only a later heartbeat clears
    /// `awaited`.
    std::uint64_t before = 0;
  };
  Heartbeats heartbeats;

 private:
  ReplyCache* kept() const;
  bool send_progress(std::uint64_t counter, Detail detail, const ProgressBody& body);

  const std::unique_ptr<media::Connection> connection_;
  const std::shared_ptr<ObjectHost> object_;
  const bool repeats_;
  SessionId id_{};
  Caller caller_;
  PacketSender sender_;
};

}  // namespace gecos::session
