// The time at which a sample was measured. The age of a sample is computed with CLOCK_BOOTTIME,
// because nobody can set that clock. The wall-clock time of the measurement is only for display.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/description.hpp"
#include "gecos/wire/decoder.hpp"
#include "gecos/wire/encoder.hpp"

namespace gecos::session {

/// The assumed maximum difference between two clocks: 36 years. Times that a peer sends are clamped
/// to this range.
inline constexpr Duration longest_age{std::int64_t{1} << 60};

/// The time at which a sample was measured, by two clocks: wall-clock time in ns, and
/// CLOCK_BOOTTIME.
struct SampleTime {
  std::int64_t stamp_ns = 0;
  TimePoint measured{};
};

/// Converts `stamp_ns`, a wall-clock time that the servant sets, to the same moment by
/// CLOCK_BOOTTIME, and returns both. Reads the time when it is called.
inline SampleTime sample_time(std::int64_t stamp_ns, const Clock& clock) {
  const auto [wall, now] = clock.by_both();
  if (stamp_ns == measured_now) return {wall.count(), now};
  const auto stamp = std::clamp(Duration(stamp_ns), -4 * longest_age, 4 * longest_age);
  return {stamp_ns, now - std::clamp(wall - stamp, Duration::zero(), longest_age)};
}

/// Size in bytes of the measurement time that is appended to each sample before it is sent. That
/// time is in ns of the server's CLOCK_BOOTTIME.
inline constexpr std::size_t measured_bytes = 8;

inline void write_measured(std::span<std::byte, measured_bytes> to, TimePoint measured) {
  wire::Encoder(to).put(static_cast<std::int64_t>(measured.time_since_epoch().count()));
}

inline void append_measured(Bytes& sample, TimePoint measured) {
  sample.resize(sample.size() + measured_bytes);
  write_measured(std::span(sample).last<measured_bytes>(), measured);
}

/// Removes the appended measurement time from `sample` and returns it; nullopt when `sample` is too
/// short to have one.
inline std::optional<TimePoint> take_measured(ByteView& sample) {
  if (sample.size() < measured_bytes) return std::nullopt;
  std::int64_t measured = 0;
  wire::Decoder from(sample.last(measured_bytes));
  if (!from.get(measured, "measured")) return std::nullopt;
  sample = sample.first(sample.size() - measured_bytes);
  return TimePoint(std::clamp(Duration(measured), -longest_age, longest_age));
}

inline std::optional<TimePoint> take_measured(Bytes& sample) {
  ByteView rest(sample);
  const auto measured = take_measured(rest);
  sample.resize(rest.size());
  return measured;
}

}  // namespace gecos::session
