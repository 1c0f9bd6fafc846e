#include "gecos/media/lcm/link.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "gecos/base/system_error.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t most_streams = 1024;  // of one link; a peer that shares more means harm

}  // namespace

std::string lcm_peer_text(const std::optional<crypto::PublicKey>& key, const std::string& group,
                          std::uint16_t port) {
  return (key ? "key " + key->short_name() + ", " : "") + group + ":" + std::to_string(port);
}

const Offer& lcm_offer() {
  static constexpr Offer offer{.kind = Kind::Lcm,
                               .same_host_only = false,
                               .ordered = false,
                               .reliable = false,
                               .real_time = false,
                               .reports_death = false,
                               .authenticated = true,
                               .largest_packet = largest_lcm_packet};
  return offer;
}

LcmLink::LcmLink(std::shared_ptr<LcmInbox> inbox, std::shared_ptr<LcmOutlet> outlet,
                 const LcmOptions& options, Peer peer)
    : inbox_(std::move(inbox)),
      options_(options),
      outlet_(std::move(outlet)),
      peer_(std::move(peer)),
      fork_watch_(this, [](void* owner) noexcept {
        static_cast<LcmLink*>(owner)->inherited_.store(true);
      }) {}

void LcmLink::say(InnerKind kind, std::uint64_t number, ByteView body) {
  if (inherited()) return;  // sealed here it would go out under the parent's counter
  Bytes memory;
  outlet_->send({kind, number, options_.now_ns()}, {}, body, memory);
}

tl::expected<std::uint64_t, SendProblem> LcmLink::send(ByteView head, ByteView body) {
  if (head.size() + body.size() > largest_lcm_packet) {
    return tl::unexpected(SendProblem::TooLarge);
  }
  if (inherited() || inbox_->closed()) return tl::unexpected(SendProblem::Lost);
  if (!outlet_->send({InnerKind::Packet, sent_ + 1, options_.now_ns()}, head, body, outgoing_)) {
    return tl::unexpected(SendProblem::Full);
  }
  return ++sent_;
}

std::optional<ByteView> LcmLink::receive() {
  if (inherited()) return std::nullopt;
  if (!inbox_->pop(current_)) {
    pump();
    if (!inbox_->pop(current_)) return std::nullopt;
  }
  return LcmInbox::packet_in(current_.frame);
}

void LcmLink::beat() {
  if (inherited() || inbox_->closed()) return;
  const TimePoint now = options_.now();
  outlet_->tend(now);
  inbox_->tend(now);
  say(InnerKind::Beat);
}

std::uint64_t LcmLink::beats_seen() {
  if (!inherited()) pump();
  return inbox_->beats();
}

Loss LcmLink::loss() {
  if (inherited()) return Loss::Broken;
  pump();
  return inbox_->closed() ? Loss::Closed : Loss::None;
}

std::string LcmLink::loss_text() const {
  if (inherited()) {
    return "this connection belongs to the process that forked this one: make your own";
  }
  return inbox_->closed() ? "the other end closed" : "";
}

tl::expected<std::unique_ptr<Link>, MediumError> LcmClientLink::connect(
    const LcmOptions& options, std::shared_ptr<const LcmKeys> keys, const LcmAddress& address) {
  if (address.key) {
    if (const auto admitted = keys->directory.admission(*address.key); !admitted) {
      return tl::unexpected(
          MediumError{"lcm: refused " + address.place() + ": " + admitted.error().text});
    }
  }
  LcmOptions here = options;
  here.group = address.group;
  const std::uint64_t client = draw_number();
  const std::uint16_t reply_port = draw_port();
  auto in = LcmPort::open(here, reply_port);
  if (!in) return tl::unexpected(std::move(in.error()));
  auto out = LcmPort::open(here, address.port);
  if (!out) return tl::unexpected(std::move(out.error()));
  auto outlet = std::make_shared<LcmOutlet>(std::move(*out), address.channel, client, reply_port);
  auto inbox = std::make_shared<LcmInbox>();
  auto opening = std::make_shared<LcmOpening>(std::move(keys), here, address, outlet, inbox);
  const auto subscribed =
      (*in)->subscribe(lcm_channel("GC", client), [inbox, opening, here](ByteView datagram) {
        const auto header = DatagramHeader::read(datagram);
        if (!header) return;
        const ByteView frame = datagram.subspan(DatagramHeader::bytes);
        if (header->kind != DatagramKind::Sealed) return opening->take(*header, frame);
        inbox->take(datagram.first(DatagramHeader::bytes), frame, here.now());
      });
  if (!subscribed) return tl::unexpected(subscribed.error());
  auto link = std::make_unique<LcmClientLink>(here, std::move(inbox), std::move(outlet),
                                              std::move(*in), std::move(opening), address);
  link->opening_->advance();
  return link;
}

LcmClientLink::LcmClientLink(const LcmOptions& options, std::shared_ptr<LcmInbox> inbox,
                             std::shared_ptr<LcmOutlet> outlet, std::unique_ptr<LcmPort> in,
                             std::shared_ptr<LcmOpening> opening, const LcmAddress& address)
    : LcmLink(std::move(inbox), std::move(outlet), options,
              Peer{std::nullopt, std::nullopt,
                   lcm_peer_text(address.key, address.group, address.port)}),
      in_(std::move(in)),
      opening_(std::move(opening)),
      streams_(::epoll_create1(EPOLL_CLOEXEC)),
      descriptors_{in_->descriptor(), inbox_->bell().descriptor(), streams_.get()} {}

LcmClientLink::~LcmClientLink() {
  for (const auto& made : made_) {
    if (const auto stream = made.lock()) stream->end();
  }
  if (!inherited() && !inbox_->closed()) say(InnerKind::Bye);
}

void LcmClientLink::beat() {
  LcmLink::beat();
  if (inherited()) return;
  opening_->advance();
  const std::lock_guard lock(mutex_);
  for (const auto& [id, inward] : inward_) {
    if (inward.opened) continue;
    if (const auto stream = inward.stream.lock()) tell(id, *stream);
  }
}

std::string LcmClientLink::loss_text() const {
  auto text = LcmLink::loss_text();
  return text.empty() ? opening_->trouble() : text;
}

bool LcmClientLink::arm() {
  if (inherited()) return false;
  inbox_->set_asleep(true);
  pump();
  const bool news = heard_of_streams_.exchange(false);
  if (!news && !inbox_->has_packets() && !inbox_->closed() && !new_samples()) return true;
  inbox_->set_asleep(false);
  return false;
}

void LcmClientLink::disarm() {
  if (inherited()) return;
  inbox_->set_asleep(false);
  inbox_->bell().quiet();
  pump();
  new_samples();
}

void LcmClientLink::pump() {
  // What is left over keeps LCM's descriptor readable; an edge-triggered watcher needs the bell.
  if (in_->pump()) ring_bell(inbox_->bell().descriptor());
  opening_->advance();
  for (const auto& notice : inbox_->notices()) {
    const auto id = static_cast<std::uint32_t>(notice.number);
    if (notice.kind == InnerKind::Share) take_share(notice.stream);
    if (notice.kind == InnerKind::Opened) take_opened(id);
    if (notice.kind == InnerKind::Unshare) {
      const std::lock_guard lock(mutex_);
      arrived_.erase(id);
    }
  }
}

void LcmClientLink::take_share(const SharedStream& where) {
  const std::lock_guard lock(mutex_);
  if (arrived_.size() >= most_streams && !arrived_.contains(where.id)) return;
  Arrived& arrived = arrived_[where.id];
  if (arrived.where.channel != where.channel) arrived = {where, false};
  heard_of_streams_ = true;
  // Told again although it is open: our answer was lost.
  if (arrived.opened) say(InnerKind::Opened, where.id);
}

void LcmClientLink::take_opened(std::uint32_t id) {
  std::shared_ptr<InwardStream> stream;
  {
    const std::lock_guard lock(mutex_);
    const auto found = inward_.find(id);
    if (found == inward_.end()) return;
    found->second.opened = true;
    stream = found->second.stream.lock();
  }
  if (stream != nullptr) stream->repeat_last();
}

bool LcmClientLink::new_samples() {
  std::vector<std::shared_ptr<LcmStreamInbox>> reading;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(reading_, [&](const auto& held) {
      if (auto inbox = held.lock()) {
        reading.push_back(std::move(inbox));
        return false;
      }
      return true;
    });
  }
  bool found = false;
  for (const auto& inbox : reading) found = inbox->anything_new() || found;
  return found;
}

std::unique_ptr<StreamWriter> LcmClientLink::make_stream(std::size_t largest, std::size_t depth) {
  auto stream = std::make_shared<InwardStream>(outlet(), options_, largest, depth);
  const std::lock_guard lock(mutex_);
  std::erase_if(made_, [](const auto& made) { return made.expired(); });
  made_.push_back(stream);
  return std::make_unique<InwardWriter>(std::move(stream));
}

tl::expected<void, SendProblem> LcmClientLink::share(std::uint32_t id, StreamWriter& stream) {
  if (inherited() || inbox_->closed()) return tl::unexpected(SendProblem::Lost);
  const auto& inward = dynamic_cast<InwardWriter&>(stream).stream();
  const std::lock_guard lock(mutex_);
  if (inward_.size() >= most_streams && !inward_.contains(id)) {
    return tl::unexpected(SendProblem::Full);
  }
  inward_[id] = {inward, false};
  tell(id, *inward);
  return {};
}

void LcmClientLink::tell(std::uint32_t id, InwardStream& stream) {
  std::array<std::byte, InwardShare::bytes> body;
  stream.shared_as(id).write(body);
  say(InnerKind::InwardShare, id, body);
}

void LcmClientLink::unshare(std::uint32_t id) {
  if (inherited()) return;
  const std::lock_guard lock(mutex_);
  if (inward_.erase(id) != 0) say(InnerKind::Unshare, id);
}

std::unique_ptr<StreamReader> LcmClientLink::open_stream(std::uint32_t id) {
  if (inherited()) return nullptr;
  heard_of_streams_ = false;
  pump();
  const std::lock_guard lock(mutex_);
  const auto found = arrived_.find(id);
  if (found == arrived_.end()) return nullptr;
  const SharedStream& where = found->second.where;
  std::string& problem = found->second.problem;
  auto opened = LcmPort::open(options_, where.port);
  if (!opened) {
    problem = std::move(opened.error().text);
    return nullptr;
  }
  const std::shared_ptr<LcmPort> port = std::move(*opened);
  auto inbox = std::make_shared<LcmStreamInbox>(port, where, inbox_);
  // The port keeps the callback, and the inbox the port: a weak one back, or none would ever go.
  const auto subscribed = port->subscribe(lcm_channel("GS", where.channel),
                                          [weak = std::weak_ptr(inbox)](ByteView datagram) {
                                            if (const auto to = weak.lock()) to->take(datagram);
                                          });
  epoll_event event{EPOLLIN, {.fd = port->descriptor()}};
  if (!subscribed) {
    problem = subscribed.error().text;
    return nullptr;
  }
  if (::epoll_ctl(streams_.get(), EPOLL_CTL_ADD, port->descriptor(), &event) != 0) {
    problem = "lcm: " + system_text(errno);
    return nullptr;
  }
  problem.clear();
  reading_.push_back(inbox);
  found->second.opened = true;
  say(InnerKind::Opened, id);
  return std::make_unique<LcmStreamReader>(std::move(inbox));
}

std::string LcmClientLink::why_no_stream(std::uint32_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = arrived_.find(id);
  return found == arrived_.end() ? std::string() : found->second.problem;
}

LcmServerLink::LcmServerLink(std::shared_ptr<LcmDoor> door, const LcmDoor::Guest& guest,
                             std::shared_ptr<LcmOutlet> outlet)
    : LcmLink(guest.inbox, std::move(outlet), door->options(),
              Peer{std::nullopt, std::nullopt,
                   lcm_peer_text(guest.key, door->options().group, guest.reply_port)}),
      door_(std::move(door)),
      client_(guest.client),
      descriptors_{inbox_->bell().descriptor()} {}

tl::expected<std::unique_ptr<Link>, MediumError> LcmServerLink::welcome(
    std::shared_ptr<LcmDoor> door, LcmDoor::Guest guest) {
  auto out = LcmPort::open(door->options(), guest.reply_port);
  if (!out) return tl::unexpected(std::move(out.error()));
  auto outlet = std::make_shared<LcmOutlet>(std::move(*out), lcm_channel("GC", guest.client),
                                            guest.client, std::uint16_t{0});
  outlet->open(std::move(guest.sealer));
  auto link = std::make_unique<LcmServerLink>(std::move(door), guest, std::move(outlet));
  link->say(InnerKind::Beat);  // the client waits to hear us
  return link;
}

LcmServerLink::~LcmServerLink() {
  if (inherited()) return;
  if (!inbox_->closed()) say(InnerKind::Bye);
  door_->forget(client_);
}

bool LcmServerLink::arm() {
  if (inherited()) return false;
  inbox_->set_asleep(true);
  pump();
  if (!inbox_->has_packets() && !inbox_->new_samples() && !inbox_->closed()) return true;
  inbox_->set_asleep(false);
  return false;
}

void LcmServerLink::disarm() {
  if (inherited()) return;
  inbox_->set_asleep(false);
  inbox_->bell().quiet();
  inbox_->new_samples();
}

void LcmServerLink::pump() {
  door_->pump();
  for (const auto& notice : inbox_->notices()) {
    const auto id = static_cast<std::uint32_t>(notice.number);
    if (notice.kind == InnerKind::Opened) take_opened(id);
    if (notice.kind == InnerKind::InwardShare) take_share(notice.inward);
    if (notice.kind == InnerKind::Unshare) {
      const std::lock_guard lock(mutex_);
      inward_.erase(id);
    }
  }
}

void LcmServerLink::take_opened(std::uint32_t id) {
  std::shared_ptr<LcmStream> stream;
  {
    const std::lock_guard lock(mutex_);
    const auto found = shared_.find(id);
    if (found == shared_.end()) return;
    found->second.opened = true;
    stream = found->second.stream.lock();
  }
  if (stream != nullptr) stream->repeat_last();
}

void LcmServerLink::take_share(const InwardShare& where) {
  const std::lock_guard lock(mutex_);
  if (inward_.size() >= most_streams && !inward_.contains(where.id)) return;
  Inward& inward = inward_[where.id];
  inward.where = where;
  // Told again although it is open: our answer was lost.
  if (inward.opened) say(InnerKind::Opened, where.id);
}

void LcmServerLink::beat() {
  LcmLink::beat();
  if (inherited()) return;
  const std::lock_guard lock(mutex_);
  for (const auto& [id, shared] : shared_) {
    if (shared.opened) continue;
    if (const auto stream = shared.stream.lock()) tell(id, *stream);
  }
}

void LcmServerLink::tell(std::uint32_t id, const LcmStream& stream) {
  SharedStream where = stream.where();
  where.id = id;
  std::array<std::byte, SharedStream::bytes> body;
  where.write(body);
  say(InnerKind::Share, id, body);
}

/// A server sends to all its readers at once: its acceptor's streams serve one reader as well.
std::unique_ptr<StreamWriter> LcmServerLink::make_stream(std::size_t largest, std::size_t depth) {
  return door_->make_stream(largest, depth);
}

tl::expected<void, SendProblem> LcmServerLink::share(std::uint32_t id, StreamWriter& stream) {
  if (inherited() || inbox_->closed()) return tl::unexpected(SendProblem::Lost);
  const auto& shared = dynamic_cast<LcmStreamWriter&>(stream).stream();
  const std::lock_guard lock(mutex_);
  shared_[id] = {shared, false};
  tell(id, *shared);
  return {};
}

void LcmServerLink::unshare(std::uint32_t id) {
  if (inherited()) return;
  const std::lock_guard lock(mutex_);
  if (shared_.erase(id) != 0) say(InnerKind::Unshare, id);
}

std::unique_ptr<StreamReader> LcmServerLink::open_stream(std::uint32_t id) {
  if (inherited()) return nullptr;
  pump();
  const std::lock_guard lock(mutex_);
  const auto found = inward_.find(id);
  if (found == inward_.end()) return nullptr;
  auto samples = std::make_shared<SampleBuffer>(found->second.where.depth);
  inbox_->collect(id, samples);
  found->second.opened = true;
  say(InnerKind::Opened, id);
  return std::make_unique<InwardReader>(std::move(samples));
}

}  // namespace gecos::media
