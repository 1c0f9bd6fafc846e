// Samples of a stream that are given to a function, over every medium.
#include <condition_variable>
#include <future>
#include <mutex>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "../media/child_process.hpp"
#include "../settles.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Listener;
using gecos::StreamEnd;
using Sample = gecos::Sample<std::int32_t>;

/// The samples that a callback got.
class Heard {
 public:
  void add(const Sample& sample) {
    const std::lock_guard lock(mutex_);
    samples_.push_back(sample);
    changed_.notify_all();
  }
  std::vector<Sample> all() const {
    const std::lock_guard lock(mutex_);
    return samples_;
  }
  /// Waits until the last sample has this value.
  bool await(std::int32_t value) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 30s,
                             [&] { return !samples_.empty() && samples_.back().value == value; });
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Sample> samples_;
};

/// Keeps a callback in its first call until the test lets it go.
class Gate {
 public:
  ~Gate() { open(); }
  void pass() {
    if (entered_once_) return;
    entered_once_ = true;
    entered_.set_value();
    opened_.get_future().wait();
  }
  /// Waits until a callback is here.
  bool await() { return entered_.get_future().wait_for(30s) == std::future_status::ready; }
  void open() {
    if (!std::exchange(open_, true)) opened_.set_value();
  }

 private:
  std::promise<void> entered_, opened_;
  bool entered_once_ = false;  ///< used by the callback
  bool open_ = false;          ///< used by the test
};

class Listeners : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
  }
  gecos::Stream<std::int32_t> level() {
    auto opened = probe_.level(gecos::stream);
    if (!opened) throw std::runtime_error(opened.error().text);
    return *std::move(opened);
  }
  auto hear() {
    return [this](const Sample& sample) { heard_.add(sample); };
  }
  /// Whether close() returns although no sample comes. If not, publishes one, so that the test
  /// ends.
  bool closes(Listener<std::int32_t>& listener) {
    auto closing = std::async(std::launch::async, [&] { listener.close(); });
    if (closing.wait_for(30s) == std::future_status::ready) return true;
    servant_.publish(-1);
    return false;
  }

  probe::Probe probe_;
  Heard heard_;
};
PROBE_OVER_MEDIA(Listeners);

TEST_P(Listeners, GetEachSampleOnceAndInOrder) {
  auto listening = gecos::listen(level(), hear());
  for (std::int32_t value = 1; value <= 20; ++value) {
    servant_.publish(value);
    ASSERT_TRUE(heard_.await(value));
  }
  listening.close();
  const auto heard = heard_.all();
  ASSERT_EQ(heard.size(), 20u);
  for (std::size_t i = 0; i < heard.size(); ++i) {
    EXPECT_EQ(heard[i].value, static_cast<std::int32_t>(i + 1));
    EXPECT_EQ(heard[i].sequence, heard[0].sequence + i);
    EXPECT_EQ(heard[i].lost, 0u);
  }
}

TEST_P(Listeners, AreToldHowManySamplesTheyLostWhenTheyAreSlowAndNobodyElseIs) {
  Gate gate;
  auto listening = gecos::listen(level(), [&](const Sample& sample) {
    heard_.add(sample);
    gate.pass();
  });
  auto quick = level();
  for (std::int32_t value = 1; value <= 100; ++value) {
    servant_.publish(value);
    const auto sample = quick.next(30s);
    ASSERT_TRUE(sample) << sample.error();
    EXPECT_EQ(sample->value, value);
    EXPECT_EQ(sample->lost, 0u);
    if (value != 1) continue;
    ASSERT_TRUE(gate.await());
  }
  gate.open();
  ASSERT_TRUE(heard_.await(100));
  listening.close();
  const auto heard = heard_.all();
  const auto told =
      std::accumulate(heard.begin(), heard.end(), std::uint64_t{0},
                      [](auto sum, const Sample& sample) { return sum + 1 + sample.lost; });
  EXPECT_EQ(told, 100u);
  EXPECT_LE(heard.size(), 17u) << "the first one, and the 16 that the server keeps";
}

TEST_P(Listeners, AreToldOnceThatTheServerIsGone) {
  std::vector<StreamEnd> ends;
  std::promise<std::string> told;
  auto listening = gecos::listen(level(), hear(), [&](StreamEnd end, const std::string& loss_text) {
    ends.push_back(end);
    told.set_value(loss_text);  // throws when it is called twice
  });
  servant_.publish(1);
  ASSERT_TRUE(heard_.await(1));
  server_.reset();
  EXPECT_NE(told.get_future().get().find("the server closed the session with PROBE"),
            std::string::npos);
  listening.close();
  EXPECT_EQ(ends, std::vector{StreamEnd::Lost});
  EXPECT_EQ(heard_.all().size(), 1u);
}

TEST_P(Listeners, WithoutAFunctionForTheEndTheLogReportsIt) {
  ::testing::internal::CaptureStderr();
  std::shared_ptr<int> kept = std::make_shared<int>();
  const std::weak_ptr<int> callback = kept;
  auto listening = gecos::listen(level(), [kept = std::move(kept)](const Sample&) {});
  server_.reset();
  EXPECT_TRUE(settles([&] { return callback.expired(); })) << "the thread has ended";
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("the callback of the stream 'level' of PROBE gets no more samples: the server "
                     "closed the session with PROBE"),
            std::string::npos)
      << log;
}

TEST_P(Listeners, EndTheirWaitWhenTheyAreClosed) {
  for (std::int32_t round = 1; round <= 50; ++round) {
    auto listening = gecos::listen(level(), hear());
    if (round % 2 == 0) {  // it has read, and waits, or is about to
      servant_.publish(round);
      ASSERT_TRUE(heard_.await(round));
    }
    ASSERT_TRUE(closes(listening));
    listening.close();
  }
}

TEST_P(Listeners, AreDoneWhenCloseReturns) {
  Gate gate;
  bool ended = false;  // written by the callback, read after close()
  std::shared_ptr<int> kept = std::make_shared<int>();
  const std::weak_ptr<int> callback = kept;
  auto listening = gecos::listen(level(), [&, kept = std::move(kept)](const Sample&) {
    gate.pass();
    ended = true;
  });
  servant_.publish(1);
  ASSERT_TRUE(gate.await());
  auto closing = std::async(std::launch::async, [&] { listening.close(); });
  gate.open();
  closing.get();
  EXPECT_TRUE(ended);
  EXPECT_TRUE(callback.expired()) << "with all that it kept";
}

TEST_P(Listeners, AreClosedByTheirDestructorAndByAnAssignment) {
  std::shared_ptr<int> kept = std::make_shared<int>();
  const std::weak_ptr<int> first = kept;
  auto listening = gecos::listen(level(), [kept = std::move(kept)](const Sample&) {});
  listening = gecos::listen(level(), hear());
  EXPECT_TRUE(first.expired());
  servant_.publish(1);
  EXPECT_TRUE(heard_.await(1));
}

TEST_P(Listeners, MayBeDestroyedInAForkedChildAndGoOnInTheParent) {
  std::optional<Listener<std::int32_t>> listening = gecos::listen(level(), hear());
  gecos::media::ChildProcess child([&](const std::function<void()>&) { listening.reset(); });
  EXPECT_EQ(child.wait(), 0);
  servant_.publish(1);
  EXPECT_TRUE(heard_.await(1));
}

TEST_P(Listeners, MayBeClosedByTheirCallback) {
  std::optional<Listener<std::int32_t>> listening;
  std::promise<void> closed;
  bool told = false;
  listening.emplace(
      level(),
      [&](const Sample& sample) {
        heard_.add(sample);
        if (sample.value != 2) return;
        servant_.publish(3);
        listening->close();
        closed.set_value();
      },
      [&](StreamEnd, const std::string&) { told = true; });
  for (std::int32_t value = 1; value <= 2; ++value) {
    servant_.publish(value);
    ASSERT_TRUE(heard_.await(value));
  }
  ASSERT_EQ(closed.get_future().wait_for(30s), std::future_status::ready);
  listening->close();
  EXPECT_EQ(heard_.all().size(), 2u);
  EXPECT_FALSE(told) << "the program itself has ended it";
}

TEST_P(Listeners, MayBeDestroyedByTheirCallback) {
  std::unique_ptr<Listener<std::int32_t>> listening;
  std::promise<void> assigned;  // gives the order that ThreadSanitizer cannot see in shared memory
  std::shared_ptr<int> kept = std::make_shared<int>();
  const std::weak_ptr<int> callback = kept;
  listening = std::make_unique<Listener<std::int32_t>>(
      level(), [&, kept = std::move(kept)](const Sample& sample) {
        assigned.get_future().wait();
        listening.reset();
        heard_.add(sample);
      });
  assigned.set_value();
  servant_.publish(1);
  EXPECT_TRUE(heard_.await(1));
  servant_.publish(2);
  EXPECT_TRUE(settles([&] { return callback.expired(); })) << "the thread has ended";
  EXPECT_EQ(heard_.all().size(), 1u);
}

TEST_P(Listeners, GoOnWhenTheCallbackThrows) {
  ::testing::internal::CaptureStderr();
  auto listening = gecos::listen(level(), [&](const Sample& sample) {
    heard_.add(sample);
    if (sample.value == 1) throw std::runtime_error("of the test");
    if (sample.value == 2) throw 7;
  });
  for (std::int32_t value = 1; value <= 3; ++value) {
    servant_.publish(value);
    EXPECT_TRUE(heard_.await(value));
  }
  listening.close();
  const std::string log = ::testing::internal::GetCapturedStderr();
  const std::string who = "the callback of the stream 'level' of PROBE threw";
  EXPECT_NE(log.find(who + ": of the test; "), std::string::npos) << log;
  EXPECT_NE(log.find(who + " something that is no std::exception; "), std::string::npos) << log;
}

TEST_P(Listeners, LetTheLabBeClosedWhileTheirCallbackRuns) {
  Gate gate;
  std::promise<std::pair<StreamEnd, std::string>> told;
  auto listening = gecos::listen(
      level(),
      [&](const Sample& sample) {
        heard_.add(sample);
        gate.pass();
      },
      [&](StreamEnd end, const std::string& loss_text) {
        told.set_value({end, loss_text});
      });
  servant_.publish(1);
  ASSERT_TRUE(gate.await());
  lab_.close();
  gate.open();
  const auto [end, loss_text] = told.get_future().get();
  EXPECT_EQ(end, StreamEnd::Lost);
  EXPECT_EQ(loss_text, "") << "the program closed the Lab itself";
  EXPECT_EQ(heard_.all().size(), 1u);
}

TEST_P(Listeners, MayCallTheObjectAndCloseTheLabInTheirCallback) {
  std::promise<std::int32_t> read;
  std::promise<StreamEnd> told;
  auto listening = gecos::listen(
      level(),
      [&](const Sample&) {
        read.set_value(probe_.read().get().value_or(-1));
        lab_.close();
      },
      [&](StreamEnd end, const std::string&) { told.set_value(end); });
  servant_.publish(1);
  EXPECT_EQ(read.get_future().get(), 7);
  EXPECT_EQ(told.get_future().get(), StreamEnd::Lost);
}

TEST_P(Listeners, GoOnAfterAMissedDeadline) {
  gecos::StreamDescription strict = probe::description().streams[0];
  strict.quality.deadline = 5ms;
  auto core = probe_.session()->subscribe(strict);
  ASSERT_TRUE(core) << core.error();
  const std::shared_ptr<gecos::session::StreamCore> known = *core;
  bool told = false;
  auto listening = gecos::listen(
      gecos::Stream<std::int32_t>(
          *std::move(core),
          [](gecos::wire::Decoder& from, std::int32_t& value) { return from.get(value, "value"); }),
      hear(), [&](StreamEnd, const std::string&) { told = true; });
  ASSERT_TRUE(settles([&] { return known->counts().missed_deadlines > 0; }));
  servant_.publish(1);
  EXPECT_TRUE(heard_.await(1));
  listening.close();
  EXPECT_FALSE(told);
}

}  // namespace
