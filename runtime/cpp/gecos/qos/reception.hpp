#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "gecos/qos/quality.hpp"

namespace gecos::qos {

/// The counts of the samples of one subscription, and of the deadlines that its stream missed.
struct StreamCounts {
  std::uint64_t received = 0;  ///< samples that were read, each counted once
  std::uint64_t lost = 0;      ///< overwritten before next() came to them, or lost on the way
  std::uint64_t skipped = 0;   ///< passed over by latest(), which returned a newer one
  std::uint64_t expired = 0;   ///< older than the lifespan when they came to be read; not returned
  std::uint64_t missed_deadlines = 0;  ///< periods of the deadline that passed without a sample

  friend bool operator==(const StreamCounts&, const StreamCounts&) = default;
};

/// Judges the samples that one reader of a stream reads, by the terms `lifespan`, `deadline` and
/// `liveliness` of the stream, and counts them. Reads no clock: the caller passes the time of one
/// clock. Allocates and locks nothing. One thread at a time may read; any thread may call counts()
/// and writer_alive().
///
/// A gap between two samples is the time between their measurements, and is judged when the reader
/// has read both. The times of unread samples are unknown, so a gap in the sequence numbers is
/// never a missed deadline. While no sample comes, the gap is measured from the moment at which the
/// last sample was read; before the first sample, from the subscription. The gap before the first
/// sample that is read counts only if no sample since the subscription is older.
class Reception {
 public:
  /// How the reader obtained a sample. The unread samples before it count as lost (InOrder) or as
  /// skipped (Newest).
  enum class Way : std::uint8_t { InOrder, Newest };

  /// `newest`: the sequence number of the newest sample at the subscription. `after`: the reader
  /// expects only samples with a sequence number above `after`. Without a value, the reader may
  /// begin with any sample.
  Reception(const Quality& terms, TimePoint opened, std::uint64_t newest,
            std::optional<std::uint64_t> after);

  /// Judges a sample that was not read before. Returns whether the reader may get the sample.
  bool take(Way way, std::uint64_t sequence, TimePoint measured, TimePoint now);
  /// Must be called when there is no unread sample at the time `now`.
  void find_nothing(TimePoint now);
  /// Returns whether a sample that was measured at `measured` is older than the lifespan at `now`.
  /// Any thread may call this function.
  bool expired(TimePoint measured, TimePoint now) const {
    return lifespan_ > Duration{} && now - measured > lifespan_;
  }
  /// Returns whether the reader may get the last sample once more at the time `now`.
  bool still_valid(TimePoint now) const;
  /// Returns true once after find_nothing() has found that a deadline has passed without a sample.
  /// Returns true again only after a further sample and a further deadline that has passed.
  bool report_late();
  /// Returns the time from which find_nothing() makes report_late() return true. Returns
  /// TimePoint::max() without a deadline, and when report_late() has already reported the present
  /// silence.
  TimePoint late_at() const;
  /// Returns whether the writer was alive when the stream was last read. With liveliness=MANUAL, a
  /// writer that misses its deadline is not alive until its next sample. With other values of
  /// liveliness, always returns true.
  bool writer_alive() const;
  StreamCounts counts() const;

 private:
  /// A number that one thread changes and any thread reads. The atomic orders no other memory.
  class Count {
   public:
    std::uint64_t get() const { return value_.load(std::memory_order_relaxed); }
    void add(std::uint64_t more) { value_.store(get() + more, std::memory_order_relaxed); }
    void reset() { value_.store(0, std::memory_order_relaxed); }

   private:
    std::atomic<std::uint64_t> value_{0};
  };

  std::uint64_t periods_in(Duration gap) const;
  void count_missed(std::uint64_t in_this_gap);

  const Duration lifespan_;
  const Duration deadline_;
  const bool manual_;
  const std::uint64_t newest_at_first_;  ///< sequence number, at the subscription
  std::optional<std::uint64_t> last_;    ///< sequence number
  TimePoint measured_{};                 ///< when the last sample was measured
  TimePoint gap_from_;     ///< the latest measurement of a sample, at first the subscription
  TimePoint silent_from_;  ///< when the last sample was read, at first the subscription
  bool reported_ = false;  ///< whether report_late() has returned true for this gap
  Count missed_here_;      ///< periods of this gap that were counted
  Count received_, lost_, skipped_, expired_, missed_;
};

}  // namespace gecos::qos
