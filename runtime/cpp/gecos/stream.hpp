#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "gecos/command.hpp"
#include "gecos/media/medium.hpp"

namespace gecos {

/// Tag of the subscribing overload of an outward stream: `robot.tool(gecos::stream)`.
struct StreamTag {};
inline constexpr StreamTag stream{};

/// One value of a stream.
template <class T>
struct Sample {
  T value{};
  std::uint64_t sequence = 0;  ///< rises by one per published sample
  std::uint64_t lost = 0;  ///< samples between the last one read and this one that were not read
  double stamp = 0;  ///< for people: when it was measured, Unix time in s by the server's clock
  Duration age{};  ///< since it was measured, at reading; no clock that is set changes it. Exact on
                   ///< one host; between hosts at least that, and at most a round trip more
};

/// Why a stream gives nothing more.
enum class StreamEnd : std::uint8_t {
  Nothing,  ///< no new sample that decodes within the patience given; the stream goes on
  Lost,     ///< as Stream::lost(), and what had come before is read
};
std::string_view to_string(StreamEnd end);

namespace session {

struct RawSample : media::StreamSample {
  TimePoint measured{};  ///< by our CLOCK_BOOTTIME; between hosts not later than it was
};

/// A subscription without its type.
class StreamCore {
 public:
  virtual ~StreamCore() = default;  ///< unsubscribes
  /// False before the first sample, and when the stream is lost.
  virtual bool latest(RawSample& into) = 0;
  /// What had come before a loss is still given, but nothing after the Lab was closed.
  virtual tl::expected<void, StreamEnd> next(RawSample& into, TimePoint deadline) = 0;
  virtual bool lost() const = 0;
  /// Since it was measured; never negative.
  virtual Duration age(const RawSample& sample) const = 0;
};

}  // namespace session

/// A subscription to an outward stream. One thread reads at a time. Ends with its last copy.
/// A slow reader loses old samples and gets their number; it never slows the writer. A sample that
/// does not decode is passed over: it counts as lost (once one was read), and as `unreadable`.
template <class T>
class Stream {
 public:
  using Decode = bool (*)(wire::Decoder&, T&);
  Stream(std::shared_ptr<session::StreamCore> core, Decode decode)
      : core_(std::move(core)), decode_(decode) {}

  /// The newest sample, again if need be; nothing before the first, while the newest does not
  /// decode, and once the stream is lost(). A server that is gone is noticed within a heartbeat
  /// where the kernel reports it, else only after its silence has lasted `grace`: until then look
  /// at `age`. Never waits.
  std::optional<Sample<T>> latest() {
    if (!core_->latest(raw_)) return std::nullopt;
    return decoded();
  }
  /// The next unread sample, waiting for it at most `patience`. It is old when you read more slowly
  /// than the server publishes; for what is true now, ask `latest()`.
  tl::expected<Sample<T>, StreamEnd> next(Duration patience) {
    const TimePoint deadline = deadline_after(patience);
    for (;;) {
      if (auto got = core_->next(raw_, deadline); !got) return tl::unexpected(got.error());
      if (auto sample = decoded()) return *std::move(sample);
      if (std::chrono::steady_clock::now() >= deadline) return tl::unexpected(StreamEnd::Nothing);
    }
  }
  /// The server is gone, silent or has closed the session, or the Lab was closed: latest() gives
  /// nothing any more, next() what had come before, but nothing of a Lab that was closed.
  bool lost() const { return core_->lost(); }
  /// How many samples came that do not decode. Their server is broken: one that means another type
  /// is refused when the stream is opened.
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
