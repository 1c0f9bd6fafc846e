// Types of fixed size are encoded and decoded without memory of their own.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>

#include "everything_types.hpp"
#include "robcl/laser_distance_sensor_types.hpp"
#include "robcl/six_axis_types.hpp"

namespace {

std::atomic<int> allocations{0};  // publishes nothing but itself

template <class T>
int allocations_of_a_round_trip() {
  std::array<std::byte, 256> buffer;
  T value, again;
  allocations = 0;
  const std::size_t size = value.encoded_size();
  gecos::wire::Encoder to(buffer);
  value.encode(to);
  gecos::wire::Decoder from(gecos::ByteView(buffer.data(), size));
  const bool decoded = again.decode(from);
  const int counted = allocations;
  EXPECT_TRUE(decoded);
  EXPECT_EQ(to.written(), size);
  EXPECT_EQ(value, again);
  return counted;
}

}  // namespace

// Not inlined: g++ would see malloc and delete, and take them for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

TEST(GeneratedAllocation, FixedSizeTypesNeedNone) {
  EXPECT_EQ(allocations_of_a_round_trip<robcl::Frame>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<robcl::Vector>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<robcl::Joints>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<robcl::Distance>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<everything::Numbers>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<everything::Masks>(), 0);
}

TEST(GeneratedAllocation, TheCounterCounts) {
  allocations = 0;
  int* volatile seven = new int(7);  // volatile: an optimizer may leave out an unused pair
  delete seven;
  EXPECT_GE(allocations, 1);
}
