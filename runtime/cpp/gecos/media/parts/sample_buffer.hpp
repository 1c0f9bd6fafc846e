#pragma once

#include <cstddef>
#include <deque>

#include "gecos/base/mutex.hpp"
#include "gecos/media/medium.hpp"

/// The newest samples of a stream whose samples arrive as packets.
namespace gecos::media {

/// Keeps the newest samples of one stream. Thread-safe.
class SampleBuffer {
 public:
  /// `depth`: samples kept, at least 1.
  explicit SampleBuffer(std::size_t depth) : depth_(depth) {}

  /// Sequence number of the newest sample; 0 before the first. A sample that is not newer is never
  /// stored, so it need not be decrypted.
  std::uint64_t newest() const;
  /// Stores a copy of `sample`. A full buffer drops its oldest sample and reuses its memory.
  /// Returns false when `sequence` is not newer than the newest.
  bool put(std::uint64_t sequence, std::int64_t stamp_ns, ByteView sample);
  /// As StreamReader::latest() with `newest`, else as StreamReader::next().
  bool read(std::uint64_t after, bool newest, StreamSample& into);
  /// Whether a sample has arrived that neither a read nor an earlier call has seen.
  bool anything_new();

 private:
  const std::size_t depth_;
  mutable Mutex mutex_;
  std::deque<StreamSample> samples_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t seen_ GECOS_GUARDED_BY(mutex_) = 0;
};

/// A writer that lends private memory, because the medium copies, encrypts or splits every sample.
class CopyingWriter : public StreamWriter {
 public:
  /// `largest`: bytes of a sample.
  explicit CopyingWriter(std::size_t largest) : largest_(largest) {}
  tl::expected<std::span<std::byte>, SendProblem> lend(std::size_t size) override;
  void publish_lent(std::int64_t stamp_ns) override;

 private:
  const std::size_t largest_;
  Bytes lent_;
};

/// A reader that lends its own copy.
class CopyingReader : public StreamReader {
 public:
  std::optional<LentSample> lend_latest(std::uint64_t after) override;
  bool intact(const LentSample& /*sample*/) const override { return true; }

 private:
  StreamSample lent_;
};

}  // namespace gecos::media
