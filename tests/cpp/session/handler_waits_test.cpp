// Handlers that wait for each other, and what is told of those that take long.
#include <unistd.h>

#include <future>
#include <mutex>

#include "over_media.hpp"

namespace {

using gecos::Detail;
using Answer = tl::expected<std::int32_t, gecos::Failure>;

void answer(gecos::IncomingCall& call, std::int32_t value) {
  call.finish(4, [&](gecos::wire::Encoder& to) { to.put(value); });
}

/// What a handler leaves for its test. The mutex is for ThreadSanitizer: over shm it does not see
/// that the test goes on after the handler, because each side has its own mapping of the memory.
template <class T>
class Left {
 public:
  void set(T value) {
    const std::lock_guard lock(mutex_);
    value_.emplace(std::move(value));
  }
  std::optional<T> get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<T> value_;
};

/// One handler of an object runs at a time, so a handler holds up all others of its object.
class HandlerWaits : public probe::Bench, public ::testing::WithParamInterface<gecos::media::Kind> {
 protected:
  HandlerWaits() : Bench(GetParam()) {}
  void SetUp() override {
    Bench::SetUp();
    serve("PROBE", servant_, false);
    serve("OTHER", other_, false);
    probe_ = connect(lab_);
    within_ = connect(second_lab_);
    beyond_ = connect(second_lab_, "OTHER");
  }
  void TearDown() override { server_.reset(); }  // before the servant that only this test has

  probe::ProbeServant other_;
  probe::Probe probe_;   ///< of the test
  probe::Probe within_;  ///< of the handlers
  probe::Probe beyond_;
};
PROBE_OVER_MEDIA(HandlerWaits);

TEST_P(HandlerWaits, ForACallThatCannotStartBeforeTheyReturnAreToldSo) {
  Left<Answer> left;
  servant_.on_read([&](gecos::IncomingCall call) {
    left.set(within_.read().get());
    answer(call, 1);
  });
  ASSERT_EQ(probe_.read().get().value_or(0), 1);
  const Answer inner = left.get().value();
  ASSERT_FALSE(inner);
  EXPECT_EQ(inner.error().detail, Detail::Rejected);
  EXPECT_EQ(inner.error().text,
            "'read' of PROBE was not started: the handler of 'read' of PROBE waits for this call, "
            "and this call "
            "cannot start before that handler returns; call the method of the servant directly, or "
            "wait in another thread");
}

TEST_P(HandlerWaits, ForEachOtherEndWithTheWholeCircle) {
  Left<Answer> left_by_probe;
  Left<Answer> left_by_other;
  servant_.on_read([&](gecos::IncomingCall call) {
    left_by_probe.set(beyond_.read().get());
    answer(call, 1);
  });
  other_.on_read([&](gecos::IncomingCall call) {
    left_by_other.set(within_.read().get());
    answer(call, 2);
  });
  ASSERT_EQ(probe_.read().get().value_or(0), 1);
  EXPECT_EQ(left_by_probe.get().value().value_or(0), 2);
  const Answer of_other = left_by_other.get().value();
  ASSERT_FALSE(of_other);
  EXPECT_EQ(of_other.error().detail, Detail::Rejected);
  EXPECT_EQ(
      of_other.error().text.find(
          "'read' of PROBE was not started: the handler of 'read' of OTHER waits for this call, "
          "and this call "
          "cannot start before the handler of 'read' of PROBE returns; that handler waits for a "
          "call that cannot end before the first handler returns"),
      0u)
      << of_other.error();
}

TEST_P(HandlerWaits, WithABoundWaitAsLongAsTheySay) {
  Left<gecos::Command<std::int32_t>> inner;
  Left<gecos::State> at_the_bound;
  servant_.on_read([&](gecos::IncomingCall call) {
    if (!inner.get()) {
      const auto command = within_.read();
      inner.set(command);
      at_the_bound.set(command.wait_for(std::chrono::milliseconds(400)));
    }
    answer(call, 1);
  });
  ASSERT_EQ(probe_.read().get().value_or(0), 1);
  EXPECT_EQ(at_the_bound.get(), gecos::State::Running);
  EXPECT_EQ(inner.get()->get().value_or(0), 1);
}

TEST_P(HandlerWaits, AreDescribedWithTheirCallerAndWhatTheyWaitFor) {
  std::promise<void> go_on;
  other_.on_read([gate = go_on.get_future().share()](gecos::IncomingCall call) {
    gate.wait();
    answer(call, 2);
  });
  servant_.on_read(
      [&](gecos::IncomingCall call) { answer(call, beyond_.read().get().value_or(-1)); });
  const auto read = probe_.read();
  gecos::Description about;
  EXPECT_TRUE(settles([&] {
    about = gecos::describe(within_).get().value();
    return !about.handlers.empty() && about.handlers[0].waits_for == "OTHER.read";
  }));
  ASSERT_EQ(about.handlers.size(), 1u);
  const auto& handler = about.handlers[0];
  EXPECT_EQ(handler.operation, "read");
  EXPECT_EQ(handler.pid, getpid());
  EXPECT_GE(handler.running_for, 0.0);
  EXPECT_EQ(handler.program, "session_test");
  go_on.set_value();
  EXPECT_EQ(read.get().value_or(0), 2);
  EXPECT_TRUE(settles([&] { return gecos::describe(within_).get().value().handlers.empty(); }));
}

}  // namespace
