#include "gecos/media/sealed/stream.hpp"

#include <algorithm>
#include <random>
#include <utility>

#include "gecos/crypto/big_endian.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t stamp_at = DatagramHeader::bytes + crypto::StreamSealer::text_at;

SharedStream with_key(SharedStream where, const crypto::StreamKey& key) {
  where.key = key;
  return where;
}

}  // namespace

SealedStream::SealedStream(std::shared_ptr<DatagramPort> port, SharedStream where)
    : port_(std::move(port)),
      where_(with_key(where, sealer_.key())),
      largest_(where.largest),
      channel_(channel_name("GS", where.channel)) {}

tl::expected<void, SendProblem> SealedStream::publish(ByteView sample, std::int64_t stamp_ns) {
  if (sample.size() > largest_) return tl::unexpected(SendProblem::TooLarge);
  const MutexLock lock(mutex_);
  last_.resize(sample_overhead + sample.size());
  const std::span<std::byte> all(last_);
  const auto header = all.first<DatagramHeader::bytes>();
  DatagramHeader{.kind = DatagramKind::Sample}.write(header);
  write_stamp(all.subspan<stamp_at, stamp_bytes>(), stamp_ns);
  std::ranges::copy(sample, last_.begin() + stamp_at + stamp_bytes);
  sealer_.seal(header, all.subspan(DatagramHeader::bytes));
  port_->publish(channel_, last_);
  return {};
}

void SealedStream::repeat_last() {
  const MutexLock lock(mutex_);
  if (!last_.empty()) port_->publish(channel_, last_);
}

SharedStream SealedStream::where() const {
  const MutexLock lock(mutex_);
  return where_;
}

void SealedStream::move_on() {
  const MutexLock lock(mutex_);
  sealer_ = crypto::StreamSealer(sealer_.count());
  where_.key = sealer_.key();
  last_.clear();  // the excluded reader knows it, and others cannot open it by the new key
  generation_.fetch_add(1, std::memory_order_release);
}

std::uint64_t SealedStream::newest() const {
  const MutexLock lock(mutex_);
  return sealer_.count();
}

void SealedStream::number_after(std::uint64_t newest) {
  const MutexLock lock(mutex_);
  sealer_ = crypto::StreamSealer(newest);
  where_.key = sealer_.key();
}

SampleQueue::SampleQueue(std::shared_ptr<DatagramPort> port, const SharedStream& where,
                         std::weak_ptr<Sleeper> sleeper)
    : port_(std::move(port)),
      sleeper_(std::move(sleeper)),
      samples_(where.depth),
      opener_(where.key) {}

void SampleQueue::take(ByteView datagram) {
  const auto header = DatagramHeader::read(datagram);
  if (!header || header->kind != DatagramKind::Sample || datagram.size() < sample_overhead) return;
  {
    const MutexLock lock(mutex_);
    const ByteView sealed = datagram.subspan(DatagramHeader::bytes);
    // The sequence number is the nonce counter plus one: the first sample of a stream has sequence
    // number 1 and nonce counter 0.
    const std::uint64_t sequence =
        crypto::read_u64(sealed.first<crypto::StreamSealer::text_at>()) + 1;
    if (sequence <= samples_.newest()) return;  // repeated, or reordered after a newer one
    frame_.assign(sealed.begin(), sealed.end());
    const auto text = opener_.open(datagram.first(DatagramHeader::bytes), frame_);
    if (!text) return;
    samples_.put(sequence, read_stamp(text->first(stamp_bytes)), text->subspan(stamp_bytes));
  }
  if (const auto sleeper = sleeper_.lock()) sleeper->wake_if_asleep();
}

void SampleQueue::take_key(const crypto::StreamKey& key) {
  const MutexLock lock(mutex_);
  opener_ = crypto::StreamOpener(key);
}

bool SampleQueue::read(std::uint64_t after, bool newest, StreamSample& into) {
  port_->pump();
  return samples_.read(after, newest, into);
}

std::vector<StreamSample> SampleQueue::stored() {
  port_->pump();
  return samples_.stored();
}

bool SampleQueue::anything_new() {
  port_->pump();
  return samples_.anything_new();
}

tl::expected<std::unique_ptr<SealedStreamReader>, MediumError> SealedStreamReader::open(
    const std::shared_ptr<SampleQueue>& queue, DatagramPort& port, const std::string& channel) {
  // The queue holds the port, and the port owns the callback. The callback has only a weak pointer
  // to the queue, so that there is no cycle.
  const auto subscription =
      port.subscribe(channel, [weak = std::weak_ptr(queue)](ByteView datagram) {
        if (const auto to = weak.lock()) to->take(datagram);
      });
  if (!subscription) return tl::unexpected(subscription.error());
  return std::unique_ptr<SealedStreamReader>(new SealedStreamReader(queue, port, *subscription));
}

std::string channel_name(std::string_view prefix, std::uint64_t number) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string channel(prefix);
  for (int shift = 60; shift >= 0; shift -= 4) channel += digits[(number >> shift) & 0xf];
  return channel;
}

std::uint64_t draw_number() {
  std::random_device device;
  return std::uniform_int_distribution<std::uint64_t>(1)(device);
}

std::uint16_t draw_port() {
  std::random_device device;
  return std::uniform_int_distribution<std::uint16_t>(20'000, 32'000)(device);
}

}  // namespace gecos::media
