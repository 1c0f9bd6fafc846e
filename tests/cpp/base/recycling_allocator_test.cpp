#include "gecos/base/recycling_allocator.hpp"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <thread>
#include <vector>

namespace gecos {
namespace {

struct Block {
  explicit Block(int its_number) : number(its_number) {}
  int number;
  std::array<char, 300> rest{};
};

TEST(RecyclingAllocator, WhatIsKeptManyAtOnceStaysApart) {
  std::vector<std::shared_ptr<Block>> blocks;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 200; ++i) blocks.push_back(make_recycled<Block>(i));
    for (int i = 0; i < 200; ++i) EXPECT_EQ(blocks[static_cast<std::size_t>(i)]->number, i);
    blocks.clear();
  }
}

TEST(RecyclingAllocator, ABlockMayBeGivenBackByAnotherThread) {
  for (int round = 0; round < 100; ++round) {
    auto block = make_recycled<Block>(round);
    std::thread([given = std::move(block), round] { EXPECT_EQ(given->number, round); }).join();
  }
}

/// Is destroyed after what its thread keeps, which it touches first.
struct Late {
  std::shared_ptr<Block> block;
};

TEST(RecyclingAllocator, ABlockMayOutliveWhatItsThreadKept) {
  std::thread([] {
    thread_local Late late;
    late.block = make_recycled<Block>(1);
    make_recycled<Block>(2).reset();  // the thread's store is made after `late`: it ends before
  }).join();
}

}  // namespace
}  // namespace gecos
