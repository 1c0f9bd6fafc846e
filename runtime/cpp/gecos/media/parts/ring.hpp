#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "gecos/base/bytes.hpp"
#include "gecos/media/medium.hpp"

/// The single-producer single-consumer ring between two sides that do not trust each other.
///
/// Each side has one run of memory that it alone writes: its control block, and the slots in which
/// it sends. The algorithm takes addresses, so that threads test it in one mapping and processes
/// use it over two. What the other side wrote is copied first and believed never: a wrong number
/// there gives a wrong packet or a broken ring, not a wrong address.
namespace gecos::media {

/// What one side tells about its reading, and its life.
struct RingControl {
  /// Tells the writer which slots are free again.
  alignas(64) std::atomic<std::uint64_t> slots_taken{0};
  /// Tells the writer which packets were taken; outlives the reader.
  std::atomic<std::uint64_t> packets_taken{0};
  /// Tells the writer to ring after publishing. On a line of its own: it is read with every packet.
  alignas(64) std::atomic<std::uint32_t> asleep{0};
  /// Tells the other side's waiting where this side ran last: the core plus one, 0 where unknown.
  std::atomic<std::uint32_t> core{0};
  /// Tells whom this side rang when that was: nanoseconds of the steady clock.
  std::atomic<std::int64_t> rang_at{0};
  /// Tells the other side's housekeeping that this one lives.
  alignas(64) std::atomic<std::uint64_t> beats{0};
  /// Tell the other side what its session needs to know without a packet (Link::write_word).
  alignas(64) std::array<std::atomic<std::uint64_t>, shared_word_count> words{};
};

/// Says in `own` where the calling thread runs.
inline void note_core(RingControl& own) {
  const auto core = static_cast<std::uint32_t>(running_core() + 1);
  // A line that the other side reads with every packet is written only where it changes.
  if (own.core.load(std::memory_order_relaxed) != core) {
    own.core.store(core, std::memory_order_relaxed);
  }
}
/// Says in `own` that the other side is rung now.
void note_ring(RingControl& own);
/// What the side of `control` says of itself.
Whereabouts whereabouts(const RingControl& control);

inline constexpr std::size_t slot_payload = 240;

/// A packet begins in a slot and goes on in the payloads of those that follow.
struct alignas(64) RingSlot {
  /// Index of the slot since the ring began, plus one: publishes the packet that begins here.
  std::atomic<std::uint64_t> sequence;
  std::atomic<std::uint32_t> size;      // of the packet; ordered by sequence
  std::atomic<std::uint32_t> stamp_ms;  // when it was sent, by coarse_milliseconds(); likewise
  std::byte payload[slot_payload];
};
static_assert(sizeof(RingSlot) == 256);
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// The memory of one side, zero at first.
struct RingMemory {
  RingControl* control = nullptr;
  RingSlot* slots = nullptr;
  std::size_t slot_count = 0;  ///< a power of two

  static constexpr std::size_t control_bytes = 4096;  ///< a page: the slots begin on one
  static constexpr std::size_t bytes(std::size_t slot_count) {
    return control_bytes + slot_count * sizeof(RingSlot);
  }
  /// @pre `base` has bytes(slot_count) bytes.
  static RingMemory at(std::byte* base, std::size_t slot_count) {
    return {reinterpret_cast<RingControl*>(base), reinterpret_cast<RingSlot*>(base + control_bytes),
            slot_count};
  }
};

/// The largest packet that lies in a ring itself, so that many fit; larger ones lie beside it
/// (bulk.hpp).
inline constexpr std::size_t largest_ring_packet = 8 * 1024;
/// 256 KiB a direction: what is written round and round stays in a core's second cache.
inline constexpr std::size_t usual_slot_count = 1024;

/// What a slot says of a packet that lies beside the ring.
struct BulkPlace {
  std::uint64_t area = 0;    ///< memory that the writer has shown to the reader, counted from 1
  std::uint64_t offset = 0;  ///< in it
  std::uint64_t size = 0;
};
/// A slot of this size holds no packet but the place of one.
inline constexpr std::uint32_t beside_ring = 0xffffffff;

/// Where a reader finds what lies beside its ring.
class BulkSource {
 public:
  virtual ~BulkSource() = default;
  /// The packet, copied into memory of the reader's own, until the next call. Nothing: there is
  /// none.
  virtual std::optional<ByteView> copy(const BulkPlace& place) = 0;
};

/// One thread writes at a time.
class RingWriter {
 public:
  explicit RingWriter(RingMemory own) : own_(own), mask_(own.slot_count - 1) {}

  /// From now on `reader` is looked at; until then the ring can be filled once. Any thread.
  void set_reader(const RingControl* reader) {
    reader_.store(reader, std::memory_order_release);  // publishes the mapping of the peer's memory
  }
  tl::expected<std::uint64_t, SendProblem> write(ByteView head, ByteView body);
  /// In place of a packet: where it lies. Gives its number. @pre has_room()
  std::uint64_t announce(const BulkPlace& place);
  bool has_room() { return free_slots(1) != 0; }
  bool half_full() { return slots_written() - slots_taken() > own_.slot_count / 2; }
  std::uint64_t slots_written() const { return position_; }
  /// Slots that the reader has taken; what it has read of them is read.
  std::uint64_t slots_taken();
  /// After write(): the reader must be woken.
  bool reader_sleeps() const {
    const RingControl* reader = reader_.load(std::memory_order_acquire);
    return reader != nullptr && reader->asleep.load(std::memory_order_seq_cst) != 0;
  }
  /// Packets that the reader has taken. Any thread.
  std::uint64_t taken() const;

 private:
  std::size_t free_slots(std::size_t wanted);
  [[gnu::always_inline]] inline std::uint64_t publish(std::size_t size, std::size_t slots);

  const RingMemory own_;
  const std::size_t mask_;
  std::atomic<const RingControl*> reader_{nullptr};
  std::uint64_t position_ = 0;  // of the next slot to write
  std::uint64_t taken_seen_ = 0;
  std::atomic<std::uint64_t> written_{0};  // bounds what the reader may claim to have taken
};

/// One thread reads at a time.
class RingReader {
 public:
  /// `own` is where this reader's progress is told; `writer` the memory of the other side; `bulk`
  /// has what lies beside its ring. Without it nothing may.
  RingReader(RingControl& own, RingMemory writer, BulkSource* bulk = nullptr);

  /// The next packet, copied into memory of this reader's own, until the next call.
  std::optional<ByteView> read() {
    const RingSlot& slot = writer_.slots[position_ & mask_];
    if (slot.sequence.load(std::memory_order_acquire) != position_ + 1) return std::nullopt;
    return take(slot);
  }
  /// A packet is there; ordered after the writing of `asleep`, so that no wake-up is lost.
  bool ready() const {
    return writer_.slots[position_ & mask_].sequence.load(std::memory_order_seq_cst) ==
           position_ + 1;
  }
  /// The writer broke the rules; nothing more is read.
  bool broken() const { return broken_.load(std::memory_order_relaxed); }
  /// How long the packet that read() gave last lay in the ring, as its writer says; within some
  /// milliseconds.
  Duration age() const;

 private:
  std::optional<ByteView> take(const RingSlot& slot);
  std::optional<ByteView> take_bulk(const RingSlot& slot);
  [[gnu::always_inline]] inline void advance(std::size_t slots);

  RingControl& own_;
  const RingMemory writer_;
  const std::size_t mask_;
  std::uint64_t position_ = 0;
  std::uint64_t packets_ = 0;
  std::uint32_t stamp_ms_ = 0;
  BulkSource* const bulk_;
  std::unique_ptr<std::byte[]> copy_;
  std::atomic<bool> broken_{false};  // tells other threads of this process, nothing else
};

}  // namespace gecos::media
