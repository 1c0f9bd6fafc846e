#include <gtest/gtest.h>

#include "../robcl/allocations.hpp"
#include "channel_pair.hpp"
#include "gecos/crypto/stream_seal.hpp"

namespace gecos::crypto {
namespace {

TEST(Allocation, SealingOpeningRefusingAndChangingKeysTakeNoMemory) {
  auto pair = gecos::testing::open_pair({.packets = 10});
  StreamSealer writer;
  StreamOpener reader(writer.key());
  Bytes frame(Sealer::overhead + 1400);
  Bytes sample(StreamSealer::overhead + 1400);
  const Bytes header(16);
  int wrong = 0;
  const robcl::CountAllocations allocations;
  for (int i = 0; i < 100; ++i) {
    pair.client.out.seal(header, frame);
    wrong += pair.server.in.open(header, frame) ? 0 : 1;
    wrong += pair.server.in.open(header, frame) ? 1 : 0;
    pair.client.out.on_tick(gecos::testing::pair_opened + i * std::chrono::minutes{1});
    pair.server.in.on_tick(gecos::testing::pair_opened + i * std::chrono::minutes{1});
    writer.seal(header, sample);
    wrong += reader.open(header, sample) ? 0 : 1;
  }
  EXPECT_EQ(allocations.so_far(), 0);
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(pair.client.out.generation(), 10U);
}

}  // namespace
}  // namespace gecos::crypto
