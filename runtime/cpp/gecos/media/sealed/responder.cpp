#include "gecos/media/sealed/responder.hpp"

#include <algorithm>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/whole_characters.hpp"
#include "gecos/media/sealed/stream.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t most_unconfirmed = 256;
constexpr Duration unconfirmed_kept = std::chrono::seconds{5};
constexpr std::size_t most_connections = 4096;
constexpr std::size_t most_refused = 64;
constexpr Duration refused_kept = std::chrono::seconds{5};
constexpr std::size_t longest_reason = 2048;

}  // namespace

bool HandshakeResponder::Budget::take(TimePoint now) {
  if (!since_ || now - *since_ >= std::chrono::seconds{1}) {
    since_ = now;
    taken_ = 0;
  }
  return taken_++ < per_second_;
}

HandshakeResponder::HandshakeResponder(SealedOptions options,
                                       std::shared_ptr<const SealedKeys> keys,
                                       std::unique_ptr<DatagramPort> in, SealedAddress address)
    : options_(std::move(options)),
      keys_(std::move(keys)),
      in_(std::move(in)),
      address_(std::move(address)),
      handshakes_(
          keys_->own, [keys = keys_](const crypto::PublicKey& key) { return keys->admits(key); },
          {}, options_.rekey),
      stream_port_(draw_port()) {}

tl::expected<void, MediumError> HandshakeResponder::open() {
  const auto subscribed =
      in_->subscribe(address_.channel, [this](ByteView datagram) { take(datagram); });
  if (!subscribed) return tl::unexpected(subscribed.error());
  return {};
}

void HandshakeResponder::take(ByteView datagram) {
  const auto header = DatagramHeader::read(datagram);
  if (!header || header->reply_port == 0) return;
  try {
    if (header->kind == DatagramKind::Sealed) return take_sealed(*header, datagram);
    if (closed_.load()) return;
    const TimePoint now = options_.now();
    if (header->kind == DatagramKind::First) take_first(*header, datagram, now);
    if (header->kind == DatagramKind::Ask && !address_.key) {
      answer(*header, DatagramKind::Key, keys_->own.public_key().bytes, now);
    }
  } catch (const std::system_error& failed) {  // keep serving the other clients
    log_warning(address_.medium, std::string("cannot accept a client: ") + failed.what());
  }
}

void HandshakeResponder::take_first(const DatagramHeader& header, ByteView datagram,
                                    TimePoint now) {
  const auto context = handshake_context(address_, datagram.first(DatagramHeader::bytes));
  auto answered = handshakes_.answer(datagram.subspan(DatagramHeader::bytes), context, {}, now);
  if (!answered) {
    const auto& refused = answered.error();
    if (refused.why == crypto::Refusal::NotAdmitted && refused.who && warnings_.take(now)) {
      const auto admitted = keys_->directory.admission(*refused.who);
      log_warning(address_.medium,
                  address_.place() + " refused a client: " +
                      (admitted ? "the key of the client was not admitted then, but is admitted now"
                                : admitted.error().text));
    }
    return;
  }
  {
    const MutexLock lock(mutex_);
    while (!unconfirmed_.empty() && (unconfirmed_.size() == most_unconfirmed ||
                                     now - unconfirmed_.front().since >= unconfirmed_kept)) {
      unconfirmed_.pop_front();
    }
    if (answered->channel) {
      if (queues_.size() >= most_connections || queues_.contains(header.client)) return;
      unconfirmed_.push_back(
          {header.client, header.reply_port, now, std::move(*answered->channel)});
    }
  }
  answer(header, DatagramKind::Second, answered->second, now);
}

void HandshakeResponder::take_sealed(const DatagramHeader& header, ByteView datagram) {
  std::shared_ptr<ReceiveQueue> queue;
  std::optional<RefusedPeer> refused_before;
  {
    const MutexLock lock(mutex_);
    const auto found = queues_.find(header.client);
    if (found != queues_.end()) {
      queue = found->second;
    } else {
      refused_before = refused_.again(header.client, options_.now());
      confirm(header, datagram);
    }
  }
  if (refused_before) tell(*refused_before);
  if (queue == nullptr) return;
  queue->take(datagram.first(DatagramHeader::bytes), datagram.subspan(DatagramHeader::bytes),
              options_.now());
}

void HandshakeResponder::confirm(const DatagramHeader& header, ByteView datagram) {
  if (closed_.load()) return;
  for (auto& one : unconfirmed_) {
    if (one.client != header.client) continue;
    Bytes frame(datagram.begin() + DatagramHeader::bytes, datagram.end());
    if (!one.channel.in.open(datagram.first(DatagramHeader::bytes), frame)) continue;
    const auto owner = owner_of(one.channel.peer);
    if (!owner) return;
    auto queue = std::make_shared<ReceiveQueue>(one.channel.in);
    queue->put(std::move(frame), options_.now());
    queues_.emplace(one.client, queue);
    pending_.push_back({one.client, one.reply_port, one.channel.peer, *owner,
                        std::move(one.channel.out), std::move(queue)});
    std::erase_if(unconfirmed_, [&](const auto& other) { return other.client == header.client; });
    event_.notify();
    return;
  }
}

/// Returns the owner of a key. The owner is empty for our own key and for a key without an owner.
/// Returns nullopt when the key is not admitted any more, or when its owner cannot be read.
std::optional<crypto::KeyOwner> HandshakeResponder::owner_of(const crypto::PublicKey& key) const {
  if (key == keys_->own.public_key()) return crypto::KeyOwner{};
  const auto owner = keys_->directory.owner(key);
  if (!owner) return std::nullopt;
  // The key may have been removed since the handshake. The file of a key is removed before the file
  // of the key's owner. Therefore, if the key is still admitted now, the owner that was read above
  // is valid.
  if (!keys_->directory.is_admitted(key)) return std::nullopt;
  return owner->value_or(crypto::KeyOwner{});
}

void HandshakeResponder::answer(const DatagramHeader& to, DatagramKind kind, ByteView frame,
                                TimePoint now) {
  if (!answers_.take(now)) return;
  // A client that has not proved its keys must not occupy resources here. Therefore the port of the
  // client is opened for this answer only, unless other clients use the same port.
  auto out = options_.network->shared(to.reply_port);
  if (!out) {
    if (warnings_.take(now))
      log_warning(address_.medium, "cannot answer a client: " + out.error().text);
    return;
  }
  SealedSender(std::move(*out), channel_name("GC", to.client), to.client, 0).send_bare(kind, frame);
}

std::optional<HandshakeResponder::PendingPeer> HandshakeResponder::next_pending() {
  const MutexLock lock(mutex_);
  if (pending_.empty()) return std::nullopt;
  std::optional<PendingPeer> next(std::move(pending_.front()));
  pending_.pop_front();
  return next;
}

void HandshakeResponder::forget(std::uint64_t client) {
  const MutexLock lock(mutex_);
  queues_.erase(client);
}

void HandshakeResponder::refuse(PendingPeer client, const std::string& why) {
  const ByteView reason = std::as_bytes(std::span(whole_characters(why, longest_reason)));
  const InnerHeader what{InnerKind::Refuse, 0, options_.now_ns()};
  const RefusedPeer refused{
      client.client, client.reply_port, options_.now(),
      std::make_shared<const Bytes>(sealed_datagram(client.sealer, client.client, what, reason))};
  {
    const MutexLock lock(mutex_);
    queues_.erase(client.client);
    refused_.add(refused);
  }
  tell(refused);
}

void HandshakeResponder::RefusedPeers::add(RefusedPeer peer) {
  if (peers_.size() == most_refused) peers_.pop_front();
  peers_.push_back(std::move(peer));
}

std::optional<HandshakeResponder::RefusedPeer> HandshakeResponder::RefusedPeers::again(
    std::uint64_t client, TimePoint now) {
  while (!peers_.empty() && now - peers_.front().since >= refused_kept) peers_.pop_front();
  const auto found = std::ranges::find(peers_, client, &RefusedPeer::client);
  if (found == peers_.end() || !repeats_.take(now)) return std::nullopt;
  return *found;
}

/// Sends a refused client the datagram that says why it is refused. The port of the client is
/// opened for this datagram only, so that a refused client occupies no descriptor.
void HandshakeResponder::tell(const RefusedPeer& refused) const {
  const auto out = options_.network->shared(refused.reply_port);
  if (out) (*out)->publish(channel_name("GC", refused.client), *refused.datagram);
}

std::unique_ptr<StreamWriter> HandshakeResponder::make_stream(std::size_t largest,
                                                              std::size_t depth) {
  const MutexLock lock(mutex_);
  if (streams_ == nullptr) {
    auto opened = options_.network->shared(stream_port_);
    if (!opened) throw std::runtime_error(opened.error().text);
    streams_ = std::move(*opened);
  }
  SharedStream where;
  const std::size_t fits = options_.network->largest_datagram() - sample_overhead;
  where.largest = static_cast<std::uint32_t>(std::min(largest, fits));
  where.depth = SharedStream::depth_for(depth);
  where.port = stream_port_;
  where.channel = draw_number();
  return std::make_unique<SealedStreamWriter>(std::make_shared<SealedStream>(streams_, where));
}

}  // namespace gecos::media
