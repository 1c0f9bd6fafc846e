#include "gecos/media/lcm/door.hpp"

#include <algorithm>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/media/lcm/outlet.hpp"
#include "gecos/media/lcm/stream.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t most_unconfirmed = 256;
constexpr Duration unconfirmed_kept = std::chrono::seconds{5};
constexpr std::size_t most_links = 4096;

}  // namespace

bool LcmDoor::Budget::take(TimePoint now) {
  if (!since_ || now - *since_ >= std::chrono::seconds{1}) {
    since_ = now;
    taken_ = 0;
  }
  return taken_++ < per_second_;
}

LcmDoor::LcmDoor(LcmOptions options, std::shared_ptr<const LcmKeys> keys,
                 std::unique_ptr<LcmPort> in, LcmAddress address)
    : options_(std::move(options)),
      keys_(std::move(keys)),
      in_(std::move(in)),
      address_(std::move(address)),
      handshakes_(
          keys_->own, [keys = keys_](const crypto::PublicKey& key) { return keys->admits(key); },
          {}, options_.rekey),
      stream_port_(draw_port()) {}

tl::expected<void, MediumError> LcmDoor::open() {
  return in_->subscribe(address_.channel, [this](ByteView datagram) { take(datagram); });
}

void LcmDoor::take(ByteView datagram) {
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
  } catch (const std::system_error& failed) {  // who polls serves the others
    log_warning("lcm", std::string("cannot let a client in: ") + failed.what());
  }
}

void LcmDoor::take_first(const DatagramHeader& header, ByteView datagram, TimePoint now) {
  const auto context = handshake_context(address_, datagram.first(DatagramHeader::bytes));
  auto answered = handshakes_.answer(datagram.subspan(DatagramHeader::bytes), context, {}, now);
  if (!answered) {
    const auto& refused = answered.error();
    if (refused.why == crypto::Refusal::NotAdmitted && refused.who && warnings_.take(now)) {
      const auto admitted = keys_->directory.admission(*refused.who);
      log_warning("lcm", address_.place() + " refused a client: " +
                             (admitted ? "its key was admitted just now" : admitted.error().text));
    }
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    while (!unconfirmed_.empty() && (unconfirmed_.size() == most_unconfirmed ||
                                     now - unconfirmed_.front().since >= unconfirmed_kept)) {
      unconfirmed_.pop_front();
    }
    if (answered->channel) {
      if (inboxes_.size() >= most_links || inboxes_.contains(header.client)) return;
      unconfirmed_.push_back(
          {header.client, header.reply_port, now, std::move(*answered->channel)});
    }
  }
  answer(header, DatagramKind::Second, answered->second, now);
}

void LcmDoor::take_sealed(const DatagramHeader& header, ByteView datagram) {
  std::shared_ptr<LcmInbox> inbox;
  {
    const std::lock_guard lock(mutex_);
    const auto found = inboxes_.find(header.client);
    if (found == inboxes_.end()) return confirm(header, datagram);
    inbox = found->second;
  }
  inbox->take(datagram.first(DatagramHeader::bytes), datagram.subspan(DatagramHeader::bytes),
              options_.now());
}

void LcmDoor::confirm(const DatagramHeader& header, ByteView datagram) {
  if (closed_.load()) return;
  for (auto& one : unconfirmed_) {
    if (one.client != header.client) continue;
    Bytes frame(datagram.begin() + DatagramHeader::bytes, datagram.end());
    if (!one.channel.in.open(datagram.first(DatagramHeader::bytes), frame)) continue;
    auto inbox = std::make_shared<LcmInbox>(one.channel.in);
    inbox->put(std::move(frame), options_.now());
    inboxes_.emplace(one.client, inbox);
    guests_.push_back({one.client, one.reply_port, one.channel.peer, std::move(one.channel.out),
                       std::move(inbox)});
    std::erase_if(unconfirmed_, [&](const auto& other) { return other.client == header.client; });
    ring_bell(bell_.descriptor());
    return;
  }
}

void LcmDoor::answer(const DatagramHeader& to, DatagramKind kind, ByteView frame, TimePoint now) {
  if (!answers_.take(now)) return;
  // Opened for this one answer: who has not shown its keys holds nothing here.
  auto out = LcmPort::open(options_, to.reply_port);
  if (!out) {
    if (warnings_.take(now)) log_warning("lcm", "cannot answer a client: " + out.error().text);
    return;
  }
  LcmOutlet(std::move(*out), lcm_channel("GC", to.client), to.client, 0).send_bare(kind, frame);
}

std::optional<LcmDoor::Guest> LcmDoor::next_guest() {
  const std::lock_guard lock(mutex_);
  if (guests_.empty()) return std::nullopt;
  std::optional<Guest> next(std::move(guests_.front()));
  guests_.pop_front();
  return next;
}

void LcmDoor::forget(std::uint64_t client) {
  const std::lock_guard lock(mutex_);
  inboxes_.erase(client);
}

std::unique_ptr<StreamWriter> LcmDoor::make_stream(std::size_t largest, std::size_t depth) {
  const std::lock_guard lock(mutex_);
  if (streams_ == nullptr) {
    auto opened = LcmPort::open(options_, stream_port_);
    if (!opened) throw std::runtime_error(opened.error().text);
    streams_ = std::move(*opened);
  }
  SharedStream where;
  where.largest = static_cast<std::uint32_t>(std::min(largest, largest_lcm_packet));
  where.depth =
      static_cast<std::uint16_t>(std::clamp<std::size_t>(depth, 1, SharedStream::most_depth));
  where.port = stream_port_;
  where.channel = draw_number();
  return std::make_unique<LcmStreamWriter>(std::make_shared<LcmStream>(streams_, where));
}

}  // namespace gecos::media
