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
/// Each side has one block of memory that only it may write: its control block, and the slots for
/// the packets that it sends. The classes take addresses, so that they work between threads with
/// one mapping and between processes with two mappings. Data written by the other side is copied
/// before use and never trusted: a wrong value yields a wrong packet or a broken ring, never a
/// wrong address.
namespace gecos::media {

/// What one side publishes for the other: its progress in reading, its state, its heartbeats.
struct RingControl {
  /// Number of slots that this side has read: tells the writer which slots are free again.
  alignas(64) std::atomic<std::uint64_t> slots_taken{0};
  /// Number of packets that this side has read; the writer can look it up after the reader died.
  std::atomic<std::uint64_t> packets_taken{0};
  /// Nonzero while this side sleeps: the writer must then notify it after publishing. Begins a new
  /// cache line, because the writer reads it with every packet.
  alignas(64) std::atomic<std::uint32_t> asleep{0};
  /// Number of the core on which this side ran last, plus one; 0 when unknown. The other side uses
  /// it to choose how to wait.
  std::atomic<std::uint32_t> core{0};
  /// When this side last notified the other side: nanoseconds of the steady clock.
  std::atomic<std::int64_t> rang_at{0};
  /// Number of heartbeats: tells the other side's maintenance thread that this side is alive.
  alignas(64) std::atomic<std::uint64_t> beats{0};
  /// Words that the session publishes without sending a packet (Connection::write_word).
  alignas(64) std::array<std::atomic<std::uint64_t>, shared_word_count> words{};
};

/// Publishes in `own` the core on which the calling thread runs.
inline void note_core(RingControl& own) {
  const auto core = static_cast<std::uint32_t>(running_core() + 1);
  // The other side reads this cache line with every packet, so write it only when it changes.
  if (own.core.load(std::memory_order_relaxed) != core) {
    own.core.store(core, std::memory_order_relaxed);
  }
}
/// Publishes in `own` the current time as the last notification of the other side.
void note_ring(RingControl& own);
/// Reads the whereabouts that a side has published in its `control`.
Whereabouts whereabouts(const RingControl& control);

inline constexpr std::size_t slot_payload = 240;

/// A packet begins in a slot and continues in the payloads of the slots after it.
struct alignas(64) RingSlot {
  /// Running number of the slot, from 1 for the first slot ever written. Storing the number
  /// publishes the packet that begins in this slot.
  std::atomic<std::uint64_t> sequence;
  std::atomic<std::uint32_t> size;      // bytes of the packet; published by `sequence`
  std::atomic<std::uint32_t> stamp_ms;  // send time, coarse_milliseconds(); published by `sequence`
  std::byte payload[slot_payload];
};
static_assert(sizeof(RingSlot) == 256);
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// The memory of one side, zero at first.
struct RingMemory {
  RingControl* control = nullptr;
  RingSlot* slots = nullptr;
  std::size_t slot_count = 0;  ///< a power of two

  static constexpr std::size_t control_bytes = 4096;  ///< one page: keeps the slots page-aligned
  static constexpr std::size_t bytes(std::size_t slot_count) {
    return control_bytes + slot_count * sizeof(RingSlot);
  }
  /// @pre `base` has bytes(slot_count) bytes.
  static RingMemory at(std::byte* base, std::size_t slot_count) {
    return {reinterpret_cast<RingControl*>(base), reinterpret_cast<RingSlot*>(base + control_bytes),
            slot_count};
  }
};

/// Bytes of the largest packet that is stored in a ring itself; the limit leaves room for many
/// packets. Larger packets are stored outside the ring (bulk.hpp).
inline constexpr std::size_t largest_ring_packet = 8 * 1024;
/// 256 KiB per direction: the ring stays in the level-2 cache of a core.
inline constexpr std::size_t usual_slot_count = 1024;

/// The payload of a slot whose packet is stored outside the ring: where the packet is.
struct BulkPlace {
  std::uint64_t area = 0;    ///< number of the writer's area (bulk.hpp), counted from 1
  std::uint64_t offset = 0;  ///< bytes from the start of the area
  std::uint64_t size = 0;
};
/// Value of RingSlot::size that marks a slot with a BulkPlace instead of a packet.
inline constexpr std::uint32_t beside_ring = 0xffffffff;

/// Gives a reader the packets that are stored outside its ring.
class BulkSource {
 public:
  virtual ~BulkSource() = default;
  /// Copies the packet at `place` into the reader's own memory, where it is valid until the next
  /// call. nullopt when no packet can be there.
  virtual std::optional<ByteView> copy(const BulkPlace& place) = 0;
};

/// Writes packets into a ring; at most one thread at a time.
class RingWriter {
 public:
  explicit RingWriter(RingMemory own) : own_(own), mask_(own.slot_count - 1) {}

  /// Sets where the reader publishes its progress. Before this call the writer reuses no slot: it
  /// can fill the ring only once. Any thread.
  void set_reader(const RingControl* reader) {
    reader_.store(reader, std::memory_order_release);  // publishes the mapping of the peer's memory
  }
  tl::expected<std::uint64_t, SendProblem> write(ByteView head, ByteView body);
  /// Sends a packet that is stored outside the ring: writes its place into a slot. Returns the
  /// packet's number. @pre has_room()
  std::uint64_t announce(const BulkPlace& place);
  bool has_room() { return free_slots(1) != 0; }
  bool half_full() { return slots_written() - slots_taken() > own_.slot_count / 2; }
  std::uint64_t slots_written() const { return position_; }
  /// Number of slots that the reader has taken and will not read again.
  std::uint64_t slots_taken();
  /// Whether the reader sleeps and must be woken. Call this after write().
  bool reader_sleeps() const {
    const RingControl* reader = reader_.load(std::memory_order_acquire);
    return reader != nullptr && reader->asleep.load(std::memory_order_seq_cst) != 0;
  }
  /// Number of packets that the reader has taken. Any thread.
  std::uint64_t taken() const;

 private:
  std::size_t free_slots(std::size_t wanted);
  [[gnu::always_inline]] inline std::uint64_t publish(std::size_t size, std::size_t slots);

  const RingMemory own_;
  const std::size_t mask_;
  std::atomic<const RingControl*> reader_{nullptr};
  std::uint64_t position_ = 0;  // running number of the next slot to write
  std::uint64_t taken_seen_ = 0;
  std::atomic<std::uint64_t> written_{0};  // packets written; upper bound for taken()
};

/// Reads packets from a ring; at most one thread at a time.
class RingReader {
 public:
  /// `own` is where this reader publishes its progress, `writer` the memory of the other side,
  /// `bulk` the source of the packets stored outside the ring. Without `bulk` such a packet breaks
  /// the ring.
  RingReader(RingControl& own, RingMemory writer, BulkSource* bulk = nullptr);

  /// Returns the next packet, copied into this reader's own memory and valid until the next call;
  /// nullopt when none has arrived.
  std::optional<ByteView> read() {
    const RingSlot& slot = writer_.slots[position_ & mask_];
    if (slot.sequence.load(std::memory_order_acquire) != position_ + 1) return std::nullopt;
    return take(slot);
  }
  /// Whether a packet can be read. The check is ordered after the store to RingControl::asleep, so
  /// that no wake-up is lost.
  bool ready() const {
    return writer_.slots[position_ & mask_].sequence.load(std::memory_order_seq_cst) ==
           position_ + 1;
  }
  /// Whether the writer has written an invalid slot; then no more packets are read.
  bool broken() const { return broken_.load(std::memory_order_relaxed); }
  /// How long the packet that read() returned last was in the ring, by the writer's time stamp;
  /// accurate to some milliseconds.
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
  std::atomic<bool> broken_{false};  // read by other threads; orders no other memory
};

}  // namespace gecos::media
