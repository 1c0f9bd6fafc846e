// Being told of a command's end instead of waiting for it.
#include <gtest/gtest.h>

#include <coroutine>
#include <future>
#include <optional>
#include <stdexcept>
#include <thread>

#include "over_media.hpp"

namespace {

using gecos::Detail;
using Moved = tl::expected<std::int32_t, gecos::Failure>;

class Callbacks : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
    auto lease = gecos::actor(probe_);
    ASSERT_TRUE(lease) << lease.error();
    lease_.emplace(std::move(*lease));
  }
  probe::Probe probe_;
  std::optional<gecos::Lease> lease_;
};
PROBE_OVER_MEDIA(Callbacks);

TEST_P(Callbacks, AreToldTheResultThoughNobodyWaitsAndTheCommandWasDropped) {
  std::promise<Moved> told;
  probe_.move(1).then([&](const Moved& moved) { told.set_value(moved); });
  servant_.await_moves(1);
  servant_.open_gate();
  EXPECT_TRUE(told.get_future().get());
}

TEST_P(Callbacks, AreToldAtOnceWhatEndedBefore) {
  const auto set = probe_.set(3);
  ASSERT_EQ(set.wait(), gecos::State::Finished);
  std::thread::id where;
  set.then([&](const Moved& result) {
    where = std::this_thread::get_id();
    EXPECT_EQ(result.value(), 3);
  });
  EXPECT_EQ(where, std::this_thread::get_id());
}

TEST_P(Callbacks, MayWaitForOtherCommands) {
  std::promise<std::int32_t> told;
  probe_.move(1).then([&](const Moved&) { told.set_value(probe_.read().get().value_or(-1)); });
  servant_.await_moves(1);
  servant_.open_gate();
  EXPECT_NE(told.get_future().get(), -1);
}

TEST_P(Callbacks, GoOnWhenOneThrows) {
  std::promise<void> told;
  const auto move = probe_.move(1);
  move.then([](const Moved&) { throw std::runtime_error("of the test"); });
  move.then([&](const Moved&) { told.set_value(); });
  servant_.await_moves(1);
  servant_.open_gate();
  told.get_future().get();
}

TEST_P(Callbacks, ThrowToNobodyWhenTheirCommandHasEndedBefore) {
  const auto set = probe_.set(3);
  ASSERT_EQ(set.wait(), gecos::State::Finished);
  EXPECT_NO_THROW(set.then([](const Moved&) { throw std::runtime_error("of the test"); }));
  EXPECT_NO_THROW(set.then([](const Moved&) { throw 7; }));
}

TEST_P(Callbacks, AreToldOfTheirServersEnd) {
  std::promise<Moved> told;
  probe_.move(1).then([&](const Moved& moved) { told.set_value(moved); });
  servant_.await_moves(1);
  server_.reset();
  const auto moved = told.get_future().get();
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().detail, Detail::Stopped);
}

TEST_P(Callbacks, MayHoldTheLastOfTheirLab) {
  std::promise<void> told;
  auto lab = std::make_unique<gecos::Lab>();
  {
    auto own = connect(*lab);
    const auto read = own.read();
    read.then(
        [own, lab = std::shared_ptr<gecos::Lab>(std::move(lab)), &told](const Moved&) mutable {
          lab.reset();
          told.set_value();
        });
  }
  told.get_future().get();
}

/// The least that a coroutine needs: it starts at once and tells its end to a promise.
struct Program {
  struct promise_type {
    Program get_return_object() { return {ended.get_future()}; }
    std::suspend_never initial_suspend() { return {}; }
    std::suspend_never final_suspend() noexcept { return {}; }
    void return_value(std::int32_t value) { ended.set_value(value); }
    void unhandled_exception() { ended.set_exception(std::current_exception()); }
    std::promise<std::int32_t> ended;
  };
  std::future<std::int32_t> ended;
};

Program move_and_read(probe::Probe probe) {
  const auto moved = co_await probe.move(1);
  if (!moved) throw std::runtime_error(moved.error().text);
  const auto read = co_await probe.read();
  if (!read) throw std::runtime_error(read.error().text);
  co_return *read;
}

TEST_P(Callbacks, AreWhatCoroutinesStandOn) {
  auto program = move_and_read(probe_);
  servant_.await_moves(1);
  servant_.open_gate();
  EXPECT_EQ(program.ended.get(), 7);
}

}  // namespace
