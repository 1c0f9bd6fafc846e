#include "gecos/media/sealed/connection.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "gecos/base/system_error.hpp"

namespace gecos::media {
namespace {

/// The largest number of streams of a connection. A peer that shares more streams is hostile.
constexpr std::size_t most_streams = 1024;

/// Returns a description of a peer, for example "key 3fa9c1d2, 239.255.76.67:20017".
std::string peer_text(const std::optional<crypto::PublicKey>& key, const DatagramNetwork& network,
                      std::uint16_t port) {
  return (key ? "key " + key->short_name() + ", " : "") + network.name() + ":" +
         std::to_string(port);
}

}  // namespace

Peer peer_of(const HandshakeResponder::PendingPeer& pending, const HandshakeResponder& responder) {
  const bool own = pending.key == responder.keys()->own.public_key();
  return {std::nullopt,
          std::nullopt,
          peer_text(pending.key, *responder.options().network, pending.reply_port),
          pending.owner.user,
          pending.owner.host,
          own ? std::string() : pending.key.to_string()};
}

SealedConnection::SealedConnection(std::shared_ptr<ReceiveQueue> queue,
                                   std::shared_ptr<SealedSender> sender,
                                   const SealedOptions& options, Peer peer)
    : queue_(std::move(queue)),
      options_(options),
      sender_(std::move(sender)),
      peer_(std::move(peer)),
      fork_watch_(this, [](void* owner) noexcept {
        static_cast<SealedConnection*>(owner)->inherited_.store(true);
      }) {}

void SealedConnection::say(InnerKind kind, std::uint64_t number, ByteView body) {
  if (inherited()) return;  // a forked child would reuse the parent's nonce counter
  Bytes memory;
  sender_->send({kind, number, options_.now_ns()}, {}, body, memory);
}

tl::expected<std::uint64_t, SendProblem> SealedConnection::send(ByteView head, ByteView body) {
  if (head.size() + body.size() > capabilities().largest_packet) {
    return tl::unexpected(SendProblem::TooLarge);
  }
  if (inherited() || queue_->closed()) return tl::unexpected(SendProblem::Lost);
  if (!sender_->send({InnerKind::Packet, sent_ + 1, options_.now_ns()}, head, body, outgoing_)) {
    return tl::unexpected(SendProblem::Full);
  }
  return ++sent_;
}

std::optional<ByteView> SealedConnection::receive() {
  if (inherited()) return std::nullopt;
  if (!queue_->pop(current_)) {
    pump();
    if (!queue_->pop(current_)) return std::nullopt;
  }
  return ReceiveQueue::packet_in(current_.frame);
}

void SealedConnection::beat() {
  if (inherited() || queue_->closed()) return;
  const TimePoint now = options_.now();
  sender_->on_tick(now);
  queue_->on_tick(now);
  say(InnerKind::Beat);
}

std::uint64_t SealedConnection::beats_seen() {
  if (!inherited()) pump();
  return queue_->beats();
}

Loss SealedConnection::loss() {
  if (inherited()) return Loss::Broken;
  pump();
  if (!queue_->closed()) return Loss::None;
  return queue_->refusal().empty() ? Loss::Closed : Loss::Refused;
}

std::string SealedConnection::loss_text() const {
  if (inherited()) {
    return "this connection belongs to the process that forked this one: make a new connection";
  }
  if (!queue_->closed()) return "";
  auto refusal = queue_->refusal();
  return refusal.empty() ? "the other end closed the connection" : refusal;
}

tl::expected<std::unique_ptr<Connection>, MediumError> SealedClient::connect(
    const SealedOptions& options, std::shared_ptr<const SealedKeys> keys,
    const SealedAddress& address) {
  if (address.key) {
    if (const auto admitted = keys->directory.admission(*address.key); !admitted) {
      return tl::unexpected(MediumError{address.medium + ": refused " + address.place() + ": " +
                                        admitted.error().text});
    }
  }
  SealedOptions here = options;
  here.network = options.network->named(address.network);
  const std::uint64_t client = draw_number();
  const std::uint16_t reply_port = here.network->draw_reply_port();
  auto in = here.network->shared(reply_port);
  if (!in) return tl::unexpected(std::move(in.error()));
  auto out = here.network->shared(address.port);
  if (!out) return tl::unexpected(std::move(out.error()));
  auto sender =
      std::make_shared<SealedSender>(std::move(*out), address.channel, client, reply_port);
  auto queue = std::make_shared<ReceiveQueue>();
  auto initiator =
      std::make_shared<HandshakeInitiator>(std::move(keys), here, address, sender, queue);
  const auto subscription =
      (*in)->subscribe(channel_name("GC", client), [queue, initiator, here](ByteView datagram) {
        const auto header = DatagramHeader::read(datagram);
        if (!header) return;
        const ByteView frame = datagram.subspan(DatagramHeader::bytes);
        if (header->kind != DatagramKind::Sealed) return initiator->take(*header, frame);
        queue->take(datagram.first(DatagramHeader::bytes), frame, here.now());
      });
  if (!subscription) return tl::unexpected(subscription.error());
  auto connection =
      std::make_unique<SealedClient>(here, std::move(queue), std::move(sender), std::move(*in),
                                     *subscription, std::move(initiator), address);
  connection->initiator_->advance();
  return connection;
}

SealedClient::SealedClient(const SealedOptions& options, std::shared_ptr<ReceiveQueue> queue,
                           std::shared_ptr<SealedSender> sender, std::shared_ptr<DatagramPort> in,
                           std::uint64_t subscription,
                           std::shared_ptr<HandshakeInitiator> initiator,
                           const SealedAddress& address)
    : SealedConnection(
          std::move(queue), std::move(sender), options,
          Peer{std::nullopt, std::nullopt, peer_text(address.key, *options.network, address.port)}),
      in_(std::move(in)),
      subscription_(subscription),
      initiator_(std::move(initiator)),
      streams_(::epoll_create1(EPOLL_CLOEXEC)),
      descriptors_{in_->descriptor(), queue_->event().descriptor(), streams_.get()} {}

SealedClient::~SealedClient() {
  for (const auto& made : made_) {
    if (const auto stream = made.lock()) stream->end();
  }
  if (!inherited() && !queue_->closed()) say(InnerKind::Bye);
  in_->unsubscribe(subscription_);
}

void SealedClient::beat() {
  SealedConnection::beat();
  if (inherited()) return;
  initiator_->advance();
  const MutexLock lock(mutex_);
  for (const auto& [id, inward] : inward_) {
    if (inward.opened) continue;
    if (const auto stream = inward.stream.lock()) tell(id, *stream);
  }
}

std::string SealedClient::loss_text() const {
  auto text = SealedConnection::loss_text();
  return text.empty() ? initiator_->trouble() : text;
}

bool SealedClient::prepare_to_sleep() {
  if (inherited()) return false;
  queue_->set_asleep(true);
  pump();
  const bool news = heard_of_streams_.exchange(false);
  if (!news && !queue_->has_packets() && !queue_->closed() && !new_samples()) return true;
  queue_->set_asleep(false);
  return false;
}

void SealedClient::woke() {
  if (inherited()) return;
  queue_->set_asleep(false);
  queue_->event().drain();
  pump();
  new_samples();
}

void SealedClient::pump() {
  // Unread datagrams keep LCM's descriptor readable, but an edge-triggered poller gets no new event
  // for them. Therefore this function notifies the eventfd of the connection.
  if (in_->pump()) queue_->event().notify();
  initiator_->advance();
  for (const auto& notice : queue_->notices()) {
    const auto id = static_cast<std::uint32_t>(notice.number);
    if (notice.kind == InnerKind::Share) take_share(notice.stream, notice.number);
    if (notice.kind == InnerKind::Opened) take_opened(id);
    if (notice.kind == InnerKind::Unshare) {
      const MutexLock lock(mutex_);
      arrived_.erase(id);
    }
  }
}

void SealedClient::take_share(const SharedStream& where, std::uint64_t number) {
  const MutexLock lock(mutex_);
  if (arrived_.size() >= most_streams && !arrived_.contains(where.id)) return;
  Arrived& arrived = arrived_[where.id];
  if (arrived.where.channel != where.channel) {
    arrived = {where, number, false, {}};
  } else if (number >= arrived.number) {
    arrived.where = where;
    if (std::exchange(arrived.number, number) != number) take_key(where);
  }
  heard_of_streams_ = true;
  // If the stream is open here already, the peer announces the stream again for one of two reasons:
  // the peer did not receive our Opened message, or the stream has a new key.
  if (arrived.opened) say(InnerKind::Opened, arrived.number);
}

/// Gives the new key of a stream to the readers of the stream.
void SealedClient::take_key(const SharedStream& where) {
  for (const Reading& one : reading_) {
    if (one.id != where.id) continue;
    if (const auto queue = one.queue.lock()) queue->take_key(where.key);
  }
}

void SealedClient::take_opened(std::uint32_t id) {
  std::shared_ptr<InwardStream> stream;
  {
    const MutexLock lock(mutex_);
    const auto found = inward_.find(id);
    if (found == inward_.end()) return;
    found->second.opened = true;
    stream = found->second.stream.lock();
  }
  if (stream != nullptr) stream->repeat_last();
}

bool SealedClient::new_samples() {
  std::vector<std::shared_ptr<SampleQueue>> reading;
  {
    const MutexLock lock(mutex_);
    forget_closed_readers();
    for (const auto& one : reading_) {
      if (auto queue = one.queue.lock()) reading.push_back(std::move(queue));
    }
  }
  bool found = false;
  for (const auto& queue : reading) found = queue->anything_new() || found;
  return found;
}

void SealedClient::forget_closed_readers() {
  std::vector<int> closed;
  std::erase_if(reading_, [&](const Reading& one) {
    if (!one.queue.expired()) return false;
    closed.push_back(one.port);
    return true;
  });
  for (const int port : closed) {
    // Removes the port from the epoll set when no other stream of this connection uses the port.
    // Otherwise, samples for another connection that uses the port would wake this connection.
    const bool read = std::any_of(reading_.begin(), reading_.end(),
                                  [&](const Reading& one) { return one.port == port; });
    if (!read) ::epoll_ctl(streams_.get(), EPOLL_CTL_DEL, port, nullptr);
  }
}

std::unique_ptr<StreamWriter> SealedClient::make_stream(std::size_t largest, std::size_t depth) {
  auto stream = std::make_shared<InwardStream>(sender(), options_, largest, depth);
  const MutexLock lock(mutex_);
  std::erase_if(made_, [](const auto& made) { return made.expired(); });
  made_.push_back(stream);
  return std::make_unique<InwardWriter>(std::move(stream));
}

tl::expected<void, SendProblem> SealedClient::share(std::uint32_t id, StreamWriter& stream) {
  if (inherited() || queue_->closed()) return tl::unexpected(SendProblem::Lost);
  const auto& inward = dynamic_cast<InwardWriter&>(stream).stream();
  const MutexLock lock(mutex_);
  if (inward_.size() >= most_streams && !inward_.contains(id)) {
    return tl::unexpected(SendProblem::Full);
  }
  inward_[id] = {inward, false};
  tell(id, *inward);
  return {};
}

void SealedClient::tell(std::uint32_t id, InwardStream& stream) {
  std::array<std::byte, InwardShare::bytes> body;
  stream.shared_as(id).write(body);
  say(InnerKind::InwardShare, id, body);
}

void SealedClient::unshare(std::uint32_t id) {
  if (inherited()) return;
  const MutexLock lock(mutex_);
  if (inward_.erase(id) != 0) say(InnerKind::Unshare, id);
}

std::unique_ptr<StreamReader> SealedClient::open_stream(std::uint32_t id,
                                                        const StreamBounds& /*most*/) {
  if (inherited()) return nullptr;
  heard_of_streams_ = false;
  pump();
  const MutexLock lock(mutex_);
  const auto found = arrived_.find(id);
  if (found == arrived_.end()) return nullptr;
  const SharedStream& where = found->second.where;
  std::string& problem = found->second.problem;
  auto opened = options_.network->shared(where.port);
  if (!opened) {
    problem = std::move(opened.error().text);
    return nullptr;
  }
  const std::shared_ptr<DatagramPort> port = std::move(*opened);
  auto queue = std::make_shared<SampleQueue>(port, where, queue_);
  auto reader = SealedStreamReader::open(queue, *port, channel_name("GS", where.channel));
  if (!reader) {
    problem = std::move(reader.error().text);
    return nullptr;
  }
  forget_closed_readers();
  epoll_event event{EPOLLIN, {.fd = port->descriptor()}};
  if (::epoll_ctl(streams_.get(), EPOLL_CTL_ADD, port->descriptor(), &event) != 0 &&
      errno != EEXIST) {
    problem = std::string(capabilities().name) + ": " + system_text(errno);
    return nullptr;
  }
  problem.clear();
  reading_.push_back({id, queue, port->descriptor()});
  found->second.opened = true;
  say(InnerKind::Opened, found->second.number);
  return std::move(*reader);
}

std::string SealedClient::why_no_stream(std::uint32_t id) {
  const MutexLock lock(mutex_);
  const auto found = arrived_.find(id);
  return found == arrived_.end() ? std::string() : found->second.problem;
}

SealedServer::SealedServer(std::shared_ptr<HandshakeResponder> responder,
                           const HandshakeResponder::PendingPeer& pending,
                           std::shared_ptr<SealedSender> sender)
    : SealedConnection(pending.queue, std::move(sender), responder->options(),
                       peer_of(pending, *responder)),
      responder_(std::move(responder)),
      client_(pending.client),
      key_(pending.key),
      descriptors_{queue_->event().descriptor()} {}

tl::expected<std::unique_ptr<Connection>, MediumError> SealedServer::welcome(
    std::shared_ptr<HandshakeResponder> responder, HandshakeResponder::PendingPeer pending) {
  auto out = responder->options().network->shared(pending.reply_port);
  if (!out) return tl::unexpected(std::move(out.error()));
  auto sender = std::make_shared<SealedSender>(std::move(*out), channel_name("GC", pending.client),
                                               pending.client, std::uint16_t{0});
  sender->open(std::move(pending.sealer));
  auto connection =
      std::make_unique<SealedServer>(std::move(responder), pending, std::move(sender));
  connection->say(InnerKind::Beat);  // the client waits for the server's first packet
  return connection;
}

SealedServer::~SealedServer() {
  if (inherited()) return;
  if (!queue_->closed()) say(InnerKind::Bye);
  responder_->forget(client_);
}

bool SealedServer::prepare_to_sleep() {
  if (inherited()) return false;
  queue_->set_asleep(true);
  pump();
  if (!queue_->has_packets() && !queue_->new_samples() && !queue_->closed()) return true;
  queue_->set_asleep(false);
  return false;
}

void SealedServer::woke() {
  if (inherited()) return;
  queue_->set_asleep(false);
  queue_->event().drain();
  queue_->new_samples();
}

void SealedServer::pump() {
  responder_->pump();
  for (const auto& notice : queue_->notices()) {
    const auto id = static_cast<std::uint32_t>(notice.number);
    if (notice.kind == InnerKind::Opened) take_opened(notice.number);
    if (notice.kind == InnerKind::InwardShare) take_share(notice.inward);
    if (notice.kind == InnerKind::Unshare) {
      const MutexLock lock(mutex_);
      inward_.erase(id);
    }
  }
}

void SealedServer::take_opened(std::uint64_t number) {
  std::shared_ptr<SealedStream> stream;
  {
    const MutexLock lock(mutex_);
    const auto found = shared_.find(static_cast<std::uint32_t>(number));
    if (found == shared_.end() || number >> 32 != found->second.generation) return;
    found->second.opened = true;
    stream = found->second.stream.lock();
  }
  if (stream != nullptr) stream->repeat_last();
}

void SealedServer::take_share(const InwardShare& where) {
  const MutexLock lock(mutex_);
  if (inward_.size() >= most_streams && !inward_.contains(where.id)) return;
  Inward& inward = inward_[where.id];
  inward.where = where;
  // If the stream is open here already, the peer announces the stream again because the peer did
  // not receive our Opened message.
  if (inward.opened) say(InnerKind::Opened, where.id);
}

void SealedServer::beat() {
  SealedConnection::beat();
  if (inherited()) return;
  const MutexLock lock(mutex_);
  for (auto& [id, shared] : shared_) {
    const auto stream = shared.stream.lock();
    if (stream == nullptr || (shared.opened && stream->generation() == shared.generation)) continue;
    tell(id, shared, *stream);
  }
}

void SealedServer::tell(std::uint32_t id, Shared& shared, const SealedStream& stream) {
  const std::uint32_t generation = stream.generation();  // before the keys, which may be newer
  if (std::exchange(shared.generation, generation) != generation) shared.opened = false;
  SharedStream where = stream.where();
  where.id = id;
  std::array<std::byte, SharedStream::bytes> body;
  where.write(body);
  say(InnerKind::Share, std::uint64_t{generation} << 32 | id, body);
}

std::function<std::string()> SealedServer::later_refusal() {
  if (key_ == responder_->keys()->own.public_key()) return nullptr;
  return [keys = responder_->keys(), key = key_,
          owner_then = crypto::KeyOwner{peer().user, peer().host}]() -> std::string {
    if (const auto admitted = keys->directory.admission(key); !admitted) {
      return admitted.error().passing ? std::string() : admitted.error().text;
    }
    const auto owner = keys->directory.owner(key);
    if (!owner) return {};  // the next call finds out
    if (owner->value_or(crypto::KeyOwner{}) == owner_then) return {};
    return "the owner of the key " + key.short_name() + " has changed since the client connected";
  };
}

/// Makes a stream of the same kind as the acceptor makes. A stream of the acceptor can have many
/// readers; this stream has a single reader.
std::unique_ptr<StreamWriter> SealedServer::make_stream(std::size_t largest, std::size_t depth) {
  return responder_->make_stream(largest, depth);
}

tl::expected<void, SendProblem> SealedServer::share(std::uint32_t id, StreamWriter& stream) {
  if (inherited() || queue_->closed()) return tl::unexpected(SendProblem::Lost);
  const auto& shared = dynamic_cast<SealedStreamWriter&>(stream).stream();
  const MutexLock lock(mutex_);
  Shared& entry = shared_[id] = {shared, false, shared->generation()};
  tell(id, entry, *shared);
  return {};
}

void SealedServer::unshare(std::uint32_t id) {
  if (inherited()) return;
  const MutexLock lock(mutex_);
  if (shared_.erase(id) != 0) say(InnerKind::Unshare, id);
}

std::unique_ptr<StreamReader> SealedServer::open_stream(std::uint32_t id,
                                                        const StreamBounds& most) {
  if (inherited()) return nullptr;
  pump();
  const MutexLock lock(mutex_);
  const auto found = inward_.find(id);
  if (found == inward_.end()) return nullptr;
  auto samples =
      std::make_shared<SampleBuffer>(std::min<std::size_t>(found->second.where.depth, most.depth));
  queue_->collect(id, samples);
  found->second.opened = true;
  say(InnerKind::Opened, id);
  return std::make_unique<InwardReader>(std::move(samples));
}

}  // namespace gecos::media
