#include "gecos/media/sealed/sender.hpp"

#include <algorithm>
#include <utility>

namespace gecos::media {
namespace {

constexpr std::size_t inner_at = DatagramHeader::bytes + crypto::Sealer::text_at;
constexpr std::size_t body_at = inner_at + InnerHeader::bytes;

/// Writes into `memory` the plaintext that seal() then encrypts.
void write(const DatagramHeader& header, InnerHeader what, ByteView head, ByteView body,
           Bytes& memory) {
  memory.resize(body_at + head.size() + body.size() + crypto::tag_bytes);
  const std::span<std::byte> all(memory);
  header.write(all.first<DatagramHeader::bytes>());
  what.write(all.subspan<inner_at, InnerHeader::bytes>());
  const auto rest = std::ranges::copy(head, memory.begin() + body_at).out;
  std::ranges::copy(body, rest);
}

void seal(crypto::Sealer& sealer, Bytes& datagram) {
  const std::span<std::byte> all(datagram);
  sealer.seal(all.first(DatagramHeader::bytes), all.subspan(DatagramHeader::bytes));
}

}  // namespace

Bytes sealed_datagram(crypto::Sealer& sealer, std::uint64_t client, InnerHeader what,
                      ByteView body) {
  Bytes datagram;
  write({DatagramKind::Sealed, 0, client}, what, {}, body, datagram);
  seal(sealer, datagram);
  return datagram;
}

SealedSender::SealedSender(std::shared_ptr<DatagramPort> port, std::string channel,
                           std::uint64_t client, std::uint16_t reply_port)
    : port_(std::move(port)),
      channel_(std::move(channel)),
      client_(client),
      reply_port_(reply_port) {}

void SealedSender::open(crypto::Sealer sealer) {
  const MutexLock lock(mutex_);
  sealer_.emplace(std::move(sealer));
  for (Bytes& datagram : held_) {
    seal(*sealer_, datagram);
    port_->publish(channel_, datagram);
  }
  held_.clear();
}

bool SealedSender::is_open() {
  const MutexLock lock(mutex_);
  return sealer_.has_value();
}

bool SealedSender::send(InnerHeader what, ByteView head, ByteView body, Bytes& memory) {
  write({DatagramKind::Sealed, reply_port_, client_}, what, head, body, memory);
  {
    const MutexLock lock(mutex_);
    if (!sealer_) {
      if (what.kind == InnerKind::Packet && held_.size() < most_held &&
          bytes_held_ + memory.size() <= most_bytes_held) {
        bytes_held_ += memory.size();
        held_.push_back(memory);
      }
      return true;
    }
    seal(*sealer_, memory);
  }
  return port_->publish(channel_, memory);
}

bool SealedSender::send_bare(DatagramKind kind, ByteView frame) {
  const auto clear = header(kind);
  Bytes datagram(clear.begin(), clear.end());
  datagram.insert(datagram.end(), frame.begin(), frame.end());
  return port_->publish(channel_, datagram);
}

std::array<std::byte, DatagramHeader::bytes> SealedSender::header(DatagramKind kind) const {
  std::array<std::byte, DatagramHeader::bytes> bytes;
  DatagramHeader{kind, reply_port_, client_}.write(bytes);
  return bytes;
}

void SealedSender::on_tick(TimePoint now) {
  const MutexLock lock(mutex_);
  if (sealer_) sealer_->on_tick(now);
}

}  // namespace gecos::media
