#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/media/medium.hpp"

/// A buffer for the newest samples of a stream whose samples arrive as packets, and the base
/// classes of its writers and readers.
namespace gecos::media {

/// Keeps the newest samples of one stream. Thread-safe.
class SampleBuffer {
 public:
  /// `depth` is the number of samples that the buffer keeps. @pre `depth` is at least 1
  explicit SampleBuffer(std::size_t depth) : depth_(depth) {}

  /// Returns the sequence number of the newest sample; 0 before the first sample. The buffer stores
  /// only samples with a larger number, so the caller need not decrypt other samples.
  std::uint64_t newest() const;
  /// Stores a copy of `sample`. A full buffer drops its oldest sample and uses the memory of that
  /// sample again. Returns false and stores nothing when `sequence` is not larger than newest().
  bool put(std::uint64_t sequence, std::int64_t stamp_ns, ByteView sample);
  /// Reads a sample like StreamReader::latest() if `newest` is true; otherwise like
  /// StreamReader::next().
  bool read(std::uint64_t after, bool newest, StreamSample& into);
  /// Returns copies of all stored samples, oldest first.
  std::vector<StreamSample> stored() const;
  /// Returns whether a sample has arrived that neither read() nor an earlier call of this function
  /// has seen.
  bool anything_new();

 private:
  const std::size_t depth_;
  mutable Mutex mutex_;
  std::deque<StreamSample> samples_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t seen_ GECOS_GUARDED_BY(mutex_) = 0;
};

/// A stream writer that lends private memory, because its medium copies, encrypts or splits every
/// sample.
class CopyingWriter : public StreamWriter {
 public:
  /// `largest` is the largest size of a sample in bytes.
  explicit CopyingWriter(std::size_t largest) : largest_(largest) {}
  std::size_t largest() const override { return largest_; }
  tl::expected<std::span<std::byte>, SendProblem> lend(std::size_t size) override;
  void publish_lent(std::int64_t stamp_ns) override;

 private:
  const std::size_t largest_;
  Bytes lent_;
};

/// A stream reader that lends a private copy of the sample.
class CopyingReader : public StreamReader {
 public:
  std::optional<LentSample> lend_latest(std::uint64_t after) override;
  std::optional<LentSample> lend_next(std::uint64_t after) override;

 private:
  StreamSample& unused_sample();
  std::optional<LentSample> lend() const;

  /// The sample that was lent last. Its memory is used again when the borrower no longer uses the
  /// sample.
  std::shared_ptr<StreamSample> lent_;
};

}  // namespace gecos::media
