#include "gecos/media/sealed/inward.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace gecos::media {

InwardStream::InwardStream(std::shared_ptr<SealedSender> sender, const SealedOptions& options,
                           std::size_t largest, std::size_t depth)
    : sender_(std::move(sender)),
      options_(options),
      largest_(static_cast<std::uint32_t>(std::min(
          largest,
          options.network->largest_datagram() - packet_overhead - InwardSampleHead::bytes))),
      depth_(SharedStream::depth_for(depth)),
      fork_watch_(this, [](void* owner) noexcept { static_cast<InwardStream*>(owner)->end(); }) {}

InwardShare InwardStream::shared_as(std::uint32_t id) {
  const MutexLock lock(mutex_);
  id_ = id;
  shared_ = true;
  return {id, largest_, depth_};
}

tl::expected<void, SendProblem> InwardStream::publish(ByteView sample, std::int64_t stamp_ns) {
  if (sample.size() > largest_) return tl::unexpected(SendProblem::TooLarge);
  const MutexLock lock(mutex_);
  last_.assign(sample.begin(), sample.end());
  stamp_ns_ = stamp_ns;
  ++sequence_;
  send_last();
  return {};
}

void InwardStream::repeat_last() {
  const MutexLock lock(mutex_);
  send_last();
}

void InwardStream::send_last() {
  if (ended_.load() || !shared_ || sequence_ == 0) return;
  std::array<std::byte, InwardSampleHead::bytes> head;
  InwardSampleHead{id_, stamp_ns_}.write(head);
  sender_->send({InnerKind::InwardSample, sequence_, options_.now_ns()}, head, last_, datagram_);
}

}  // namespace gecos::media
