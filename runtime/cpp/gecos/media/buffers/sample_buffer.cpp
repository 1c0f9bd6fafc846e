#include "gecos/media/buffers/sample_buffer.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

namespace gecos::media {

std::uint64_t SampleBuffer::newest() const {
  const MutexLock lock(mutex_);
  return samples_.empty() ? 0 : samples_.back().sequence;
}

bool SampleBuffer::put(std::uint64_t sequence, std::int64_t stamp_ns, ByteView sample) {
  const MutexLock lock(mutex_);
  if (!samples_.empty() && sequence <= samples_.back().sequence) return false;
  StreamSample kept;
  if (samples_.size() == depth_) {
    kept = std::move(samples_.front());
    samples_.pop_front();
  }
  kept.sequence = sequence;
  kept.stamp_ns = stamp_ns;
  kept.bytes.assign(sample.begin(), sample.end());
  samples_.push_back(std::move(kept));
  return true;
}

bool SampleBuffer::read(std::uint64_t after, bool newest, StreamSample& into) {
  const MutexLock lock(mutex_);
  if (samples_.empty()) return false;
  seen_ = samples_.back().sequence;
  if (seen_ <= after) return false;
  auto found = std::prev(samples_.end());
  if (!newest) {
    found = std::ranges::find_if(samples_, [&](const auto& kept) { return kept.sequence > after; });
  }
  into.sequence = found->sequence;
  into.stamp_ns = found->stamp_ns;
  into.bytes.assign(found->bytes.begin(), found->bytes.end());
  return true;
}

std::vector<StreamSample> SampleBuffer::stored() const {
  const MutexLock lock(mutex_);
  return {samples_.begin(), samples_.end()};
}

bool SampleBuffer::anything_new() {
  const MutexLock lock(mutex_);
  const std::uint64_t newest = samples_.empty() ? 0 : samples_.back().sequence;
  return std::exchange(seen_, newest) != newest;
}

tl::expected<std::span<std::byte>, SendProblem> CopyingWriter::lend(std::size_t size) {
  if (size > largest_) return tl::unexpected(SendProblem::TooLarge);
  lent_.resize(size);
  return std::span(lent_);
}

void CopyingWriter::publish_lent(std::int64_t stamp_ns) {
  static_cast<void>(publish(lent_, stamp_ns));  // lend() has refused samples that are too large
}

StreamSample& CopyingReader::unused_sample() {
  if (lent_.use_count() != 1) lent_ = std::make_shared<StreamSample>();
  std::atomic_thread_fence(std::memory_order_acquire);  // after the last use by its borrower
  return *lent_;
}

std::optional<LentSample> CopyingReader::lend() const {
  return LentSample{lent_->sequence, lent_->stamp_ns, lent_->bytes, lent_};
}

std::optional<LentSample> CopyingReader::lend_latest(std::uint64_t after) {
  return latest(after, unused_sample()) ? lend() : std::nullopt;
}

std::optional<LentSample> CopyingReader::lend_next(std::uint64_t after) {
  return next(after, unused_sample()) ? lend() : std::nullopt;
}

}  // namespace gecos::media
