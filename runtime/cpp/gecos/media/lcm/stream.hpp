#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "gecos/crypto/stream_seal.hpp"
#include "gecos/media/lcm/datagram.hpp"
#include "gecos/media/lcm/port.hpp"
#include "gecos/media/sample_buffer.hpp"
#include "gecos/media/stream_ring.hpp"

namespace gecos::media {

/// Sends a stream once for all its readers, on a channel of its own and under a key of its own.
class LcmStream {
 public:
  LcmStream(std::shared_ptr<LcmPort> port, SharedStream where);

  const SharedStream& where() const { return where_; }
  tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns);
  /// For who came late. Readers who have it already see nothing new. Any thread.
  void repeat_last();

 private:
  const std::shared_ptr<LcmPort> port_;
  crypto::StreamSealer sealer_;
  const SharedStream where_;
  const std::string channel_;
  std::mutex mutex_;
  Bytes last_;  // as it was sent
};

class LcmStreamWriter final : public CopyingWriter {
 public:
  explicit LcmStreamWriter(std::shared_ptr<LcmStream> stream)
      : CopyingWriter(stream->where().largest), stream_(std::move(stream)) {}
  tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns) override {
    return stream_->publish(sample, stamp_ns);
  }
  const std::shared_ptr<LcmStream>& stream() const { return stream_; }

 private:
  const std::shared_ptr<LcmStream> stream_;
};

/// The newest samples of a stream that is being read, filled by whoever pumps `port`.
class LcmStreamInbox {
 public:
  /// `sleeper` is woken with every new sample.
  LcmStreamInbox(std::shared_ptr<LcmPort> port, const SharedStream& where,
                 std::weak_ptr<Sleeper> sleeper);

  void take(ByteView datagram);
  bool read(std::uint64_t after, bool newest, StreamSample& into);
  /// A sample came that neither the reader nor an earlier call has seen.
  bool anything_new();

 private:
  const std::shared_ptr<LcmPort> port_;
  const std::weak_ptr<Sleeper> sleeper_;
  SampleBuffer samples_;
  std::mutex mutex_;  // guards what follows
  crypto::StreamOpener opener_;
  Bytes frame_;
};

class LcmStreamReader final : public CopyingReader {
 public:
  explicit LcmStreamReader(std::shared_ptr<LcmStreamInbox> inbox) : inbox_(std::move(inbox)) {}
  bool latest(std::uint64_t after, StreamSample& into) override {
    return inbox_->read(after, true, into);
  }
  bool next(std::uint64_t after, StreamSample& into) override {
    return inbox_->read(after, false, into);
  }

 private:
  const std::shared_ptr<LcmStreamInbox> inbox_;
};

/// "GS0123456789abcdef"
std::string lcm_channel(std::string_view prefix, std::uint64_t number);
/// A number that nobody else has drawn.
std::uint64_t draw_number();
/// A port below the kernel's own choices, from a range that is wide enough to be mostly alone.
std::uint16_t draw_port();

}  // namespace gecos::media
