#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/media/medium.hpp"

/// A stream in memory that has one writer and any number of readers. The readers never write to the
/// memory.
///
/// Each sample has a slot with a version. The version is odd while the writer writes the sample. A
/// reader copies the sample and then checks that the version has not changed. The number of tries
/// is limited, so that a writer that died during a write cannot block a reader. Readers write
/// nothing, so that they can neither slow down the writer nor disturb each other.
namespace gecos::media {

/// The memory of a stream.
struct StreamMemory {
  std::byte* base = nullptr;
  std::size_t largest = 0;  ///< largest size of a sample in bytes
  std::size_t depth = 0;    ///< number of samples kept, without the one that is being written

  static constexpr std::size_t most_bytes = std::size_t{1} << 30;
  static constexpr std::size_t slot_bytes(std::size_t largest) {
    return (24 + largest + 63) / 64 * 64;
  }
  static constexpr std::size_t bytes(std::size_t largest, std::size_t depth) {
    return 64 + (depth + 1) * slot_bytes(largest);
  }
  std::atomic<std::uint64_t>& newest() const;
  std::atomic<std::uint64_t>* slot(std::uint64_t sequence) const;
};

/// The interface of a reader that may sleep until the next sample.
class Sleeper {
 public:
  virtual ~Sleeper() = default;
  /// Wakes the reader if it sleeps. Any thread may call this function.
  virtual void wake_if_asleep() = 0;
};

/// The list of the readers that the writer of a stream must wake. Thread-safe, but only one thread
/// at a time may call `wake`. A destroyed reader leaves the list at the next `add` or `remove`.
class SleeperList {
 public:
  void add(std::weak_ptr<Sleeper> sleeper);
  /// A call of `wake` that has begun already may still wake `sleeper`.
  void remove(const Sleeper* sleeper);
  /// Wakes the readers that sleep. Allocates nothing, and takes the mutex only after a change.
  void wake();

 private:
  void publish_change() GECOS_REQUIRES(mutex_);

  FutexMutex mutex_;
  std::vector<std::weak_ptr<Sleeper>> sleepers_ GECOS_GUARDED_BY(mutex_);
  /// What `woken_` must become; `wake` takes it when `changed_` is true.
  std::vector<std::weak_ptr<Sleeper>> next_ GECOS_GUARDED_BY(mutex_);
  std::atomic<bool> changed_{false};
  std::vector<std::weak_ptr<Sleeper>> woken_;  ///< used only by `wake`
};

class StreamRingWriter : public StreamWriter {
 public:
  /// `owner` keeps `memory` alive. @pre all bytes of `memory` are zero.
  StreamRingWriter(StreamMemory memory, std::shared_ptr<void> owner);
  std::size_t largest() const override { return memory_.largest; }
  tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns) override;
  tl::expected<std::span<std::byte>, SendProblem> lend(std::size_t size) override;
  void publish_lent(std::int64_t stamp_ns) override;
  std::shared_ptr<void> lent_owner() const override { return owner_; }
  ByteView newest_sample() const override;
  std::uint64_t newest() const override { return newest_; }
  void number_after(std::uint64_t newest) override { newest_ = newest; }

  const StreamMemory& memory() const { return memory_; }
  const std::shared_ptr<void>& owner() const { return owner_; }
  const std::shared_ptr<SleeperList>& sleepers() const { return sleepers_; }

 protected:
  /// Makes the writer continue in `memory`, which has the same size as its present memory, and
  /// copies the stored samples into `memory`. A borrower of lent memory keeps its place in the old
  /// memory; publish_lent() then copies the borrower's sample into `memory`.
  void move_to(StreamMemory memory, std::shared_ptr<void> owner);

 private:
  StreamMemory memory_;
  std::shared_ptr<void> owner_;
  void complete(std::uint64_t sequence);
  void take_lent_back();

  const std::shared_ptr<SleeperList> sleepers_ = std::make_shared<SleeperList>();
  std::uint64_t newest_ = 0;
  std::span<std::byte> lent_;         ///< empty if no memory is lent
  std::shared_ptr<void> lent_owner_;  ///< keeps `lent_` valid; null if it is in `memory_`
};

/// The state of a stream that this end of a connection reads. The reader of the stream uses this
/// object, and so does the thread that reads the connection.
class StreamWatch {
 public:
  struct Place {
    StreamMemory memory;
    std::shared_ptr<void> owner;  ///< keeps `memory` alive
  };
  StreamWatch(StreamMemory memory, std::shared_ptr<void> owner);

  /// Must be called when the writer of the stream continues in other memory.
  void move_to(StreamMemory memory, std::shared_ptr<void> owner);
  /// Returns whether move_to() was called since the last call of place().
  bool moved() const { return moved_.load(std::memory_order_acquire); }
  std::shared_ptr<const Place> place();
  /// Returns the sequence number of the newest sample. The load is sequentially consistent.
  std::uint64_t newest();

  /// StreamRingReader::next() returns only samples whose sequence number is larger than this
  /// number. Older samples in the shared memory are for readers that have subscribed earlier.
  const std::uint64_t past;
  /// Sequence number of the newest sample that the reader or Connection::prepare_to_sleep() has
  /// seen. With this number, prepare_to_sleep() knows whether a newer sample has arrived.
  std::atomic<std::uint64_t> seen{0};

 private:
  Mutex mutex_;
  std::shared_ptr<const Place> place_ GECOS_GUARDED_BY(mutex_);
  std::atomic<bool> moved_{false};  // tells the reader to take place_, which is published before
};

class StreamRingReader : public StreamReader {
 public:
  explicit StreamRingReader(std::shared_ptr<StreamWatch> watch)
      : watch_(std::move(watch)), place_(watch_->place()) {}
  bool latest(std::uint64_t after, StreamSample& into) override;
  bool next(std::uint64_t after, StreamSample& into) override;
  std::optional<LentSample> lend_latest(std::uint64_t after) override;
  std::optional<LentSample> lend_next(std::uint64_t after) override;
  std::vector<StreamSample> stored() override;

 private:
  const StreamMemory& memory_now();
  std::optional<LentSample> lend(std::uint64_t sequence) const;

  const std::shared_ptr<StreamWatch> watch_;
  std::shared_ptr<const StreamWatch::Place> place_;
};

/// The streams that one end of a connection reads. Thread-safe.
class StreamWatches {
 public:
  std::unique_ptr<StreamReader> open(StreamMemory memory, std::shared_ptr<void> owner);
  /// Like open(), but the caller must make the reader, from the StreamWatch that this function
  /// returns.
  std::shared_ptr<StreamWatch> watch(StreamMemory memory, std::shared_ptr<void> owner);
  /// Returns whether a sample has arrived that neither its reader nor an earlier call has seen. The
  /// check is ordered after the store to RingControl::asleep, so that no wake-up is lost.
  bool anything_new();

 private:
  Mutex mutex_;
  std::vector<std::weak_ptr<StreamWatch>> watches_ GECOS_GUARDED_BY(mutex_);
  std::atomic<bool> any_{false};  // lets a connection without streams skip the mutex
};

}  // namespace gecos::media
