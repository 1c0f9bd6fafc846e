// How often a program asks a broker that does not admit it.
#include <atomic>
#include <future>
#include <mutex>
#include <stop_token>
#include <thread>

#include "bench.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/kinds.hpp"
#include "gecos/media/waiting.hpp"
#include "gecos/session/client/broker_news.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/ask_pause.hpp"
#include "gecos/wire/packet.hpp"

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

TEST(AskPause, GrowsToTwoSecondsWhileTheBrokerRefusesAServer) {
  AskPause pause;
  EXPECT_EQ(pause.after(BrokerAnswer::Other), 200ms);
  EXPECT_EQ(pause.after(BrokerAnswer::Other), 200ms);
  EXPECT_EQ(pause.after(BrokerAnswer::Refused), 400ms);
  EXPECT_EQ(pause.after(BrokerAnswer::Refused), 800ms);
  for (int i = 0; i < 1000; ++i) pause.after(BrokerAnswer::Refused);
  EXPECT_EQ(pause.after(BrokerAnswer::Refused), 2s);
  EXPECT_EQ(pause.after(BrokerAnswer::Other), 200ms)
      << "a broker that is restarted is found at once";
}

/// Refuses each session, and keeps the time at which it was asked for.
class RefusingBroker {
 public:
  RefusingBroker()
      : medium_(media::open(media::Kind::Inproc).value()),
        acceptor_(medium_->listen("BROKER", true).value()),
        thread_([this](const std::stop_token& ended) {
          while (!ended.stop_requested()) answer();
        }) {}

  /// Waits for `questions` questions. Returns the time between the first and the last of them.
  Duration time_of(std::size_t questions) {
    const auto heard = [&] {
      const std::lock_guard lock(mutex_);
      return asked_.size() >= questions;
    };
    EXPECT_TRUE(settles(heard));
    const std::lock_guard lock(mutex_);
    return asked_.size() < questions ? Duration::zero() : asked_[questions - 1] - asked_[0];
  }

 private:
  void answer() {
    while (auto connection = acceptor_->accept()) open_.push_back(std::move(connection));
    for (const auto& connection : open_) {
      while (connection->receive()) {
        {
          const std::lock_guard lock(mutex_);
          asked_.push_back(system_clock().now());
        }
        wire::PacketHeader header;
        header.kind = wire::PacketKind::Refused;
        header.flags = static_cast<std::int8_t>(Detail::Refused);
        Bytes refusal;
        write_packet(refusal, header,
                     wire::to_bytes(FailureBody{"BROKER refuses you: no", {}, {}}));
        EXPECT_TRUE(connection->send(refusal, {}));
      }
    }
    std::erase_if(open_, [](const auto& each) { return each->loss() != media::Loss::None; });
    media::sleep_on(acceptor_->descriptors(), deadline_after(2ms));
  }

  const std::unique_ptr<media::Medium> medium_;
  const std::unique_ptr<media::Acceptor> acceptor_;
  std::vector<std::unique_ptr<media::Connection>> open_;
  std::mutex mutex_;
  std::vector<TimePoint> asked_;
  std::jthread thread_;
};

LabOptions of_inproc() {
  LabOptions options = probe::patient();
  options.broker = "inproc";
  return options;
}

/// The first two pauses are 400 and 800 ms. They are 200 ms each if no broker answers.
constexpr Duration two_growing_pauses = 1100ms;

class RefusedByTheBroker : public probe::NothingLeftOpen {
 protected:
  Lab lab_{of_inproc()};
  Server server_{lab_};
};

TEST_F(RefusedByTheBroker, AServerThatAwaitsABrokerAsksMoreAndMoreSeldom) {
  RefusingBroker broker;
  const auto awaited = std::async(std::launch::async, [&] { return server_.await_broker(2s); });
  EXPECT_GE(broker.time_of(3), two_growing_pauses);
}

TEST_F(RefusedByTheBroker, AServerThatRegistersItsFirstObjectAsksMoreAndMoreSeldom) {
  RefusingBroker broker;
  probe::ProbeServant servant;
  const auto added = std::async(std::launch::async, [&] {
    return server_.add("PROBE", servant, {.media = {media::Kind::Inproc}, .patience = 2s});
  });
  EXPECT_GE(broker.time_of(3), two_growing_pauses);
}

TEST_F(RefusedByTheBroker, AServerThatWasRegisteredAsksMoreAndMoreSeldom) {
  probe::ProbeServant servant;
  {
    broker::Broker first;
    Lab first_lab;
    Server first_server{first_lab};
    ASSERT_TRUE(first.serve(first_server, {media::Kind::Inproc}));
    ASSERT_TRUE(server_.add("PROBE", servant, {.media = {media::Kind::Inproc}}));
  }
  RefusingBroker broker;
  // Each time the server asks twice: it looks for any broker, and for the first one.
  EXPECT_GE(broker.time_of(6), two_growing_pauses);
}

TEST_F(RefusedByTheBroker, AClientThatWaitsForNewsAsksMoreAndMoreSeldom) {
  RefusingBroker broker;
  const auto waited = std::async(std::launch::async, [&] {
    BrokerNews news(*LabAccess::context(lab_));
    return news.wait(deadline_after(20s));
  });
  // The pauses are 20, 40, 80, 160, 320 and 640 ms. At most 160 ms if no broker answers.
  EXPECT_GE(broker.time_of(7), 1100ms);
  lab_.close();
}

}  // namespace
}  // namespace gecos::session
