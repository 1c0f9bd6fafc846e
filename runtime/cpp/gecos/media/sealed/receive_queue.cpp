#include "gecos/media/sealed/receive_queue.hpp"

#include <utility>

namespace gecos::media {
namespace {

constexpr std::size_t most_notices = 1024;
constexpr Duration oldest_sign_of_life = std::chrono::milliseconds(250);

/// Returns the plaintext in a frame that was decrypted in place.
ByteView text_in(const Bytes& frame) {
  return ByteView(frame).subspan(crypto::Sealer::text_at, frame.size() - crypto::Sealer::overhead);
}

}  // namespace

ByteView ReceiveQueue::packet_in(const Bytes& frame) {
  return text_in(frame).subspan(InnerHeader::bytes);
}

void ReceiveQueue::open(const crypto::Opener& opener) {
  const MutexLock lock(mutex_);
  opener_ = opener;
}

void ReceiveQueue::take(ByteView header, ByteView frame, TimePoint now) {
  const MutexLock lock(mutex_);
  if (!opener_) return;
  Bytes opened = std::exchange(spare_, {});
  opened.assign(frame.begin(), frame.end());
  if (opener_->open(header, opened)) put_locked(std::move(opened), now);
}

void ReceiveQueue::put(Bytes frame, TimePoint now) {
  const MutexLock lock(mutex_);
  put_locked(std::move(frame), now);
}

void ReceiveQueue::put_locked(Bytes frame, TimePoint now) {
  const auto header = InnerHeader::read(text_in(frame));
  if (!header) return;
  const Duration age = clock_.age(header->sent_ns, now);
  // Only a fresh packet counts as a sign of life. A packet that waited while this process was
  // suspended does not show that the peer is alive now.
  if (age < oldest_sign_of_life) beats_.fetch_add(1, std::memory_order_relaxed);
  switch (header->kind) {
    case InnerKind::Beat:
      note_read();
      return;
    case InnerKind::Bye:
      closed_.store(true, std::memory_order_release);
      break;
    case InnerKind::Refuse: {
      const ByteView why = packet_in(frame);
      refusal_.assign(reinterpret_cast<const char*>(why.data()), why.size());
      closed_.store(true, std::memory_order_release);
      break;
    }
    case InnerKind::Packet:
      if (packets_.size() == most_packets || bytes_ + frame.size() > most_bytes) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        return;
      }
      bytes_ += frame.size();
      packets_.push_back({std::move(frame), now - age});
      break;
    case InnerKind::Share:
    case InnerKind::Opened:
    case InnerKind::Unshare:
    case InnerKind::InwardShare:
      note(*header, packet_in(frame));
      break;
    case InnerKind::InwardSample:
      put_sample(*header, packet_in(frame));
      break;
  }
  note_read();
  wake_if_asleep();
}

void ReceiveQueue::note_read() {
  if (packets_.empty() && !in_hand_) beats_read_.store(beats(), std::memory_order_relaxed);
}

void ReceiveQueue::note(const InnerHeader& header, ByteView body) {
  Notice notice{header.kind, header.number, {}, {}};
  if (header.kind == InnerKind::Share) {
    const auto stream = SharedStream::read(body);
    if (!stream) return;
    notice.stream = *stream;
  } else if (header.kind == InnerKind::InwardShare) {
    const auto inward = InwardShare::read(body);
    if (!inward) return;
    notice.inward = *inward;
  }
  if (notices_.size() < most_notices) notices_.push_back(notice);
}

void ReceiveQueue::put_sample(const InnerHeader& header, ByteView body) {
  const auto head = InwardSampleHead::read(body);
  if (!head) return;
  const auto found = inward_.find(head->id);
  if (found == inward_.end()) return;
  if (const auto samples = found->second.lock()) {
    samples->put(header.number, head->stamp_ns, body.subspan(InwardSampleHead::bytes));
  }
}

void ReceiveQueue::collect(std::uint32_t id, std::weak_ptr<SampleBuffer> samples) {
  const MutexLock lock(mutex_);
  std::erase_if(inward_, [](const auto& each) { return each.second.expired(); });
  inward_[id] = std::move(samples);
}

bool ReceiveQueue::new_samples() {
  const MutexLock lock(mutex_);
  bool found = false;
  for (const auto& [id, held] : inward_) {
    if (const auto samples = held.lock()) found = samples->anything_new() || found;
  }
  return found;
}

bool ReceiveQueue::pop(Packet& packet) {
  const MutexLock lock(mutex_);
  in_hand_ = !packets_.empty();
  note_read();
  if (!in_hand_) return false;
  std::swap(spare_, packet.frame);
  packet = std::move(packets_.front());
  packets_.pop_front();
  bytes_ -= packet.frame.size();
  return true;
}

std::string ReceiveQueue::refusal() {
  const MutexLock lock(mutex_);
  return refusal_;
}

bool ReceiveQueue::has_packets() {
  const MutexLock lock(mutex_);
  return !packets_.empty();
}

std::optional<Duration> ReceiveQueue::clock_difference() {
  const MutexLock lock(mutex_);
  return clock_.difference();
}

std::vector<ReceiveQueue::Notice> ReceiveQueue::notices() {
  const MutexLock lock(mutex_);
  return std::exchange(notices_, {});
}

void ReceiveQueue::on_tick(TimePoint now) {
  const MutexLock lock(mutex_);
  if (opener_) opener_->on_tick(now);
}

}  // namespace gecos::media
