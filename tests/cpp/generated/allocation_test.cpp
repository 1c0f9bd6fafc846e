// Types of fixed size are encoded and decoded without memory of their own.
#include <gtest/gtest.h>

#include <array>

#include "../robcl/allocations.hpp"
#include "everything_types.hpp"
#include "robcl/laser_distance_sensor_types.hpp"
#include "robcl/six_axis_types.hpp"

namespace {

template <class T>
int allocations_of_a_round_trip() {
  std::array<std::byte, 256> buffer;
  T value, again;
  const robcl::CountAllocations allocations;
  const std::size_t size = value.encoded_size();
  gecos::wire::Encoder to(buffer);
  value.encode(to);
  gecos::wire::Decoder from(gecos::ByteView(buffer.data(), size));
  const bool decoded = again.decode(from);
  const int counted = allocations.so_far();
  EXPECT_TRUE(decoded);
  EXPECT_EQ(to.written(), size);
  EXPECT_EQ(value, again);
  return counted;
}

}  // namespace

TEST(GeneratedAllocation, FixedSizeTypesNeedNone) {
  EXPECT_EQ(allocations_of_a_round_trip<robcl::Frame>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<robcl::Vector>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<robcl::Joints>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<robcl::Distance>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<everything::Numbers>(), 0);
  EXPECT_EQ(allocations_of_a_round_trip<everything::Masks>(), 0);
}
