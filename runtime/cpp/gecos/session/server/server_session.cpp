#include "gecos/session/server/server_session.hpp"

#include <algorithm>

#include "gecos/media/quiet.hpp"
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/handler_waits.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {
namespace {

/// Maximum number of waiting packets: a reply and a Goodbye for each granted call, and as many
/// again for repeated replies.
constexpr std::size_t most_backlog = 4 * ObjectQueue::most_of_object;
/// Maximum size of the backlog in bytes. A result that would exceed this limit is dropped, and its
/// call fails.
constexpr std::size_t most_backlog_bytes = 128 * 1024 * 1024;

wire::PacketHeader reply_to(std::uint64_t counter) {
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Reply;
  header.flags = static_cast<std::int8_t>(Detail::Done);
  header.counter = counter;
  return header;
}

/// Shortens a failure so that it fits into a packet: keeps its detail and the beginning of its
/// text.
Failure shortened(const Failure& failure, std::size_t takes, std::size_t carried) {
  constexpr std::size_t longest_text = 1024;
  std::size_t cut = std::min(failure.text.size(), longest_text);
  const auto inside_character = [&] {
    return cut < failure.text.size() &&
           (static_cast<unsigned char>(failure.text[cut]) & 0xC0) == 0x80;
  };
  while (cut > 0 && inside_character()) --cut;
  return {failure.detail,
          failure.text.substr(0, cut) + (cut < failure.text.size() ? "…" : "") +
              " (cut: the whole failure takes " + std::to_string(takes) +
              " bytes and the medium carries " + std::to_string(carried) + ")",
          {},
          {}};
}

}  // namespace

ServerSession::ServerSession(std::unique_ptr<media::Connection> connection,
                             std::shared_ptr<ObjectHost> object)
    : intake(!connection->capabilities().reliable),
      liveness(object->bounds_of_clients()),
      connection_(std::move(connection)),
      object_(std::move(object)),
      repeats_(!connection_->capabilities().reliable) {}

ServerSession::~ServerSession() {
  if (greeted()) forget_session(id_);
}

void ServerSession::send(wire::PacketHeader header, ByteView body) {
  const MutexLock lock(send_mutex_);
  if (header.session == SessionId{}) header.session = id_;
  write_packet(packet_, header, body);
  deliver(packet_);
}

void ServerSession::reply_as(std::uint64_t counter, const wire::PacketView& before) {
  const MutexLock lock(send_mutex_);
  auto header = before.header;
  header.session = id_;
  header.counter = counter;
  if (const std::size_t carried = connection_->capabilities().largest_packet;
      wire::packet_size(before.body.size()) > carried) {
    write_failure(packet_, header,
                  {Detail::Fault,
                   "the answer takes " + std::to_string(before.body.size()) +
                       " bytes and the medium carries " + std::to_string(carried),
                   {},
                   {}});
  } else {
    write_packet(packet_, header, before.body);
  }
  if (repeats_ || closed) replies->keep(counter, packet_);
  deliver(packet_);
}

void ServerSession::reply(std::uint64_t counter, ByteView result, Epoch epoch) {
  const MutexLock lock(send_mutex_);
  auto header = reply_to(counter);
  header.session = id_;
  header.epoch = epoch;
  if (wire::packet_size(result.size()) > connection_->capabilities().largest_packet) {
    write_failure(
        packet_, header,
        {Detail::Fault,
         "the result takes " + std::to_string(result.size()) + " bytes and the medium carries " +
             std::to_string(connection_->capabilities().largest_packet),
         {},
         {}});
  } else if (backlog_bytes_ + result.size() > most_backlog_bytes) {
    write_failure(packet_, header,
                  {Detail::Fault,
                   "the result of " + std::to_string(result.size()) +
                       " bytes was dropped: " + std::to_string(backlog_bytes_) +
                       " bytes of replies already wait for this client to read them",
                   {},
                   {}});
  } else {
    write_packet(packet_, header, result);
  }
  if (repeats_ || closed) replies->keep(counter, packet_);
  deliver(packet_);
}

void ServerSession::reply(std::uint64_t counter, const Failure& failure) {
  const MutexLock lock(send_mutex_);
  auto header = reply_to(counter);
  header.session = id_;
  write_failure(packet_, header, failure);
  if (const std::size_t carried = connection_->capabilities().largest_packet;
      packet_.size() > carried) {
    const std::size_t takes = packet_.size();
    write_failure(packet_, header, shortened(failure, takes, carried));
  }
  if (repeats_ || closed) replies->keep(counter, packet_);
  deliver(packet_);
}

bool ServerSession::report(const ServerCall& call, Detail detail, std::size_t position) {
  const ProgressBody body{static_cast<std::uint32_t>(position), call.reported.fraction(),
                          call.reported.feedback()};
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Progress;
  header.flags = static_cast<std::int8_t>(detail);
  header.counter = call.counter_in(*this);
  header.session = id_;
  const MutexLock lock(send_mutex_);
  if (!backlog_.empty()) return false;
  write_packet(packet_, header, body.encoded_size(), [&](wire::Encoder& to) { body.encode(to); });
  // Sent without a wake-up: a caller that sleeps until its call ends must not be woken by progress.
  return media::send_quietly(*connection_, packet_, {}).has_value();
}

void ServerSession::send_again(const Bytes& packet) {
  const MutexLock lock(send_mutex_);
  if (std::ranges::find(backlog_, packet) != backlog_.end())
    return;  // the first copy of the packet has not been sent yet
  deliver(packet);
}

void ServerSession::deliver(ByteView packet) {
  if (backlog_.empty()) {
    const auto sent = connection_->send(packet, {});
    if (sent || sent.error() != media::SendProblem::Full) return;
  }
  if (backlog_.size() == most_backlog) {
    overrun_.store(true, std::memory_order_relaxed);
    return;
  }
  backlog_.emplace_back(packet.begin(), packet.end());
  backlog_bytes_ += packet.size();
}

void ServerSession::flush() {
  const MutexLock lock(send_mutex_);
  while (!backlog_.empty()) {
    const auto sent = connection_->send(backlog_.front(), {});
    if (!sent && sent.error() == media::SendProblem::Full) return;
    backlog_bytes_ -= backlog_.front().size();
    backlog_.pop_front();
  }
}

tl::expected<std::uint32_t, std::string> ServerSession::share(const StreamDescription& stream) {
  const MutexLock lock(send_mutex_);
  return object_->streams().share(stream, *connection_);
}

void ServerSession::unshare(std::uint32_t id) {
  const MutexLock lock(send_mutex_);
  connection_->unshare(id);
}

}  // namespace gecos::session
