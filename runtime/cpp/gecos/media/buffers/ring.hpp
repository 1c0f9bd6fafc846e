#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "gecos/base/bytes.hpp"
#include "gecos/media/medium.hpp"

/// A ring buffer with one writer and one reader that do not trust each other.
///
/// Each side of a connection has one block of memory that only this side may write. The block has
/// the control block of the side, and the slots for the packets that the side sends. The classes
/// take addresses, so that they work between threads with one mapping and between processes with
/// two mappings. Data of the other side are copied before use and never trusted: a wrong value
/// leads to a wrong packet or a broken ring, but never to a wrong address.
namespace gecos::media {

/// The data that one side publishes for the other side: its progress in reading, its state and its
/// heartbeats.
struct RingControl {
  /// The number of slots that this side has read. From this number, the other side, which writes
  /// the slots, knows which slots are free again.
  alignas(64) std::atomic<std::uint64_t> slots_taken{0};
  /// The number of packets that this side has read. The other side can read this number even after
  /// the death of this side.
  std::atomic<std::uint64_t> packets_taken{0};
  /// Nonzero while this side sleeps. The other side must then notify this side after it has
  /// published a packet. This member begins a new cache line, because the other side reads it with
  /// every packet.
  alignas(64) std::atomic<std::uint32_t> asleep{0};
  /// Number of the CPU core on which this side ran last, plus one; 0 when the core is unknown. The
  /// other side uses this number to choose how to wait.
  std::atomic<std::uint32_t> core{0};
  /// Time at which this side last notified the other side, in nanoseconds of the steady clock.
  std::atomic<std::int64_t> rang_at{0};
  /// Nonzero if this side executes a barrier for all processes (process_barrier.hpp) after it has
  /// stored to `asleep`. If it is nonzero on both sides, a writer needs no barrier of its own.
  std::atomic<std::uint32_t> barriers{0};
  /// Number of heartbeats of this side. When the number rises, the maintenance thread of the other
  /// side knows that this side is alive.
  alignas(64) std::atomic<std::uint64_t> beats{0};
  /// The words that the session publishes without sending a packet (Connection::write_word).
  alignas(64) std::array<std::atomic<std::uint64_t>, shared_word_count> words{};
};

/// Publishes in `own` the number of the CPU core on which the calling thread runs.
inline void note_core(RingControl& own) {
  const auto core = static_cast<std::uint32_t>(running_core() + 1);
  // The other side reads this cache line with every packet. Therefore this function writes it only
  // when the core has changed.
  if (own.core.load(std::memory_order_relaxed) != core) {
    own.core.store(core, std::memory_order_relaxed);
  }
}
/// Joins this process to the barriers of all processes, and publishes in `own` whether this has
/// succeeded. Must be called before this side sleeps for the first time.
void use_barriers(RingControl& own);
/// Publishes in `own` that this side sleeps from now on. The caller must then check once more
/// whether a packet can be read. Returns false if the side must not sleep now, because the kernel
/// has just refused a barrier; the next sleep does without.
bool announce_sleep(RingControl& own);
/// Publishes in `own` the current time as the time at which the owner notifies the other side.
void note_ring(RingControl& own);
/// Reads from `control` the core, the sleep state and the time of the last notification that a side
/// has published there.
Whereabouts whereabouts(const RingControl& control);

inline constexpr std::size_t slot_payload = 240;

/// One slot of a ring. A packet begins in one slot and continues in the payloads of the slots that
/// follow.
struct alignas(64) RingSlot {
  /// Running number of the slot; the first slot that is ever written has the number 1. The store of
  /// this number publishes the packet that begins in this slot.
  std::atomic<std::uint64_t> sequence;
  std::atomic<std::uint32_t> size;      // bytes of the packet; published by `sequence`
  std::atomic<std::uint32_t> stamp_ms;  // send time, coarse_milliseconds(); published by `sequence`
  std::byte payload[slot_payload];
};
static_assert(sizeof(RingSlot) == 256);
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// The block of memory of one side of a connection. It is zero at first.
struct RingMemory {
  RingControl* control = nullptr;
  RingSlot* slots = nullptr;
  std::size_t slot_count = 0;  ///< a power of two

  static constexpr std::size_t control_bytes = 4096;  ///< one page: keeps the slots page-aligned
  static constexpr std::size_t bytes(std::size_t slot_count) {
    return control_bytes + slot_count * sizeof(RingSlot);
  }
  /// Returns the parts of the block of memory at `base`. @pre the block has bytes(slot_count) bytes
  static RingMemory at(std::byte* base, std::size_t slot_count) {
    return {reinterpret_cast<RingControl*>(base), reinterpret_cast<RingSlot*>(base + control_bytes),
            slot_count};
  }
};

/// Size in bytes of the largest packet that is stored in a ring. The limit is small, so that a ring
/// has room for many packets. Larger packets are stored outside the ring (bulk.hpp).
inline constexpr std::size_t largest_ring_packet = 8 * 1024;
/// The usual number of slots of a ring. With this number, the slots of one direction take 256 KiB,
/// so that a ring stays in the level-2 cache of a core.
inline constexpr std::size_t usual_slot_count = 1024;

/// The place of a packet that is stored outside the ring. This struct is the payload of the
/// packet's slot.
struct BulkPlace {
  std::uint64_t area = 0;    ///< number of the writer's area (bulk.hpp), counted from 1
  std::uint64_t offset = 0;  ///< bytes from the start of the area
  std::uint64_t size = 0;
};
/// The value of RingSlot::size that marks a slot that holds a BulkPlace and no packet.
inline constexpr std::uint32_t beside_ring = 0xffffffff;

/// The interface by which a reader gets the packets that are stored outside the ring.
class BulkSource {
 public:
  virtual ~BulkSource() = default;
  /// Copies the packet at `place` into private memory of the reader. The copy is valid until the
  /// next call. Returns nullopt when no packet can be at `place`.
  virtual std::optional<ByteView> copy(const BulkPlace& place) = 0;
};

/// Writes packets into a ring. Only one thread at a time may use a writer.
class RingWriter {
 public:
  explicit RingWriter(RingMemory own) : own_(own), mask_(own.slot_count - 1) {}

  /// Sets the memory in which the reader publishes its progress. Before this call the writer uses
  /// no slot a second time, so that it can fill the ring only once. Any thread may call this
  /// function.
  void set_reader(const RingControl* reader) {
    reader_.store(reader, std::memory_order_release);  // publishes the mapping of the peer's memory
  }
  tl::expected<std::uint64_t, SendProblem> write(ByteView head, ByteView body);
  /// Sends a packet that is stored outside the ring: writes the place of the packet into a slot.
  /// Returns the number of the packet. @pre has_room() is true
  std::uint64_t announce(const BulkPlace& place);
  bool has_room() { return free_slots(1) != 0; }
  bool half_full() { return slots_written() - slots_taken() > own_.slot_count / 2; }
  std::uint64_t slots_written() const { return position_; }
  /// Returns the number of slots that the reader has taken and will not read again.
  std::uint64_t slots_taken();
  /// Returns whether the reader sleeps, so that the caller must wake it. Must be called after
  /// write().
  bool reader_sleeps() const {
    const RingControl* reader = reader_.load(std::memory_order_acquire);
    if (reader == nullptr) return false;
    if (reader_executes_barriers()) return reader->asleep.load(std::memory_order_relaxed) != 0;
    return reader->asleep.load(std::memory_order_seq_cst) != 0;
  }
  /// Returns the number of packets that the reader has taken. Any thread may call this function.
  std::uint64_t taken() const;

 private:
  std::size_t free_slots(std::size_t wanted);
  /// Returns whether a reader that is about to sleep executes a barrier for this side, too.
  bool reader_executes_barriers() const {
    const RingControl* reader = reader_.load(std::memory_order_acquire);
    return reader != nullptr && reader->barriers.load(std::memory_order_relaxed) != 0 &&
           own_.control->barriers.load(std::memory_order_relaxed) != 0;
  }
  [[gnu::always_inline]] inline std::uint64_t publish(std::size_t size, std::size_t slots);

  const RingMemory own_;
  const std::size_t mask_;
  std::atomic<const RingControl*> reader_{nullptr};
  std::uint64_t position_ = 0;  // running number of the next slot to write
  std::uint64_t taken_seen_ = 0;
  std::atomic<std::uint64_t> written_{0};  // packets written; upper bound for taken()
};

/// Reads packets from a ring. Only one thread at a time may use a reader.
class RingReader {
 public:
  /// `own` is the memory in which this reader publishes its progress. `writer` is the memory of the
  /// other side. `bulk` is the source of packets that are stored outside the ring; without `bulk`,
  /// such a packet breaks the ring.
  RingReader(RingControl& own, RingMemory writer, BulkSource* bulk = nullptr);

  /// Returns the next packet, or nullopt when no packet has arrived. The packet is a copy in
  /// private memory of this reader, and is valid until the next call.
  std::optional<ByteView> read() {
    const RingSlot& slot = writer_.slots[position_ & mask_];
    if (slot.sequence.load(std::memory_order_acquire) != position_ + 1) return std::nullopt;
    return take(slot);
  }
  /// Returns whether a packet can be read. This check is ordered after announce_sleep(), so that no
  /// wake-up is lost.
  bool ready() const {
    return writer_.slots[position_ & mask_].sequence.load(std::memory_order_seq_cst) ==
           position_ + 1;
  }
  /// Returns true when the writer has written an invalid slot. The reader then reads no more
  /// packets.
  bool broken() const { return broken_.load(std::memory_order_relaxed); }
  /// Returns how long the packet that read() returned last was in the ring. The result depends on
  /// the writer's time stamp and is accurate to some milliseconds.
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
