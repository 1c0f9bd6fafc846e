#include "gecos/media/buffers/ring.hpp"

#include <time.h>

#include <algorithm>
#include <cstring>

#include "gecos/base/process_barrier.hpp"
#include "gecos/base/suspension.hpp"

namespace gecos::media {
namespace {

std::size_t slots_for(std::size_t size) {
  return size <= slot_payload ? 1 : (size + slot_payload - 1) / slot_payload;
}

/// Copies sequences of bytes, one after the other, into the payloads of successive slots.
class SlotFiller {
 public:
  SlotFiller(RingMemory ring, std::uint64_t position) : ring_(ring), position_(position) {}

  void put(ByteView bytes) {
    while (!bytes.empty()) {
      if (filled_ == slot_payload) {
        ++position_;
        filled_ = 0;
      }
      const std::size_t fits = std::min(bytes.size(), slot_payload - filled_);
      RingSlot& slot = ring_.slots[position_ & (ring_.slot_count - 1)];
      std::memcpy(slot.payload + filled_, bytes.data(), fits);
      filled_ += fits;
      bytes = bytes.subspan(fits);
    }
  }

 private:
  const RingMemory ring_;
  std::uint64_t position_;
  std::size_t filled_ = 0;
};

/// Returns an approximation of CLOCK_BOOTTIME in milliseconds, at a cost of a few nanoseconds. All
/// processes that have measured the last suspension of the host (note_suspension) get the same
/// value. A process that has not measured this suspension yet gets a smaller value, so that its
/// packets look older than they are.
std::uint32_t coarse_milliseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
  const auto suspended = noted_suspension() / std::chrono::milliseconds(1);
  return static_cast<std::uint32_t>(now.tv_sec * 1000 + now.tv_nsec / 1'000'000 + suspended);
}

}  // namespace

void use_barriers(RingControl& own) {
  own.barriers.store(join_barriers() ? 1 : 0, std::memory_order_relaxed);
}

bool announce_sleep(RingControl& own) {
  own.asleep.store(1, std::memory_order_seq_cst);
  if (own.barriers.load(std::memory_order_relaxed) == 0 || barrier_for_all()) return true;
  own.barriers.store(0, std::memory_order_seq_cst);
  return false;
}

void note_ring(RingControl& own) {
  own.rang_at.store(std::chrono::steady_clock::now().time_since_epoch().count(),
                    std::memory_order_relaxed);
}

Whereabouts whereabouts(const RingControl& control) {
  const auto core = static_cast<std::int32_t>(control.core.load(std::memory_order_relaxed)) - 1;
  const Duration rang_at{control.rang_at.load(std::memory_order_relaxed)};
  return {core, control.asleep.load(std::memory_order_relaxed) != 0, TimePoint{rang_at}};
}

std::uint64_t RingWriter::publish(std::size_t size, std::size_t slots) {
  RingSlot& first = own_.slots[position_ & mask_];
  first.size.store(static_cast<std::uint32_t>(size), std::memory_order_relaxed);
  first.stamp_ms.store(coarse_milliseconds(), std::memory_order_relaxed);
  // The store must be ordered before the check whether the reader sleeps. A barrier here would wait
  // until the cache line has come from the core of the reader, which polls it.
  if (reader_executes_barriers()) {
    first.sequence.store(position_ + 1, std::memory_order_release);
    std::atomic_signal_fence(std::memory_order_seq_cst);
  } else {
    first.sequence.store(position_ + 1, std::memory_order_seq_cst);
  }
  position_ += slots;
  // Fetches the first cache line for the next packet now, while no thread waits for that packet.
  __builtin_prefetch(&own_.slots[position_ & mask_], 1);

  const std::uint64_t number = written_.load(std::memory_order_relaxed) + 1;
  written_.store(number, std::memory_order_relaxed);
  return number;
}

tl::expected<std::uint64_t, SendProblem> RingWriter::write(ByteView head, ByteView body) {
  const std::size_t size = head.size() + body.size();
  if (size > largest_ring_packet) return tl::unexpected(SendProblem::TooLarge);
  const std::size_t wanted = slots_for(size);
  if (wanted > free_slots(wanted)) return tl::unexpected(SendProblem::Full);

  SlotFiller filler(own_, position_);
  filler.put(head);
  filler.put(body);
  return publish(size, wanted);
}

std::uint64_t RingWriter::announce(const BulkPlace& place) {
  static_assert(sizeof place <= slot_payload);
  std::memcpy(own_.slots[position_ & mask_].payload, &place, sizeof place);
  return publish(beside_ring, 1);
}

std::size_t RingWriter::free_slots(std::size_t wanted) {
  const std::size_t known = own_.slot_count - static_cast<std::size_t>(position_ - taken_seen_);
  if (known >= wanted) return known;
  return own_.slot_count - static_cast<std::size_t>(position_ - slots_taken());
}

std::uint64_t RingWriter::slots_taken() {
  const RingControl* reader = reader_.load(std::memory_order_acquire);
  if (reader == nullptr) return taken_seen_;
  const std::uint64_t taken = reader->slots_taken.load(std::memory_order_acquire);
  // A count that decreases, or that exceeds the number of written slots, is invalid. The writer
  // ignores such a count: the writer then assumes that the reader has taken no further slot.
  if (taken <= position_ && taken > taken_seen_) taken_seen_ = taken;
  return taken_seen_;
}

std::uint64_t RingWriter::taken() const {
  const RingControl* reader = reader_.load(std::memory_order_acquire);
  if (reader == nullptr) return 0;
  return std::min(reader->packets_taken.load(std::memory_order_acquire),
                  written_.load(std::memory_order_relaxed));
}

RingReader::RingReader(RingControl& own, RingMemory writer, BulkSource* bulk)
    : own_(own),
      writer_(writer),
      mask_(writer.slot_count - 1),
      bulk_(bulk),
      copy_(std::make_unique_for_overwrite<std::byte[]>(largest_ring_packet)) {}

void RingReader::advance(std::size_t slots) {
  position_ += slots;
  own_.packets_taken.store(++packets_, std::memory_order_relaxed);
  own_.slots_taken.store(position_, std::memory_order_release);
}

std::optional<ByteView> RingReader::take(const RingSlot& slot) {
  // Each value is read only once, because the peer may change it at any time.
  const std::size_t size = slot.size.load(std::memory_order_relaxed);
  stamp_ms_ = slot.stamp_ms.load(std::memory_order_relaxed);
  if (size > largest_ring_packet || slots_for(size) > writer_.slot_count || broken()) {
    if (size == beside_ring) return take_bulk(slot);
    broken_.store(true, std::memory_order_relaxed);
    return std::nullopt;
  }
  std::size_t copied = 0;
  for (std::uint64_t at = position_; copied < size; ++at) {
    const std::size_t here = std::min(size - copied, slot_payload);
    std::memcpy(copy_.get() + copied, writer_.slots[at & mask_].payload, here);
    copied += here;
  }
  advance(slots_for(size));
  return ByteView(copy_.get(), size);
}

Duration RingReader::age() const {
  const std::uint32_t passed = coarse_milliseconds() - stamp_ms_;
  // A stamp in the future is invalid. It gives the age 0, which harms only the calls of the writer
  // that wrote it.
  return std::chrono::milliseconds(passed < 1U << 31U ? passed : 0);
}

std::optional<ByteView> RingReader::take_bulk(const RingSlot& slot) {
  BulkPlace place;
  std::memcpy(&place, slot.payload, sizeof place);  // read once: the peer may change it
  std::optional<ByteView> packet;
  if (bulk_ != nullptr && !broken()) packet = bulk_->copy(place);
  if (packet) {
    advance(1);
  } else {
    broken_.store(true, std::memory_order_relaxed);
  }
  return packet;
}

}  // namespace gecos::media
