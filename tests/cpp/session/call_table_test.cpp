#include "gecos/session/protocol/call_table.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace gecos::session {
namespace {

TEST(CallTable, HasNothingUnderCounterZero) {
  CallTable<int> table;
  EXPECT_EQ(table.find(0), nullptr) << "a free slot is nobody's call";
  EXPECT_EQ(table.take(0), nullptr);
  table.insert(1, std::make_shared<int>(1));
  EXPECT_EQ(table.find(0), nullptr);
  EXPECT_EQ(table.take(0), nullptr);
  EXPECT_EQ(table.size(), 1u);
}

TEST(CallTable, BehavesAsAMapUnderRandomUse) {
  std::mt19937 random(5);
  CallTable<int> table;
  std::map<std::uint64_t, std::shared_ptr<int>> model;
  std::uint64_t counter = 1;
  for (int step = 0; step < 20000; ++step) {
    if (random() % 2 == 0 || model.empty()) {
      auto call = std::make_shared<int>(step);
      table.insert(counter, call);
      model.emplace(counter++, std::move(call));
    } else {
      auto chosen = model.begin();
      std::advance(chosen, static_cast<std::ptrdiff_t>(random() % model.size()));
      ASSERT_EQ(table.take(chosen->first), chosen->second);
      model.erase(chosen);
    }
    if (model.size() > 100) {
      ASSERT_EQ(table.take(model.begin()->first), model.begin()->second);
      model.erase(model.begin());
    }
    ASSERT_EQ(table.size(), model.size());
    ASSERT_EQ(table.lowest(), model.empty() ? 0 : model.begin()->first);
  }
  for (const auto& [known, call] : model) {
    ASSERT_NE(table.find(known), nullptr);
    EXPECT_EQ(*table.find(known), call);
  }
  EXPECT_EQ(table.find(counter), nullptr);
  EXPECT_EQ(table.take(counter), nullptr);
}

TEST(CallTable, GivesAllInTheOrderOfTheirCounters) {
  CallTable<int> table;
  for (const std::uint64_t counter : {40u, 8u, 24u, 16u}) {
    table.insert(counter, std::make_shared<int>(0));
  }
  std::vector<std::uint64_t> counters;
  for (const auto& [counter, call] : table.take_all()) counters.push_back(counter);
  EXPECT_EQ(counters, (std::vector<std::uint64_t>{8, 16, 24, 40}));
  EXPECT_EQ(table.size(), 0u);
}

}  // namespace
}  // namespace gecos::session
