#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "gecos/media/medium.hpp"
#include "gecos/session/command.hpp"

namespace gecos {

/// Tag of the subscribing overload of an outward stream: `robot.tool(gecos::stream)`.
struct StreamTag {};
inline constexpr StreamTag stream{};

/// One value of a stream.
template <class T>
struct Sample {
  T value{};
  std::uint64_t sequence = 0;  ///< rises by one per published sample
  std::uint64_t lost = 0;      ///< samples between the last one read and this one that were not read
  double stamp = 0;            ///< when it was measured, Unix time in s by the server's clock
  Duration age{};              ///< at reading; on one host exact, between hosts only as good as their clocks
};

/// Why a stream gives nothing more.
enum class StreamEnd : std::uint8_t {
  Nothing,  ///< no new sample within the patience given; the stream goes on
  Closed,   ///< the server closed it, or the lease that it needs is gone
  Lost,     ///< the server is gone or silent
};
std::string_view to_string(StreamEnd end);

namespace session {

/// A subscription without its type.
class StreamCore {
 public:
  virtual ~StreamCore() = default;  ///< unsubscribes
  virtual bool latest(media::StreamSample& into) = 0;
  virtual tl::expected<void, StreamEnd> next(media::StreamSample& into, TimePoint deadline) = 0;
  /// Now, by the clock that stamps samples, Unix ns.
  virtual std::int64_t now_ns() const = 0;
};

}  // namespace session

/// A subscription to an outward stream. One thread reads at a time. Ends with its last copy.
/// A slow reader loses old samples and is told how many; it never slows the writer.
template <class T>
class Stream {
 public:
  using Decode = bool (*)(wire::Decoder&, T&);
  Stream(std::shared_ptr<session::StreamCore> core, Decode decode)
      : core_(std::move(core)), decode_(decode) {}

  /// The newest sample; nothing before the first. Never waits.
  std::optional<Sample<T>> latest() {
    if (!core_->latest(raw_)) return std::nullopt;
    return decoded();
  }
  /// The next unread sample, waiting for it at most `patience`. It is old when you read more slowly
  /// than the server publishes; for what is true now, ask `latest()`.
  tl::expected<Sample<T>, StreamEnd> next(Duration patience) {
    if (auto got = core_->next(raw_, deadline_after(patience)); !got) {
      return tl::unexpected(got.error());
    }
    auto sample = decoded();
    if (!sample) return tl::unexpected(StreamEnd::Closed);
    return *sample;
  }

 private:
  std::optional<Sample<T>> decoded() {
    wire::Decoder from(raw_.bytes);
    Sample<T> sample;
    if (!decode_(from, sample.value)) return std::nullopt;
    sample.sequence = raw_.sequence;
    sample.lost = raw_.sequence > read_ + 1 && read_ != 0 ? raw_.sequence - read_ - 1 : 0;
    read_ = raw_.sequence;
    sample.stamp = static_cast<double>(raw_.stamp_ns) * 1e-9;
    sample.age = Duration(core_->now_ns() - raw_.stamp_ns);
    return sample;
  }

  std::shared_ptr<session::StreamCore> core_;
  Decode decode_;
  media::StreamSample raw_;
  std::uint64_t read_ = 0;
};

}  // namespace gecos
