#include "gecos/media/lcm/inbox.hpp"

#include <utility>

namespace gecos::media {
namespace {

constexpr std::size_t most_notices = 1024;

}  // namespace

void LcmInbox::take(const DatagramHeader& header, ByteView body) {
  beats_.fetch_add(1, std::memory_order_relaxed);
  std::uint64_t unknown = 0;
  server_.compare_exchange_strong(unknown, header.server, std::memory_order_relaxed);
  switch (header.kind) {
    case DatagramKind::Hello:
    case DatagramKind::Welcome:
    case DatagramKind::Beat:
    case DatagramKind::Sample:
      return;
    case DatagramKind::Bye:
      closed_.store(true, std::memory_order_release);
      break;
    case DatagramKind::Packet: {
      const std::lock_guard lock(mutex_);
      if (packets_.size() == most_packets || bytes_ + body.size() > most_bytes) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        return;
      }
      bytes_ += body.size();
      packets_.emplace_back(body.begin(), body.end());
      break;
    }
    case DatagramKind::Share:
    case DatagramKind::Opened:
    case DatagramKind::Unshare: {
      Notice notice{header.kind, header.number, {}};
      if (header.kind == DatagramKind::Share) {
        const auto stream = SharedStream::read(body);
        if (!stream) return;
        notice.stream = *stream;
      }
      const std::lock_guard lock(mutex_);
      if (notices_.size() == most_notices) return;
      notices_.push_back(notice);
      break;
    }
  }
  wake_if_asleep();
}

bool LcmInbox::pop(Bytes& into) {
  const std::lock_guard lock(mutex_);
  if (packets_.empty()) return false;
  into = std::move(packets_.front());
  packets_.pop_front();
  bytes_ -= into.size();
  return true;
}

bool LcmInbox::has_packets() {
  const std::lock_guard lock(mutex_);
  return !packets_.empty();
}

std::vector<LcmInbox::Notice> LcmInbox::notices() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notices_, {});
}

}  // namespace gecos::media
