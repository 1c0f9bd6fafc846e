#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "gecos/media/parts/mapping.hpp"
#include "gecos/media/parts/ring.hpp"

/// Packets that are too large for a ring.
///
/// From its first large packet on, a side has an *area* beside its ring: memory that it alone
/// writes. The packet is written there, and a slot of the ring says where. So large and small
/// packets keep one order and are counted in one way, and what the reader has taken from the ring
/// is free in the area as well: the reader sends nothing back, and a dead reader holds nothing.
///
/// Each packet is placed at the lowest free offset. With one packet at a time the same memory is
/// used, which stays in the caches; pages above the highest use so far are never touched and cost
/// nothing. An area that was not used for `area_kept` beats is released.
namespace gecos::media {

inline constexpr std::size_t largest_bulk_packet = std::size_t{32} << 20;
/// As much as memory bandwidth moves in one maintenance tick (10 ms): a sender that found no room
/// and retries at the next tick does not limit the throughput.
inline constexpr std::size_t area_bytes = std::size_t{64} << 20;
inline constexpr unsigned area_kept = 100;  ///< 10 s

/// How a medium brings an area to the reader.
class AreaMaker {
 public:
  virtual ~AreaMaker() = default;
  /// Makes zeroed memory of area_bytes that the reader knows as `number`. Null: not possible now.
  virtual std::shared_ptr<Mapping> make_area(std::uint64_t number) = 0;
  /// Notifies the reader that the area is not used any more. Returns false when that is not
  /// possible now.
  virtual bool release(std::uint64_t number) = 0;
};

/// Only the thread that writes the ring may call write().
class BulkWriter {
 public:
  BulkWriter(RingWriter& ring, AreaMaker& maker) : ring_(ring), maker_(maker) {}

  /// As RingWriter::write(). Fails with Full also when memory cannot be allocated.
  tl::expected<std::uint64_t, SendProblem> write(ByteView head, ByteView body);
  /// The same in two steps, so that the packet is made where it lies: memory of `size` bytes, none
  /// when there is no room now; then, with nothing written to the ring in between, the packet in it
  /// is sent. A place that is not sent is dropped with the next one.
  std::span<std::byte> place(std::size_t size);
  std::uint64_t send_placed();

  /// Every 100 ms; any thread.
  void beat();
  /// In a forked child.
  void forget() noexcept;

 private:
  struct Held {
    std::size_t offset = 0;
    std::size_t bytes = 0;
    std::uint64_t until = 0;  // free once the reader has taken so many slots
  };
  bool find_room(std::size_t bytes);
  bool back(std::size_t end);

  RingWriter& ring_;
  AreaMaker& maker_;
  std::mutex mutex_;  // guards all below against beat()
  std::shared_ptr<Mapping> area_;
  std::uint64_t number_ = 0;  // of the area
  std::size_t backed_ = 0;    // bytes from the start that the kernel has backed with memory
  std::vector<Held> held_;    // by offset
  std::optional<std::size_t> placed_;  // index in held_ of the packet that is not sent yet
  std::size_t placed_size_ = 0;
  std::uint64_t last_packet_ = 0;
  unsigned quiet_beats_ = 0;
};

/// Only the thread that reads the ring may call copy() and rest(); any thread may call the rest.
class BulkReader final : public BulkSource {
 public:
  /// `look` processes what the writer has announced of its areas so far.
  explicit BulkReader(std::function<void()> look) : look_(std::move(look)) {}

  /// Makes `area` number `number`; it replaces the area before. @pre `area` has area_bytes
  void know(std::uint64_t number, std::shared_ptr<const Mapping> area);
  /// The writer has released the area `number`.
  void end(std::uint64_t number);

  std::optional<ByteView> copy(const BulkPlace& place) override;
  /// Must be called before the reading thread sleeps: frees the copy if the area that it was copied
  /// from has been released.
  void rest() {
    if (ended_.load(std::memory_order_relaxed)) free_copy();
  }
  /// In a forked child.
  void forget() noexcept;

 private:
  std::shared_ptr<const Mapping> find(std::uint64_t number);
  void free_copy();

  const std::function<void()> look_;
  std::unique_ptr<std::byte[]> copy_;
  std::size_t copy_bytes_ = 0;
  std::uint64_t backed_area_ = 0;
  std::size_t backed_ = 0;          // bytes of it that cannot fault any more
  std::atomic<bool> ended_{false};  // tells the reader to free its copy, nothing else

  std::mutex mutex_;  // guards what follows
  std::shared_ptr<const Mapping> area_;
  std::uint64_t number_ = 0;
};

}  // namespace gecos::media
