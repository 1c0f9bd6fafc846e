#include "gecos/session/server/server_session.hpp"

#include "gecos/session/protocol/handshake.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/handler_waits.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {
namespace {

wire::PacketHeader reply_to(std::uint64_t counter) {
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Reply;
  header.flags = static_cast<std::int8_t>(Detail::Done);
  header.counter = counter;
  return header;
}

}  // namespace

ServerSession::ServerSession(std::unique_ptr<media::Connection> connection,
                             std::shared_ptr<ObjectHost> object)
    : intake(!connection->capabilities().reliable),
      heartbeats{.liveness = PeerLiveness(object->bounds_of_clients())},
      connection_(std::move(connection)),
      object_(std::move(object)),
      repeats_(!connection_->capabilities().reliable),
      sender_(*connection_) {}

ServerSession::~ServerSession() {
  if (greeted()) forget_session(id_);
}

void ServerSession::send(wire::PacketHeader header, ByteView body) {
  if (header.session == SessionId{}) header.session = id_;
  sender_.send(header, body);
}

void ServerSession::reply_as(std::uint64_t counter, const wire::PacketView& before) {
  auto header = before.header;
  header.session = id_;
  header.counter = counter;
  sender_.reply_again(header, before.body, kept());
}

void ServerSession::reply(std::uint64_t counter, ByteView result) {
  auto header = reply_to(counter);
  header.session = id_;
  header.epoch = renewed;
  sender_.reply(header, result, kept());
}

void ServerSession::reply(std::uint64_t counter, const Failure& failure, std::uint64_t because_of) {
  auto header = reply_to(counter);
  header.acknowledged = because_of;
  header.session = id_;
  header.epoch = renewed;
  sender_.reply(header, failure, kept());
}

/// Returns the cache in which replies are kept because the client may request them again; null when
/// the client cannot request them again.
ReplyCache* ServerSession::kept() const { return repeats_ || closed ? replies.get() : nullptr; }

bool ServerSession::report(const ServerCall& call, Detail detail, std::size_t position) {
  return send_progress(
      call.counter_in(*this), detail,
      {static_cast<std::uint32_t>(position), call.reported.fraction(), call.reported.feedback()});
}

bool ServerSession::report_queued(std::uint64_t counter, std::size_t position) {
  return send_progress(counter, Detail::Queued, {static_cast<std::uint32_t>(position), 0, {}});
}

bool ServerSession::send_progress(std::uint64_t counter, Detail detail, const ProgressBody& body) {
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Progress;
  header.flags = static_cast<std::int8_t>(detail);
  header.counter = counter;
  header.session = id_;
  // The packet is sent without a wake-up, because progress must not wake a caller that sleeps until
  // its call ends.
  return sender_.send_quietly(header, body.encoded_size(),
                              [&](wire::Encoder& to) { body.encode(to); });
}

tl::expected<Subscription, std::string> ServerSession::share(const StreamDescription& stream) {
  tl::expected<Subscription, std::string> shared;
  sender_.with_connection([&](media::Connection& connection) {
    shared = object_->streams().share(stream, connection);
  });
  return shared;
}

void ServerSession::unshare(std::uint32_t id) {
  sender_.with_connection([&](media::Connection& connection) { connection.unshare(id); });
}

}  // namespace gecos::session
