#pragma once

#include <chrono>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "gecos/command.hpp"
#include "gecos/media/medium.hpp"

namespace gecos {

/// Type of the tag that selects the subscribing overload of an attribute:
/// `robot.tool(gecos::stream)`. An attribute without @stream has no such overload; then the
/// compiler names this type.
struct only_attributes_with_the_annotation_stream {};
using StreamTag = only_attributes_with_the_annotation_stream;
inline constexpr only_attributes_with_the_annotation_stream stream{};

/// One value of a stream.
template <class T>
struct Sample {
  T value{};
  std::uint64_t sequence = 0;  ///< rises by one per published sample
  std::uint64_t lost = 0;      ///< unread samples between the previously read sample and this one
  double stamp = 0;  ///< when the value was measured: Unix time in s of the server, for display
  Duration age{};    ///< time from measuring to reading; setting a clock does not change it.
                     ///< Exact on one host; between hosts too large by at most a round trip
};

/// Why Stream::next() gave no sample.
enum class StreamEnd : std::uint8_t {
  Nothing,  ///< the patience has passed without a valid sample; the stream goes on
  Lost,     ///< the stream is lost(), and all samples that had arrived were read
};
std::string_view to_string(StreamEnd end);
std::ostream& operator<<(std::ostream& out, StreamEnd end);

namespace session {

struct RawSample : media::StreamSample {
  /// By CLOCK_BOOTTIME of the reader's host; may be too early when another host sent the sample.
  TimePoint measured{};
};

/// A subscription without the type of its samples.
class StreamCore {
 public:
  virtual ~StreamCore() = default;  ///< unsubscribes
  /// Stores the newest sample in `into`. False before the first sample, and when the stream is
  /// lost.
  virtual bool latest(RawSample& into) = 0;
  /// Waits for the next unread sample. After a loss the samples that had arrived before are still
  /// given; after the Lab was closed, none are.
  virtual tl::expected<void, StreamEnd> next(RawSample& into, TimePoint deadline) = 0;
  virtual bool lost() const = 0;
  /// Time since the sample was measured; never negative.
  virtual Duration age(const RawSample& sample) const = 0;
};

}  // namespace session

/// A subscription to a stream. Only one thread may read at a time. The subscription ends when its
/// last copy is destroyed. A slow reader misses old samples and learns how many; it never slows the
/// writer. A sample that does not decode is skipped and counted in `unreadable`. After the first
/// sample that was read, a skipped sample also counts as lost.
template <class T>
class Stream {
 public:
  using Decode = bool (*)(wire::Decoder&, T&);
  Stream(std::shared_ptr<session::StreamCore> core, Decode decode)
      : core_(std::move(core)), decode_(decode) {}

  /// The newest sample, even if it was read before. Nothing before the first sample, while the
  /// newest one does not decode, and once the stream is lost(). Never waits. A dead server is
  /// detected within a heartbeat when the kernel reports its death, else after a silence of
  /// `grace`. Until then check `age`.
  std::optional<Sample<T>> latest() {
    if (!core_->latest(raw_)) return std::nullopt;
    return decoded();
  }
  /// The next unread sample, waiting for it at most `patience`. The sample is old when you read
  /// more slowly than the server publishes; for the present value call `latest()`.
  tl::expected<Sample<T>, StreamEnd> next(Duration patience) {
    const TimePoint deadline = deadline_after(patience);
    for (;;) {
      if (auto got = core_->next(raw_, deadline); !got) return tl::unexpected(got.error());
      if (auto sample = decoded()) return *std::move(sample);
      if (std::chrono::steady_clock::now() >= deadline) return tl::unexpected(StreamEnd::Nothing);
    }
  }
  /// True when the server is gone, is silent or has closed the session, or the Lab was closed. Then
  /// latest() gives nothing. next() gives only the samples that had arrived before, and none once
  /// the Lab was closed.
  bool lost() const { return core_->lost(); }
  /// Number of samples that did not decode. It rises only when the server is defective: a server
  /// with another sample type is refused when the stream is opened.
  std::uint64_t unreadable() const { return unreadable_; }

 private:
  std::optional<Sample<T>> decoded() {
    wire::Decoder from(raw_.bytes);
    Sample<T> sample;
    if (!decode_(from, sample.value)) {
      if (raw_.sequence != last_unreadable_) ++unreadable_;
      last_unreadable_ = raw_.sequence;
      return std::nullopt;
    }
    sample.sequence = raw_.sequence;
    sample.lost = raw_.sequence > read_ + 1 && read_ != 0 ? raw_.sequence - read_ - 1 : 0;
    read_ = raw_.sequence;
    sample.stamp = static_cast<double>(raw_.stamp_ns) * 1e-9;
    sample.age = core_->age(raw_);
    return sample;
  }

  std::shared_ptr<session::StreamCore> core_;
  Decode decode_;
  session::RawSample raw_;
  std::uint64_t read_ = 0;
  std::uint64_t last_unreadable_ = 0;
  std::uint64_t unreadable_ = 0;
};

}  // namespace gecos
