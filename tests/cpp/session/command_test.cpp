// How commands end: canceled, late, replaced, or with their server.
#include <poll.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>

#include "await_detail.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;
using gecos::State;

class Commands : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
    auto lease = gecos::actor(probe_);
    ASSERT_TRUE(lease) << lease.error();
    lease_.emplace(std::move(*lease));
  }
  /// Calls an operation as a program does whose interface declares the deadline on it.
  std::shared_ptr<gecos::session::CommandCore> call_declared(
      gecos::FunctionCode code, gecos::Duration deadline, const gecos::CallOptions& options = {}) {
    gecos::OperationDescription declared = probe::operation(code);
    declared.quality.deadline = deadline;
    auto command = probe_.session()->call(
        declared, 4, [](gecos::wire::Encoder& to) { to.put(std::int32_t{1}); }, options);
    command->observe();
    return command;
  }
  probe::Probe probe_;
  std::optional<gecos::Lease> lease_;
};
PROBE_OVER_MEDIA(Commands);

TEST_P(Commands, AreCanceledWhileTheyQueue) {
  const auto first = probe_.move(1);
  const auto second = probe_.move(2);
  servant_.await_moves(1);
  probe::await_detail(second, Detail::Queued);
  EXPECT_EQ(second.progress().position, 1u);
  second.cancel();
  EXPECT_EQ(second.get().error().detail, Detail::Canceled);
  servant_.open_gate();
  EXPECT_EQ(first.wait(), State::Finished);
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "end 1"}));
}

TEST_P(Commands, AreCanceledWhileTheyExecuteWithWhatTheirCallerQueuedBehind) {
  const auto first = probe_.move(1);
  const auto second = probe_.move(2);
  servant_.await_moves(1);
  first.cancel();
  EXPECT_EQ(first.get().error().detail, Detail::Canceled);
  EXPECT_EQ(second.get().error().detail, Detail::Canceled);
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "interrupted 1"}));
}

TEST_P(Commands, StayAsTheyEndedWhenCanceledAfterwards) {
  const auto set = probe_.set(4);
  ASSERT_EQ(set.wait(), State::Finished);
  set.cancel();
  ASSERT_TRUE(gecos::ping(probe_).get());
  EXPECT_EQ(set.state(), State::Finished);
}

TEST_P(Commands, ThatAreDroppedStillRun) {
  static_cast<void>(probe_.set(9));
  servant_.await_event("set 9");
  EXPECT_EQ(probe_.read().get().value(), 9);
}

TEST_P(Commands, ExpireWhenTheirDeadlinePassesInTheQueue) {
  const auto first = probe_.move(1);
  servant_.await_moves(1);
  const auto late = gecos::with(probe_, {.deadline = 5ms}).set(2);
  EXPECT_EQ(late.get().error().detail, Detail::Expired);
  servant_.open_gate();
  EXPECT_EQ(first.wait(), State::Finished);
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "end 1"}));
}

TEST_P(Commands, AreNotSentWhenTheirDeadlineHasPassedAlready) {
  for (const gecos::Duration left :
       {gecos::Duration(), gecos::Duration(-1), gecos::Duration::min()}) {
    const auto late = gecos::with(probe_, {.deadline = left});
    for (const auto& [command, name] :
         {std::pair(late.set(2), "set"), std::pair(late.look(), "look")}) {
      const auto ended = command.get();
      ASSERT_FALSE(ended);
      EXPECT_EQ(ended.error().detail, Detail::Expired);
      EXPECT_EQ(
          ended.error().text,
          "the deadline of '" + std::string(name) +
              "' passed before the call was sent; the call was not carried out: allow it more "
              "time");
      EXPECT_EQ(command.id(), gecos::CommandId{});
    }
  }
  EXPECT_EQ(gecos::with(probe_, {}).set(3).get().value(), 3);
  EXPECT_EQ(servant_.events(), std::vector<std::string>{"set 3"});
}

TEST_P(Commands, TimeOutWhenTheirDeadlinePassesWhileTheyExecute) {
  // On a busy machine, a short deadline may pass before the handler begins.
  Detail end{};
  for (gecos::Duration deadline = 30ms; servant_.events().empty() && deadline < 60s;
       deadline *= 2) {
    end = gecos::with(probe_, {.deadline = deadline}).move(1).get().error().detail;
  }
  EXPECT_EQ(end, Detail::TimedOut);
  servant_.await_event("interrupted 1");
}

TEST_P(Commands, TimeOutWhenTheDeadlinePassesThatTheirOperationDeclares) {
  Detail end{};
  for (gecos::Duration deadline = 50ms; servant_.events().empty() && deadline < 60s;
       deadline *= 2) {
    const auto move = call_declared(probe::move_code, deadline);
    move->wait_until(gecos::deadline_after(deadline + 20s));
    end = move->progress().detail;
  }
  EXPECT_EQ(end, Detail::TimedOut);
  servant_.await_event("interrupted 1");
}

TEST_P(Commands, ThatMayBeSentAgainTimeOutWhenTheDeclaredDeadlinePasses) {
  std::mutex mutex;
  std::vector<gecos::IncomingCall> begun;
  servant_.on_read([&](gecos::IncomingCall call) {
    const std::lock_guard lock(mutex);
    begun.push_back(std::move(call));
  });
  const auto any_begun = [&] {
    const std::lock_guard lock(mutex);
    return !begun.empty();
  };
  Detail end{};
  for (gecos::Duration deadline = 50ms; !any_begun() && deadline < 60s; deadline *= 2) {
    const auto look = call_declared(probe::look_code, deadline);
    look->wait_until(gecos::deadline_after(deadline + 20s));
    end = look->progress().detail;
  }
  EXPECT_EQ(end, Detail::TimedOut);
  servant_.on_read(nullptr);
  const std::lock_guard lock(mutex);
  for (auto& call : begun) call.fail({Detail::Rejected, "enough", {}, {}});
}

TEST_P(Commands, TakeTheDeadlineOfTheirCallerInPlaceOfTheDeclaredOne) {
  for (const auto code : {probe::set_code, probe::look_code}) {
    const auto call = call_declared(code, 1ns, {.deadline = 1h});
    call->wait_until(gecos::TimePoint::max());
    EXPECT_EQ(call->progress().detail, Detail::Done) << call->failure();
  }
}

TEST_P(Commands, AreRefusedWhenTheirClientHasTooManyWaiting) {
  std::vector<gecos::Command<std::int32_t>> moves;
  moves.push_back(probe_.move(0));
  servant_.await_moves(1);
  for (int at = 1; at <= 64; ++at) moves.push_back(probe_.set(at));
  EXPECT_EQ(probe_.set(65).get().error().detail, Detail::QueueFull);
  servant_.open_gate();
  for (const auto& move : moves) EXPECT_EQ(move.wait(), State::Finished);
}

TEST_P(Commands, OfAClientWithoutCreditsAreStoppedAndItsStatusGivenBack) {
  std::mutex mutex;
  std::vector<gecos::IncomingCall> unanswered;
  servant_.on_read([&](gecos::IncomingCall call) {
    const std::lock_guard lock(mutex);
    unanswered.push_back(std::move(call));
  });
  const auto move = probe_.move(1);
  std::vector<gecos::Command<std::int32_t>> reads;
  for (int at = 1; at < 256; ++at) reads.push_back(probe_.read());
  EXPECT_EQ(probe_.read().get().error().detail, Detail::QueueFull);
  EXPECT_TRUE(gecos::stop(probe_).get());
  EXPECT_EQ(move.get().error().detail, Detail::Stopped);
  EXPECT_TRUE(probe_.urgent().get());
  lease_.reset();
  EXPECT_TRUE(gecos::holders(probe_).get().value().empty());
  const std::lock_guard lock(mutex);
  for (auto& call : unanswered) call.fail({Detail::Rejected, "enough", {}, {}});
}

TEST_P(Commands, RunInTheOrderInWhichTheyWereIssued) {
  std::vector<gecos::Command<std::int32_t>> sets;
  std::vector<std::string> expected;
  for (int at = 1; at <= 50; ++at) {
    sets.push_back(probe_.set(at));
    expected.push_back("set " + std::to_string(at));
  }
  for (const auto& set : sets) EXPECT_EQ(set.wait(), State::Finished);
  EXPECT_EQ(servant_.events(), expected);
}

TEST_P(Commands, AreAnsweredLaterFromAnotherThread) {
  struct Answering {
    std::mutex mutex;
    std::vector<std::thread> threads;
  };
  const auto answering = std::make_shared<Answering>();
  servant_.on_read([answering](gecos::IncomingCall call) {
    const std::lock_guard lock(answering->mutex);
    answering->threads.emplace_back(
        [call = std::make_shared<gecos::IncomingCall>(std::move(call))] {
          call->finish(4, [](gecos::wire::Encoder& to) { to.put(std::int32_t{11}); });
        });
  });
  EXPECT_EQ(probe_.read().get().value(), 11);
  EXPECT_EQ(probe_.read().get().value(), 11);
  const std::lock_guard lock(answering->mutex);
  for (auto& thread : answering->threads) thread.join();
}

TEST_P(Commands, AreFaultWhenTheirServantThrowsWhateverItThrows) {
  servant_.on_read([](gecos::IncomingCall) { throw 7; });
  const auto read = probe_.read().get();
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().detail, Detail::Fault);
  servant_.on_read(nullptr);
  EXPECT_EQ(probe_.read().get().value(), 7) << "the server goes on";
}

TEST_P(Commands, OfAWorkerAreFaultToo) {
  servant_.on_move([] { throw 7; });
  const auto moved = probe_.move(1).get();
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().detail, Detail::Fault);
  EXPECT_EQ(probe_.set(3).get().value(), 3) << "its queue goes on";
}

TEST_P(Commands, AreFaultWhenTheirHandlerDropsThem) {
  servant_.on_read([](gecos::IncomingCall) {});
  const auto read = probe_.read().get();
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().detail, Detail::Fault);
  EXPECT_EQ(read.error().text, "the handler of 'read' gave no answer");
}

TEST_P(Commands, TellTheirEndOnADescriptorThoughNobodyWaits) {
  const auto move = probe_.move(1);
  servant_.await_moves(1);
  pollfd waits{move.descriptor(), POLLIN, 0};
  EXPECT_EQ(poll(&waits, 1, 0), 0);
  servant_.open_gate();
  EXPECT_EQ(poll(&waits, 1, 10'000), 1);
  EXPECT_EQ(move.state(), State::Finished);
}

TEST_P(Commands, EndWhenTheirServerEndsInOrder) {
  const auto move = probe_.move(1);
  const auto set = probe_.set(2);
  servant_.await_moves(1);
  probe::await_detail(set, Detail::Queued);
  server_.reset();
  EXPECT_EQ(move.get().error().detail, Detail::Stopped);
  EXPECT_EQ(set.get().error().detail, Detail::Stopped);
  EXPECT_NE(gecos::ping(probe_).wait(),
            State::Finished);  // over lcm it may be this one that finds out
  const auto later = probe_.read().get();
  ASSERT_FALSE(later);
  EXPECT_EQ(later.error().state(), State::ConnectionFailed) << later.error();
}

TEST_P(Commands, ReachManyThreadsThroughOneProxy) {
  constexpr int thread_count = 6;
  constexpr int calls = 300;
  std::atomic<int> right{0};
  std::vector<std::thread> threads;
  for (int at = 0; at < thread_count; ++at) {
    threads.emplace_back([&, at] {
      for (int call = 0; call < calls; ++call) {
        if ((call + at) % 7 == 0) {
          right += gecos::ping(probe_).get().has_value() ? 1 : 0;
        } else {
          right += probe_.read().get().value_or(-1) == 7 ? 1 : 0;
        }
      }
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(right.load(), thread_count * calls);
}

TEST_P(Commands, OfASlowHandlerDoNotKeepOthersWaiting) {
  const auto go_on = std::make_shared<std::atomic<bool>>(false);
  servant_.on_read([go_on](gecos::IncomingCall call) {
    go_on->wait(false);
    call.finish(4, [](gecos::wire::Encoder& to) { to.put(std::int32_t{1}); });
  });
  const auto slow = probe_.read();
  const auto other = connect(second_lab_);
  EXPECT_TRUE(gecos::ping(other).get()) << "a standby polls while the handler runs";
  EXPECT_EQ(slow.state(), State::Running);
  go_on->store(true);
  go_on->notify_all();
  EXPECT_EQ(slow.get().value(), 1);
}

}  // namespace
