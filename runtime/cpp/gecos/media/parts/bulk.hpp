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
/// From its first large packet on, a side has beside its ring an *area*: memory that it alone
/// writes. The packet is written there, and a slot of the ring says in its place where. So large
/// and small packets keep one order and are counted in one way, and what the reader has taken from
/// the ring is free here as well: nothing travels back, and a dead reader owes nothing.
///
/// Packets lie as low as there is room. One at a time lies always in the same memory, which stays
/// in the caches; pages above what was ever needed at once are never touched and cost nothing. An
/// area that was not used for `area_kept` beats is given back.
namespace gecos::media {

inline constexpr std::size_t largest_bulk_packet = std::size_t{32} << 20;
/// As much as one tick of housekeeping (10 ms) moves at the speed of memory: a sender that found no
/// room and is tried again with the next tick does not limit the flow.
inline constexpr std::size_t area_bytes = std::size_t{64} << 20;
inline constexpr unsigned area_kept = 100;  ///< 10 s

/// How a medium brings an area to the reader.
class AreaMaker {
 public:
  virtual ~AreaMaker() = default;
  /// Zeroed memory of area_bytes that the reader can know as `number`. Null: not now.
  virtual std::shared_ptr<Mapping> make_area(std::uint64_t number) = 0;
  /// Tells the reader that nothing more comes through it. False: not now.
  virtual bool release(std::uint64_t number) = 0;
};

/// write() belongs to who writes the ring.
class BulkWriter {
 public:
  BulkWriter(RingWriter& ring, AreaMaker& maker) : ring_(ring), maker_(maker) {}

  /// As RingWriter::write(). Full also when the memory cannot be had.
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
    std::uint64_t until = 0;  // free when the reader has taken so many slots
  };
  bool find_room(std::size_t bytes);
  bool back(std::size_t end);

  RingWriter& ring_;
  AreaMaker& maker_;
  std::mutex mutex_;  // guards all below against beat()
  std::shared_ptr<Mapping> area_;
  std::uint64_t number_ = 0;           // of the area
  std::size_t backed_ = 0;             // bytes from the start that the kernel has given
  std::vector<Held> held_;             // by offset
  std::optional<std::size_t> placed_;  // index in held_ of what is not sent yet
  std::size_t placed_size_ = 0;
  std::uint64_t last_packet_ = 0;
  unsigned quiet_beats_ = 0;
};

/// copy() and rest() belong to who reads the ring, all else to any thread.
class BulkReader final : public BulkSource {
 public:
  /// `look` takes up what the writer has said of its areas so far.
  explicit BulkReader(std::function<void()> look) : look_(std::move(look)) {}

  /// From now on `area` is number `number`, and the one before is over. @pre it has area_bytes
  void know(std::uint64_t number, std::shared_ptr<const Mapping> area);
  /// The writer has given it back.
  void end(std::uint64_t number);

  std::optional<ByteView> copy(const BulkPlace& place) override;
  /// Before its thread sleeps: frees the copy, if the area that it was copied from has been given
  /// back.
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
