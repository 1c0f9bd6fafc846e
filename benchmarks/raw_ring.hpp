// A ring in shared memory as small as one can be: slots with a sequence number each, one writer,
// one reader.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace gecos::benchmarks {

template <class Packet>
class RawRing {
 public:
  static constexpr std::uint64_t capacity = 64;

  /// Overwrites what was put `capacity` packets before.
  void put(std::uint64_t number, const Packet& packet) {
    Slot& slot = slots_[number % capacity];
    slot.packet = packet;
    slot.sequence.store(number, std::memory_order_release);  // publishes the packet to the reader
  }
  bool holds(std::uint64_t number) const {
    return slots_[number % capacity].sequence.load(std::memory_order_acquire) == number;
  }
  template <class Wait>
  void get(std::uint64_t number, Packet& packet, Wait wait) const {
    while (!holds(number)) wait();
    packet = slots_[number % capacity].packet;
  }

 private:
  struct alignas(64) Slot {
    std::atomic<std::uint64_t> sequence{0};
    Packet packet{};
  };
  std::array<Slot, capacity> slots_;
};

}  // namespace gecos::benchmarks
