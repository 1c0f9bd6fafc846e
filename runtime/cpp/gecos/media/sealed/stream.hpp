#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/crypto/stream_seal.hpp"
#include "gecos/media/buffers/sample_buffer.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/network.hpp"

namespace gecos::media {

/// Sends each sample of a stream once for all readers. The channel and the key are used by this
/// stream only.
class SealedStream {
 public:
  SealedStream(std::shared_ptr<DatagramPort> port, SharedStream where);

  /// Returns the channel of the samples, and the key by which a reader decrypts them.
  SharedStream where() const;
  /// Returns how often move_on() was called. An announcement and its answer carry this number, so
  /// that an answer to an earlier announcement does not count.
  std::uint32_t generation() const { return generation_.load(std::memory_order_acquire); }
  /// Seals all later samples under new keys, which the connections that share the stream send to
  /// their readers. Forgets the last sample. Any thread may call this function.
  void move_on();
  tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns);
  /// Sends the last sample again, for readers that subscribed after the sample was sent. Other
  /// readers ignore the repetition. Any thread may call this function.
  void repeat_last();
  std::uint64_t newest() const;
  /// See StreamWriter::number_after.
  void number_after(std::uint64_t newest);

 private:
  const std::shared_ptr<DatagramPort> port_;
  mutable Mutex mutex_;
  crypto::StreamSealer sealer_ GECOS_GUARDED_BY(mutex_);
  SharedStream where_ GECOS_GUARDED_BY(mutex_);
  std::atomic<std::uint32_t> generation_{0};  // published after the keys of that generation
  const std::size_t largest_;
  const std::string channel_;
  Bytes last_ GECOS_GUARDED_BY(mutex_);  // the last datagram sent
};

class SealedStreamWriter final : public CopyingWriter {
 public:
  explicit SealedStreamWriter(std::shared_ptr<SealedStream> stream)
      : CopyingWriter(stream->where().largest), stream_(std::move(stream)) {}
  tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns) override {
    return stream_->publish(sample, stamp_ns);
  }
  std::uint64_t newest() const override { return stream_->newest(); }
  void number_after(std::uint64_t newest) override { stream_->number_after(newest); }
  void move_on() override { stream_->move_on(); }
  const std::shared_ptr<SealedStream>& stream() const { return stream_; }

 private:
  const std::shared_ptr<SealedStream> stream_;
};

/// The newest samples of a stream that this program reads. The thread that reads `port` stores them
/// here.
class SampleQueue {
 public:
  /// Every new sample wakes `sleeper`.
  SampleQueue(std::shared_ptr<DatagramPort> port, const SharedStream& where,
              std::weak_ptr<Sleeper> sleeper);

  void take(ByteView datagram);
  /// Sets the key that decrypts all later samples, because the writer now seals them under a new
  /// key.
  void take_key(const crypto::StreamKey& key);
  bool read(std::uint64_t after, bool newest, StreamSample& into);
  std::vector<StreamSample> stored();
  /// Returns whether a sample has arrived that neither the reader nor an earlier call has seen.
  bool anything_new();

 private:
  const std::shared_ptr<DatagramPort> port_;
  const std::weak_ptr<Sleeper> sleeper_;
  SampleBuffer samples_;
  Mutex mutex_;
  crypto::StreamOpener opener_ GECOS_GUARDED_BY(mutex_);
  Bytes frame_ GECOS_GUARDED_BY(mutex_);
};

class SealedStreamReader final : public CopyingReader {
 public:
  /// Makes `port` store the samples of `channel` in `queue`, as long as the reader exists. @pre
  /// `queue` holds `port`.
  static tl::expected<std::unique_ptr<SealedStreamReader>, MediumError> open(
      const std::shared_ptr<SampleQueue>& queue, DatagramPort& port, const std::string& channel);
  ~SealedStreamReader() override { port_.unsubscribe(subscription_); }
  bool latest(std::uint64_t after, StreamSample& into) override {
    return queue_->read(after, true, into);
  }
  bool next(std::uint64_t after, StreamSample& into) override {
    return queue_->read(after, false, into);
  }
  std::vector<StreamSample> stored() override { return queue_->stored(); }

 private:
  SealedStreamReader(std::shared_ptr<SampleQueue> queue, DatagramPort& port,
                     std::uint64_t subscription)
      : queue_(std::move(queue)), port_(port), subscription_(subscription) {}

  const std::shared_ptr<SampleQueue> queue_;
  DatagramPort& port_;
  const std::uint64_t subscription_;
};

/// Returns the name of a channel: `prefix` and the number in 16 hex digits, for example
/// "GS0123456789abcdef".
std::string channel_name(std::string_view prefix, std::uint64_t number);
/// Returns a random number that is not 0. The probability that another program draws the same
/// number is negligible.
std::uint64_t draw_number();
/// Returns a random port number from 20000 to 32000. These numbers are below the range of ephemeral
/// ports, and two programs rarely draw the same number.
std::uint16_t draw_port();

}  // namespace gecos::media
