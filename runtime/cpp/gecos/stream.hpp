#pragma once

#include <chrono>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gecos/command.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/qos/reception.hpp"

namespace gecos {

/// The type of `gecos::stream`, an argument that subscribes to an attribute or event. Example:
/// `robot.tool(gecos::stream)`. Only events and attributes with the annotation @stream accept this
/// argument. For any other attribute, the error of the C++ compiler contains the name of this type.
struct StreamAnnotation {};
inline constexpr StreamAnnotation stream{};

/// One value of a stream.
template <class T>
struct Sample {
  T value{};
  std::uint64_t sequence = 0;  ///< rises by one per published sample
  /// The number of samples that were not read between the previously read sample and this sample.
  /// For the first sample of an event, the number counts from the subscription.
  std::uint64_t lost = 0;
  /// The time at which the value was measured, in s of Unix time by the server's clock; for display
  /// only.
  double stamp = 0;
  /// The time from measuring to reading. The age is exact on one host; between hosts, it is too
  /// large by at most one round trip. Setting a clock does not change the age.
  Duration age{};
};

/// One value of a stream that is read where its publisher wrote it, without a copy. Only the octets
/// of the struct's @bulk sequence are read in place: `value` has all other members, and its @bulk
/// sequence is empty. Over a medium without shared memory, the octets are in a private copy.
///
/// The memory stays readable as long as the sample or a copy of it exists, even after the end of
/// the stream and of its Lab. A publisher never waits for its readers: after as many further
/// samples as the `depth` of the stream, it overwrites the octets. Ask intact() after using them,
/// and discard the results if it returns false.
template <class T>
struct SampleInPlace {
  T value{};
  std::span<const std::uint8_t> octets{};  ///< elements of the @bulk sequence; empty if T has none
  /// This member and the next three members have the same meaning as in Sample.
  std::uint64_t sequence = 0;
  std::uint64_t lost = 0;
  double stamp = 0;
  Duration age{};
  media::LentSample memory{};  ///< owns the memory

  bool intact() const { return memory.intact(); }
};

/// The reason for which Stream::next() returned no sample.
enum class StreamEnd : std::uint8_t {
  Nothing,  ///< no valid sample arrived within the patience; the stream continues
  Lost,     ///< the stream is lost(), and all samples that had arrived were read
  Late,  ///< no sample came within `@qos(deadline=…)`. Returned once for each such silence; the
         ///< stream continues
  Revoked,  ///< lost, because the server no longer admits this user and has ended the session
};
std::string_view to_string(StreamEnd end);
std::ostream& operator<<(std::ostream& out, StreamEnd end);

namespace session {

struct RawSample : media::StreamSample {
  /// The time at which the sample was measured, by CLOCK_BOOTTIME of the reader's host. The time
  /// may be too early when another host sent the sample.
  TimePoint measured{};
  Duration age{};  ///< time from measuring to reading; never negative
};

/// A sample in the memory of its medium.
struct RawLent : media::LentSample {
  TimePoint measured{};  ///< has the same meaning as RawSample::measured
  Duration age{};
};

/// A subscription without the type of its samples.
class StreamCore {
 public:
  virtual ~StreamCore() = default;  ///< unsubscribes
  /// Stores the newest sample in `into`. Returns false before the first sample, when the stream is
  /// lost, and when the terms of the stream withhold the newest sample (qos::Reception).
  virtual bool latest(RawSample& into) = 0;
  /// Waits for the next unread sample and stores it in `into`. After a loss of the stream, returns
  /// the samples that had arrived before the loss. After the Lab was closed, returns no sample.
  virtual tl::expected<void, StreamEnd> next(RawSample& into, TimePoint deadline) = 0;
  /// Lends the newest sample, under the conditions of latest(). If the newest sample is the one
  /// with the number `into.sequence`, lends this sample once more.
  virtual bool lend_latest(RawLent& into) = 0;
  /// Lends the next unread sample, under the conditions of next(). Reads only the member
  /// `into.sequence` of `into`.
  virtual tl::expected<void, StreamEnd> lend_next(RawLent& into, TimePoint deadline) = 0;
  /// Returns the samples that are kept now, as Stream::history() does. Changes nothing of what
  /// next() and counts() return. At most one thread at a time may call this function, latest(),
  /// next() and the functions that lend a sample.
  virtual std::vector<RawSample> history() = 0;
  /// Ends the waits of the reader: from now on next() returns only the samples that have arrived,
  /// and then Nothing. Any thread may call this function.
  virtual void stop_waiting() = 0;
  virtual bool lost() const = 0;
  /// Returns why the stream was lost; an empty text if the program closed its Lab, and while the
  /// stream is not lost.
  virtual std::string loss_text() const = 0;
  /// Returns true if the stream is lost because the server no longer admits this user.
  virtual bool revoked() const = 0;
  /// For an event, returns the sequence number of the last sample before the subscription; reading
  /// begins with the sample after that one. For a stream, returns nullopt, because reading begins
  /// with the newest sample.
  virtual std::optional<std::uint64_t> after() const { return std::nullopt; }
  virtual qos::StreamCounts counts() const = 0;
  virtual bool alive() const = 0;
  /// Returns the stream and its object for messages, for example "stream 'pose' of RX90".
  virtual std::string title() const = 0;
};

/// Records how far a reader has read a stream, in place or by copies. Only one thread may use it at
/// a time.
class ReadPosition {
 public:
  explicit ReadPosition(std::uint64_t after) { sample_.sequence = after; }

  /// latest() and next() store the sample that they read in the member that sample() returns. They
  /// return what the functions of StreamCore with the same names return.
  bool latest(StreamCore& stream);
  tl::expected<void, StreamEnd> next(StreamCore& stream, TimePoint deadline);
  /// lend_latest() and lend_next() make `into` refer to the sample in the memory of its medium,
  /// without a copy.
  bool lend_latest(StreamCore& stream, RawLent& into);
  tl::expected<void, StreamEnd> lend_next(StreamCore& stream, RawLent& into, TimePoint deadline);
  /// Returns the sample that latest() or next() has read last. The memory of the sample is used
  /// again by the next read.
  const RawSample& sample() const { return sample_; }

 private:
  RawSample sample_;
  /// False if `sample_` has only the number, and not the value, of the sample that was read last.
  bool copied_ = true;
};

}  // namespace session

template <class T>
class Listener;

/// A subscription to a stream. Only one thread may read at a time. The subscription ends when its
/// last copy is destroyed. A slow reader misses old samples, and Sample::lost says how many; the
/// server never waits for a reader. A sample that is older than the `lifespan` of the stream is
/// never returned, and is counted (counts()). A sample that does not decode is skipped and counted
/// in `unreadable`. Such a sample also counts in Sample::lost if it belongs to an event or was
/// published after the first sample that was read.
template <class T>
class Stream {
 public:
  using Decode = bool (*)(wire::Decoder&, T&);
  Stream(std::shared_ptr<session::StreamCore> core, Decode decode)
      : core_(std::move(core)),
        decode_(decode),
        read_(core_->after()),
        position_(read_.value_or(0)) {}

  /// Returns the newest sample, even if it was read before. Returns nullopt before the first
  /// sample, while the newest sample does not decode or is older than the `lifespan`, while the
  /// writer is not alive(), and once the stream is lost(). Never waits. If the kernel reports the
  /// death of the server, the stream is lost within one heartbeat; otherwise, only after the server
  /// was silent for about `lease_ttl` + `grace`. Until then, only `age` shows that no new samples
  /// arrive.
  std::optional<Sample<T>> latest() {
    if (!position_.latest(*core_)) return std::nullopt;
    return decoded();
  }
  /// Returns the next unread sample and waits for it at most `patience`. A program that reads more
  /// slowly than the server publishes gets old samples; call `latest()` for the present value.
  tl::expected<Sample<T>, StreamEnd> next(Duration patience) {
    const TimePoint deadline = deadline_after(patience);
    for (;;) {
      if (auto got = position_.next(*core_, deadline); !got) return tl::unexpected(got.error());
      if (auto sample = decoded()) return *std::move(sample);
      if (std::chrono::steady_clock::now() >= deadline) return tl::unexpected(StreamEnd::Nothing);
    }
  }
  /// Returns the newest sample as latest() does, but without a copy of its @bulk sequence. Also
  /// returns nullopt if the writer has overwritten the sample meanwhile.
  std::optional<SampleInPlace<T>> latest_in_place() {
    session::RawLent lent;
    if (!position_.lend_latest(*core_, lent)) return std::nullopt;
    return decoded(lent);
  }
  /// Returns the next unread sample as next() does, but without a copy of its @bulk sequence.
  tl::expected<SampleInPlace<T>, StreamEnd> next_in_place(Duration patience) {
    const TimePoint deadline = deadline_after(patience);
    for (;;) {
      session::RawLent lent;
      auto got = position_.lend_next(*core_, lent, deadline);
      if (!got) return tl::unexpected(got.error());
      if (auto sample = decoded(lent)) return *std::move(sample);
      if (std::chrono::steady_clock::now() >= deadline) return tl::unexpected(StreamEnd::Nothing);
    }
  }
  /// Returns the samples that are kept now, oldest first: at most as many as the `depth` of the
  /// stream, and none that is older than its `lifespan`. Never waits. Leaves unchanged which sample
  /// next() returns next, and what counts() returns. Sample::lost is the number of samples missing
  /// between two samples of the history.
  ///
  /// Over inproc and shm, a history has the newest samples of the server, also those that were
  /// published before the subscription, but after the first subscription of any client over this
  /// medium. Over lcm, it has the samples that this reader has received, from the newest one at the
  /// subscription on. The history of an event begins after the subscription, over every medium.
  /// After a loss of the stream, the history stays, and no sample comes into it after the first
  /// look that found the loss; after the Lab was closed, it is empty. When the proxy has moved to
  /// another medium (`on_degraded="failover"`), the history begins again with the samples that the
  /// new medium keeps; until next() has read all samples of the old medium, the history has the
  /// samples of both.
  std::vector<Sample<T>> history() {
    std::vector<Sample<T>> kept;
    for (const session::RawSample& raw : core_->history()) {
      wire::Decoder from(raw.bytes);
      Sample<T> sample;
      if (!decode_(from, sample.value)) continue;
      take_place(sample, raw);
      sample.lost = kept.empty() ? 0 : raw.sequence - kept.back().sequence - 1;
      kept.push_back(std::move(sample));
    }
    return kept;
  }
  /// Returns true when the server is gone, is silent or has closed the session, or when the Lab was
  /// closed. Then latest() returns nullopt, and next() returns only the samples that had arrived
  /// before, or none if the Lab was closed.
  bool lost() const { return core_->lost(); }
  /// Returns a text for people that says why the stream is lost(). The text is empty if the stream
  /// is not lost, or if the Lab was closed.
  std::string loss_text() const { return core_->loss_text(); }
  /// Returns whether the writer was alive when the stream was last read. Returns false once the
  /// stream is lost(). With `@qos(liveliness=MANUAL)`, also returns false from a missed deadline
  /// until the next sample.
  bool alive() const { return core_->alive(); }
  /// Returns the counts of the samples since the first one that was read: how many were read, lost
  /// or withheld. Any thread may call this function.
  qos::StreamCounts counts() const { return core_->counts(); }
  /// Returns whether the samples are the occurrences of an event.
  bool is_event() const { return core_->after().has_value(); }
  /// Returns the number of samples that did not decode. The number rises only when the server is
  /// defective, because the opening of a stream fails when the server has another sample type.
  std::uint64_t unreadable() const { return unreadable_; }

 private:
  friend class Listener<T>;

  std::optional<Sample<T>> decoded() {
    const session::RawSample& raw = position_.sample();
    wire::Decoder from(raw.bytes);
    Sample<T> sample;
    if (!decode_(from, sample.value)) {
      note_unreadable(raw.sequence);
      return std::nullopt;
    }
    note_read(sample, raw);
    return sample;
  }

  std::optional<SampleInPlace<T>> decoded(session::RawLent& lent) {
    wire::Decoder from(lent.bytes);
    std::optional<ByteView> octets;
    from.keep_bulk(octets);
    SampleInPlace<T> sample;
    // If the writer has overwritten the sample meanwhile, a failure to decode it is no fault of the
    // server.
    if (!decode_(from, sample.value)) {
      if (lent.intact()) note_unreadable(lent.sequence);
      return std::nullopt;
    }
    if (!lent.intact()) return std::nullopt;
    note_read(sample, lent);
    if (octets) {
      const auto* const first = reinterpret_cast<const std::uint8_t*>(octets->data());
      sample.octets = std::span(first, octets->size());
    }
    sample.memory = std::move(lent);
    return sample;
  }

  void note_unreadable(std::uint64_t sequence) {
    if (sequence != last_unreadable_) ++unreadable_;
    last_unreadable_ = sequence;
  }
  void note_read(auto& sample, const auto& raw) {
    take_place(sample, raw);
    sample.lost = read_ && raw.sequence > *read_ + 1 ? raw.sequence - *read_ - 1 : 0;
    read_ = raw.sequence;
  }
  static void take_place(auto& sample, const auto& raw) {
    sample.sequence = raw.sequence;
    sample.stamp = static_cast<double>(raw.stamp_ns) * 1e-9;
    sample.age = raw.age;
  }

  std::shared_ptr<session::StreamCore> core_;
  Decode decode_;
  std::optional<std::uint64_t> read_;  ///< sequence number of the last sample that was read
  session::ReadPosition position_;
  std::uint64_t last_unreadable_ = 0;
  std::uint64_t unreadable_ = 0;
};

}  // namespace gecos
