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
/// use it over two. Data written by the other side is copied first and never trusted: a wrong
/// number there yields a wrong packet or a broken ring, not a wrong address.
namespace gecos::media {

/// What one side publishes about its reading, and its heartbeats.
struct RingControl {
  /// Tells the writer which slots are free again.
  alignas(64) std::atomic<std::uint64_t> slots_taken{0};
  /// Tells the writer which packets were taken; outlives the reader.
  std::atomic<std::uint64_t> packets_taken{0};
  /// Tells the writer to notify after publishing. On a cache line of its own, because it is read
  /// with every packet.
  alignas(64) std::atomic<std::uint32_t> asleep{0};
  /// Tells the other side, for its waiting, where this side ran last: the core plus one, 0 when
  /// unknown.
  std::atomic<std::uint32_t> core{0};
  /// Tells the other side when this side last notified it: nanoseconds of the steady clock.
  std::atomic<std::int64_t> rang_at{0};
  /// Tells the other side's maintenance thread that this side lives.
  alignas(64) std::atomic<std::uint64_t> beats{0};
  /// Tell the other side what its session needs to know without a packet (Link::write_word).
  alignas(64) std::array<std::atomic<std::uint64_t>, shared_word_count> words{};
};

/// Publishes in `own` where the calling thread runs.
inline void note_core(RingControl& own) {
  const auto core = static_cast<std::uint32_t>(running_core() + 1);
  // The other side reads this cache line with every packet, so write it only when it changes.
  if (own.core.load(std::memory_order_relaxed) != core) {
    own.core.store(core, std::memory_order_relaxed);
  }
}
/// Publishes in `own` that the other side is notified now.
void note_ring(RingControl& own);
/// The whereabouts that the side of `control` publishes.
Whereabouts whereabouts(const RingControl& control);

inline constexpr std::size_t slot_payload = 240;

/// A packet begins in a slot and continues in the payloads of the slots after it.
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

/// The largest packet that is stored in a ring itself, so that many fit; larger ones are stored
/// beside it (bulk.hpp).
inline constexpr std::size_t largest_ring_packet = 8 * 1024;
/// 256 KiB per direction: the ring stays in the level-2 cache of a core.
inline constexpr std::size_t usual_slot_count = 1024;

/// The content of a slot for a packet that is stored beside the ring.
struct BulkPlace {
  std::uint64_t area = 0;    ///< memory that the writer has shown to the reader, counted from 1
  std::uint64_t offset = 0;  ///< in it
  std::uint64_t size = 0;
};
/// The size in a slot that holds the place of a packet instead of a packet.
inline constexpr std::uint32_t beside_ring = 0xffffffff;

/// Where a reader finds the packets stored beside its ring.
class BulkSource {
 public:
  virtual ~BulkSource() = default;
  /// The packet, copied into the reader's own memory and valid until the next call; nullopt when
  /// there is none.
  virtual std::optional<ByteView> copy(const BulkPlace& place) = 0;
};

/// One thread writes at a time.
class RingWriter {
 public:
  explicit RingWriter(RingMemory own) : own_(own), mask_(own.slot_count - 1) {}

  /// From now on the writer reads `reader`; until then the ring can be filled once. Any thread.
  void set_reader(const RingControl* reader) {
    reader_.store(reader, std::memory_order_release);  // publishes the mapping of the peer's memory
  }
  tl::expected<std::uint64_t, SendProblem> write(ByteView head, ByteView body);
  /// Writes the place of a packet instead of the packet. Returns the packet's number. @pre
  /// has_room()
  std::uint64_t announce(const BulkPlace& place);
  bool has_room() { return free_slots(1) != 0; }
  bool half_full() { return slots_written() - slots_taken() > own_.slot_count / 2; }
  std::uint64_t slots_written() const { return position_; }
  /// Slots that the reader has taken and will not read again.
  std::uint64_t slots_taken();
  /// True after write() when the reader must be woken.
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
  std::atomic<std::uint64_t> written_{0};  // upper bound for what the reader reports as taken
};

/// One thread reads at a time.
class RingReader {
 public:
  /// `own` is where this reader publishes its progress, `writer` the memory of the other side,
  /// `bulk` the source of the packets beside its ring. Without `bulk` such packets are not allowed.
  RingReader(RingControl& own, RingMemory writer, BulkSource* bulk = nullptr);

  /// The next packet, copied into this reader's own memory and valid until the next call.
  std::optional<ByteView> read() {
    const RingSlot& slot = writer_.slots[position_ & mask_];
    if (slot.sequence.load(std::memory_order_acquire) != position_ + 1) return std::nullopt;
    return take(slot);
  }
  /// True when a packet is there; ordered after the write of `asleep`, so that no wake-up is lost.
  bool ready() const {
    return writer_.slots[position_ & mask_].sequence.load(std::memory_order_seq_cst) ==
           position_ + 1;
  }
  /// True when the writer broke the rules; no more packets are read.
  bool broken() const { return broken_.load(std::memory_order_relaxed); }
  /// How long the packet that read() returned last lay in the ring, by its writer's stamp; accurate
  /// to some milliseconds.
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
