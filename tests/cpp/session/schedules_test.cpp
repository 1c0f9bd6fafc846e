// 100,000 schedules of real sessions and a real object: nothing starts once its caller was told an
// end. SCHEDULES and SCHEDULES_SEED ask for others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <future>

#include "schedules/schedule.hpp"

namespace gecos::session::schedules {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t standard_count = 20'000;
#else
constexpr std::uint64_t standard_count = 100'000;
#endif

std::uint64_t asked(const char* variable, std::uint64_t standard) {
  const char* const text = std::getenv(variable);
  return text == nullptr ? standard : std::strtoull(text, nullptr, 10);
}

struct Told {
  std::uint64_t schedules = 0;
  std::size_t commands = 0;
  std::size_t freezes = 0;
  std::size_t begun_in_vain = 0;
  std::vector<std::string> alarms;  ///< of the first that was wrong
};

/// Never destroyed: the maintenance thread of a runtime may read the clock until the program ends.
struct World {
  ScheduleClock clock;
  const std::shared_ptr<Runtime> runtime = std::make_shared<Runtime>(LabOptions{}, clock);
};

World& world() {
  static World& only = *new World;
  return only;
}

/// Seeds from `first` on, until one of them was wrong.
Told run(std::uint64_t first, std::uint64_t count, Mutant mutant = Mutant::None) {
  ScheduleClock& clock = world().clock;
  const std::shared_ptr<Runtime>& runtime = world().runtime;
  Told told;
  constexpr std::uint64_t at_once = 100;  // then maintenance does what was left to it
  for (std::uint64_t seed = first; seed < first + count && told.alarms.empty(); seed += at_once) {
    // Shared: set_value may still be at work when its waiter goes on.
    const auto done = std::make_shared<std::promise<void>>();
    runtime->maintenance().post([&, done] {
      for (std::uint64_t one = seed; one < std::min(seed + at_once, first + count); ++one) {
        Schedule schedule(runtime, clock, one, mutant);
        told.alarms = schedule.run();
        ++told.schedules;
        told.commands += schedule.commands();
        told.freezes += static_cast<std::size_t>(schedule.freezes());
        told.begun_in_vain += schedule.begun_in_vain();
        if (told.alarms.empty()) continue;
        told.alarms.insert(told.alarms.begin(), "seed " + std::to_string(one));
        break;
      }
      done->set_value();
    });
    done->get_future().wait();
  }
  return told;
}

class Schedules : public ::testing::TestWithParam<int> {};

constexpr int parts = 4;
INSTANTIATE_TEST_SUITE_P(Part, Schedules, ::testing::Range(0, parts));

TEST_P(Schedules, StartNothingForACallerThatWasToldAnEndAndEndEachCommandOnce) {
  const std::uint64_t count = asked("SCHEDULES", standard_count) / parts;
  const std::uint64_t first =
      asked("SCHEDULES_SEED", 1) + count * static_cast<std::uint64_t>(GetParam());
  const Told told = run(first, count);
  std::printf("seeds %llu to %llu: %zu commands, %zu freezes, %zu begun in vain\n",
              static_cast<unsigned long long>(first),
              static_cast<unsigned long long>(first + told.schedules - 1), told.commands,
              told.freezes, told.begun_in_vain);
  EXPECT_TRUE(told.alarms.empty()) << ::testing::PrintToString(told.alarms);
  EXPECT_GT(told.begun_in_vain, 0u) << "no freeze fell between mark and handler";
}

/// The handler of a command begins whose caller was told OUTCOME_UNKNOWN after its mark.
class BegunInVain : public ::testing::Test {
 protected:
  static const OperationDescription& operation(std::string_view name) {
    return *std::ranges::find(bench().operations, name, &OperationDescription::name);
  }
  std::size_t begin(std::string_view name, int freeze) {
    const TimePoint marked = now_;
    const std::size_t number = judge_.issued(operation(name), now_, Duration{});
    auto command = std::make_shared<PendingCommand>(Failure{Detail::OutcomeUnknown, "", {}, {}});
    command->observe();
    judge_.sent(number, std::move(command));
    judge_.look(now_ += std::chrono::seconds(1));
    judge_.began(number, marked, now_ += std::chrono::seconds(1), freeze);
    return number;
  }
  TimePoint now_{std::chrono::hours(1)};
  Judge judge_;
};

TEST_F(BegunInVain, IsOneCommandForEachFreeze) {
  begin("tap", 1);
  begin("file", 2);
  EXPECT_TRUE(judge_.alarms().empty()) << judge_.alarms().front();
  begin("tap", 2);
  EXPECT_EQ(judge_.alarms().size(), 1U);
}

TEST_F(BegunInVain, IsOneParallelCommandForEachThatRuns) {
  begin("glide", 1);
  const auto second = begin("glide", 1);
  EXPECT_TRUE(judge_.alarms().empty()) << judge_.alarms().front();
  judge_.finished(second);
  begin("glide", 1);
  EXPECT_EQ(judge_.alarms().size(), 1U);
  EXPECT_EQ(judge_.begun_in_vain(), 3U);
}

class Mutants : public ::testing::TestWithParam<Mutant> {};
INSTANTIATE_TEST_SUITE_P(Of, Mutants,
                         ::testing::Values(Mutant::WithdrawalReadBeforeMark,
                                           Mutant::WithdrawalForgotten, Mutant::PauseForgotten,
                                           Mutant::ClosingIsGoodbye));

constexpr std::uint64_t most_of_a_mutant = 200'000;  // the rarest takes 3,000 to more than 25,000

TEST_P(Mutants, AreFound) {
  const Told told = run(asked("SCHEDULES_SEED", 1), most_of_a_mutant, GetParam());
  std::printf("after %llu schedules: %s\n", static_cast<unsigned long long>(told.schedules),
              ::testing::PrintToString(told.alarms).c_str());
  EXPECT_FALSE(told.alarms.empty());
}

}  // namespace
}  // namespace gecos::session::schedules
