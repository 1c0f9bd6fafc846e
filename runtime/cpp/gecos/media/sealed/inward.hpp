#pragma once

#include <atomic>
#include <memory>

#include "gecos/base/fork_watch.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/buffers/sample_buffer.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/sender.hpp"

/// Streams from a client to its server. The client sends their samples on the sealed channel of the
/// connection.
namespace gecos::media {

/// Sends the samples of one stream from a client to its server. Thread-safe.
class InwardStream {
 public:
  /// `largest` is the largest size of a sample in bytes. `depth` is the number of samples that the
  /// reader keeps. Throws std::runtime_error when the medium cannot keep so many.
  InwardStream(std::shared_ptr<SealedSender> sender, const SealedOptions& options,
               std::size_t largest, std::size_t depth);

  /// Shares this stream under the number `id` from now on. Returns the announcement that the server
  /// must receive.
  InwardShare shared_as(std::uint32_t id);
  std::size_t largest() const { return largest_; }
  tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns);
  /// Sends the last sample again, for a reader that opened the stream after that sample was sent.
  void repeat_last();
  std::uint64_t newest() const {
    const MutexLock lock(mutex_);
    return sequence_;
  }
  /// Stops the sending of samples. Must be called when the connection is closed.
  void end() { ended_.store(true); }

 private:
  void send_last() GECOS_REQUIRES(mutex_);

  const std::shared_ptr<SealedSender> sender_;
  const SealedOptions options_;
  const std::uint32_t largest_;  // bytes
  const std::uint16_t depth_;
  mutable Mutex mutex_;
  std::uint32_t id_ GECOS_GUARDED_BY(mutex_) = 0;
  bool shared_ GECOS_GUARDED_BY(mutex_) = false;
  std::uint64_t sequence_ GECOS_GUARDED_BY(mutex_) = 0;
  std::int64_t stamp_ns_ GECOS_GUARDED_BY(mutex_) = 0;
  Bytes last_ GECOS_GUARDED_BY(mutex_);
  Bytes datagram_ GECOS_GUARDED_BY(mutex_);
  /// True after end(), and in a forked child. A forked child must not seal samples, because it
  /// would use the nonce counters of its parent again.
  std::atomic<bool> ended_{false};
  const ForkWatch fork_watch_;
};

class InwardWriter final : public CopyingWriter {
 public:
  explicit InwardWriter(std::shared_ptr<InwardStream> stream)
      : CopyingWriter(stream->largest()), stream_(std::move(stream)) {}
  tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns) override {
    return stream_->publish(sample, stamp_ns);
  }
  std::uint64_t newest() const override { return stream_->newest(); }
  void number_after(std::uint64_t /*newest*/) override {}  // an inward stream has one medium
  const std::shared_ptr<InwardStream>& stream() const { return stream_; }

 private:
  const std::shared_ptr<InwardStream> stream_;
};

/// Reads the samples that a client sends on one of its streams, at the server's end of the
/// connection.
class InwardReader final : public CopyingReader {
 public:
  explicit InwardReader(std::shared_ptr<SampleBuffer> samples) : samples_(std::move(samples)) {}
  bool latest(std::uint64_t after, StreamSample& into) override {
    return samples_->read(after, true, into);
  }
  bool next(std::uint64_t after, StreamSample& into) override {
    return samples_->read(after, false, into);
  }
  std::vector<StreamSample> stored() override { return samples_->stored(); }

 private:
  const std::shared_ptr<SampleBuffer> samples_;
};

}  // namespace gecos::media
