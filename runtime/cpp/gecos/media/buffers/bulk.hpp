#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gecos/base/descriptor.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/buffers/mapping.hpp"
#include "gecos/media/buffers/ring.hpp"

/// Memory for packets that are too large for a ring.
///
/// When an end of a connection sends its first large packet, it makes an *area* outside its ring:
/// memory that only this end may write. The sender writes a large packet into the area, and then
/// writes the place of the packet into a slot of the ring. Large and small packets therefore stay
/// in order and are counted together. As soon as the reader has taken the slot, the sender may use
/// the packet's memory in the area again. The reader need not send anything back, and a dead reader
/// occupies no memory.
///
/// Each packet is placed at the lowest free offset. If each packet is read before the next one is
/// written, all packets use the same memory, which stays in the CPU caches. Pages of the area that
/// no packet has used yet cost no memory. An area that was not used for `area_kept` heartbeats is
/// released.
namespace gecos::media {

inline constexpr std::size_t largest_bulk_packet = std::size_t{32} << 20;
/// The size of an area, in bytes. About this many bytes can be copied in one maintenance tick (10
/// ms). A sender that finds the area full waits for the next tick; an area of this size keeps that
/// wait from limiting the throughput.
inline constexpr std::size_t area_bytes = std::size_t{64} << 20;
inline constexpr unsigned area_kept = 100;  ///< number of heartbeats: 10 s

/// The interface that makes areas and announces them to the reader. Each medium implements it.
class AreaMaker {
 public:
  virtual ~AreaMaker() = default;
  /// Makes an area: area_bytes bytes of zeroed memory. Announces the area to the reader under the
  /// number `number`. Returns null when this is not possible now.
  virtual std::shared_ptr<Mapping> make_area(std::uint64_t number) = 0;
  /// Tells the reader that the area is not used any more. Returns false when the reader cannot be
  /// told now.
  virtual bool release(std::uint64_t number) = 0;
};

/// Sends large packets. Only the thread that writes the ring may call write(), place() and
/// send_placed().
class BulkWriter {
 public:
  BulkWriter(RingWriter& ring, AreaMaker& maker) : ring_(ring), maker_(maker) {}

  /// Sends a large packet, like RingWriter::write(). Fails with Full also when no memory can be
  /// allocated.
  tl::expected<std::uint64_t, SendProblem> write(ByteView head, ByteView body);
  /// The functions place() and send_placed() send a packet in two steps, so that the caller can
  /// build the packet in the area. place() returns `size` bytes of memory, or an empty span when
  /// there is no room now. send_placed() sends the packet in that memory. Between the two calls
  /// nothing may be written to the ring. If the packet is not sent, the next call of place() takes
  /// the memory back.
  std::span<std::byte> place(std::size_t size);
  std::uint64_t send_placed();

  /// Releases the area when it was not used for a long time. Must be called every 100 ms. Any
  /// thread may call this function.
  void beat();
  /// Must be called in a forked child: detaches the child from the memory of its parent. Takes no
  /// lock, because the child has only one thread, and a thread of the parent may have held the
  /// mutex.
  void forget() noexcept GECOS_NOT_ANALYSED;

 private:
  struct Held {
    std::size_t offset = 0;
    std::size_t bytes = 0;
    std::uint64_t until = 0;  // the memory is free when the reader has taken this many slots
  };
  bool find_room(std::size_t bytes) GECOS_REQUIRES(mutex_);
  bool back(std::size_t end) GECOS_REQUIRES(mutex_);

  RingWriter& ring_;
  AreaMaker& maker_;
  Mutex mutex_;  // needed because beat() may run on another thread than the other functions
  std::shared_ptr<Mapping> area_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t number_ GECOS_GUARDED_BY(mutex_) = 0;  // number of the area
  /// Number of bytes, from the start of the area, that the kernel has backed with memory.
  std::size_t backed_ GECOS_GUARDED_BY(mutex_) = 0;
  std::vector<Held> held_ GECOS_GUARDED_BY(mutex_);  // sorted by offset
  /// The index in `held_` of the packet that place() has placed and send_placed() has not sent yet.
  std::optional<std::size_t> placed_ GECOS_GUARDED_BY(mutex_);
  std::size_t placed_size_ GECOS_GUARDED_BY(mutex_) = 0;
  std::uint64_t last_packet_ GECOS_GUARDED_BY(mutex_) = 0;
  unsigned quiet_beats_ GECOS_GUARDED_BY(mutex_) = 0;
};

/// Receives large packets. Only the thread that reads the ring may call copy() and rest(). Any
/// thread may call the other functions.
class BulkReader final : public BulkSource {
 public:
  /// `look` must process the messages that have arrived from the writer and announce areas.
  explicit BulkReader(std::function<void()> look) : look_(std::move(look)) {}

  /// Sets `area`, which has the number `number`, as the current area in place of the previous area.
  /// @pre the size of `area` is area_bytes
  void know(std::uint64_t number, std::shared_ptr<const Mapping> area);
  /// Like know(), for an area that this process has no address space to map: the packets are read
  /// from `memfd` by system calls, which takes longer. @pre the memory has area_bytes bytes
  void know_unmapped(std::uint64_t number, Descriptor memfd);
  /// Must be called when the writer has released the area `number`.
  void end(std::uint64_t number);

  std::optional<ByteView> copy(const BulkPlace& place) override;
  /// Must be called before the reading thread sleeps. Frees the reader's copy of the last large
  /// packet if the area of that packet was released.
  void rest() {
    if (ended_.load(std::memory_order_relaxed)) free_copy();
  }
  /// Must be called in a forked child: detaches the child from the memory of its parent. Takes no
  /// lock, because the child has only one thread, and a thread of the parent may have held the
  /// mutex.
  void forget() noexcept GECOS_NOT_ANALYSED;

 private:
  /// The memory of an area: either a mapping or, if the area is not mapped, a memfd.
  struct Area {
    std::shared_ptr<const Mapping> mapping;
    std::shared_ptr<Descriptor> memfd;
    bool known() const { return mapping != nullptr || memfd != nullptr; }
  };
  void set(std::uint64_t number, Area area);
  Area find(std::uint64_t number);
  bool is_valid(const BulkPlace& place, const Area& area) const;
  bool back(const BulkPlace& place, const Mapping& area);
  void make_room(std::size_t size);
  void free_copy();

  const std::function<void()> look_;
  // The following members are used only by the reading thread.
  std::unique_ptr<std::byte[]> copy_;
  std::size_t copy_bytes_ = 0;
  std::uint64_t backed_area_ = 0;
  std::size_t backed_ = 0;  // bytes of backed_area_ that are mapped in: reading them cannot fail
  std::atomic<bool> ended_{false};  // tells the reader to free its copy; orders no other memory

  Mutex mutex_;
  Area area_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t number_ GECOS_GUARDED_BY(mutex_) = 0;
};

}  // namespace gecos::media
