#include "gecos/session/server/packet_sender.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "gecos/base/whole_characters.hpp"
#include "gecos/media/quiet.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/object_queue.hpp"

namespace gecos::session {
namespace {

/// Maximum number of waiting packets: for each granted call a reply and a Goodbye, and the same
/// number again for repeated replies.
constexpr std::size_t most_backlog = 4 * ObjectQueue::most_of_object;
/// Maximum size in bytes of all waiting packets. A result that would exceed this limit is dropped,
/// and its call fails.
constexpr std::size_t most_backlog_bytes = 128 * 1024 * 1024;

/// Returns a shorter failure that fits into a packet. The shorter failure has the detail of
/// `failure` and the beginning of the text of `failure`.
Failure shortened(const Failure& failure, std::size_t takes, std::size_t carried) {
  constexpr std::size_t longest_text = 1024;
  const std::string_view kept = whole_characters(failure.text, longest_text);
  return {failure.detail,
          std::string(kept) + (kept.size() < failure.text.size() ? "…" : "") +
              " (cut: the whole failure takes " + std::to_string(takes) +
              " bytes, the medium carries at most " + std::to_string(carried) + ")",
          {},
          {}};
}

}  // namespace

void PacketSender::send(const wire::PacketHeader& header, ByteView body) {
  const MutexLock lock(mutex_);
  write_packet(packet_, header, body);
  deliver(packet_);
}

void PacketSender::send_again(const Bytes& packet) {
  const MutexLock lock(mutex_);
  if (std::ranges::find(backlog_, packet) == backlog_.end()) deliver(packet);
}

void PacketSender::reply(const wire::PacketHeader& header, ByteView result, ReplyCache* kept) {
  const MutexLock lock(mutex_);
  if (backlog_bytes_ + result.size() > most_backlog_bytes) {
    write_failure(packet_, header,
                  {Detail::Fault,
                   "the result of " + std::to_string(result.size()) +
                       " bytes was dropped: " + std::to_string(backlog_bytes_) +
                       " bytes of replies already wait for this client to read them",
                   {},
                   {}});
  } else {
    write_reply(header, result);
  }
  keep_and_deliver(header.counter, kept);
}

void PacketSender::reply_again(const wire::PacketHeader& header, ByteView body, ReplyCache* kept) {
  const MutexLock lock(mutex_);
  write_reply(header, body);
  keep_and_deliver(header.counter, kept);
}

void PacketSender::write_reply(const wire::PacketHeader& header, ByteView body) {
  if (wire::packet_size(body.size()) <= carried()) return write_packet(packet_, header, body);
  write_failure(packet_, header,
                {Detail::Fault,
                 "the result takes " + std::to_string(body.size()) +
                     " bytes and the medium carries at most " + std::to_string(carried()),
                 {},
                 {}});
}

void PacketSender::keep_and_deliver(std::uint64_t counter, ReplyCache* kept) {
  if (kept != nullptr) kept->keep(counter, packet_);
  deliver(packet_);
}

void PacketSender::reply(const wire::PacketHeader& header, const Failure& failure,
                         ReplyCache* kept) {
  const MutexLock lock(mutex_);
  write_failure(packet_, header, failure);
  const std::size_t takes = packet_.size();
  if (backlog_bytes_ + takes > most_backlog_bytes) {
    write_failure(packet_, header,
                  {failure.detail,
                   "the text of the failure, " + std::to_string(takes) +
                       " bytes, was dropped: " + std::to_string(backlog_bytes_) +
                       " bytes of replies already wait for this client to read them",
                   {},
                   {}});
  } else if (takes > carried()) {
    write_failure(packet_, header, shortened(failure, takes, carried()));
  }
  keep_and_deliver(header.counter, kept);
}

bool PacketSender::send_quietly(const wire::PacketHeader& header, std::size_t size,
                                FunctionRef<void(wire::Encoder&)> encode) {
  const MutexLock lock(mutex_);
  if (!backlog_.empty()) return false;
  write_packet(packet_, header, size, encode);
  return media::send_quietly(connection_, packet_, {}).has_value();
}

void PacketSender::deliver(ByteView packet) {
  if (backlog_.empty()) {
    const auto sent = connection_.send(packet, {});
    if (sent || sent.error() != media::SendProblem::Full) return;
  }
  // Here the limit is doubled, because replies that are sent again in a new session are sent even
  // if the packets that wait have reached the limit.
  const bool fits = backlog_bytes_ + packet.size() <= 2 * most_backlog_bytes;
  if (backlog_.size() == most_backlog || !fits) {
    overrun_.store(true, std::memory_order_relaxed);
    return;
  }
  backlog_.emplace_back(packet.begin(), packet.end());
  backlog_bytes_ += packet.size();
}

bool PacketSender::flush() {
  const MutexLock lock(mutex_);
  while (!backlog_.empty()) {
    const auto sent = connection_.send(backlog_.front(), {});
    if (!sent && sent.error() == media::SendProblem::Full) return false;
    backlog_bytes_ -= backlog_.front().size();
    backlog_.pop_front();
  }
  return true;
}

void PacketSender::with_connection(FunctionRef<void(media::Connection&)> use) {
  const MutexLock lock(mutex_);
  use(connection_);
}

}  // namespace gecos::session
