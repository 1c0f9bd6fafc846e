// Many connections of one process over lcm share its ports.
#include <gtest/gtest.h>

#include <list>

#include "gecos/media/sealed/stream.hpp"
#include "lcm_recorder.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

class LcmSharing : public testing::Test {
 protected:
  struct Pair {
    End client;
    End server;
  };

  Pair& connect() {
    auto client = medium_->connect(acceptor_->address()).value();
    auto server = wait_for_client(*acceptor_, *client);
    return pairs_.emplace_back(
        Pair{End(std::move(client)), End(std::move(server), acceptor_.get())});
  }

  const ScratchDirectory directory_;
  const std::unique_ptr<Medium> medium_ = make_lcm(with_keys(directory_));
  const std::unique_ptr<Acceptor> acceptor_ = medium_->listen("SHARED", false).value();
  std::list<Pair> pairs_;
};

TEST_F(LcmSharing, FurtherClientsOfAProcessOpenNoPort) {
  for (int i = 0; i < 16; ++i) connect();
  const std::size_t before = open_descriptors();
  constexpr std::size_t further = 32;
  for (std::size_t i = 0; i < further; ++i) connect();
  // What both ends sleep on: an eventfd each, and an epoll for the streams of the client.
  EXPECT_EQ(open_descriptors(), before + 3 * further);

  int number = 0;
  for (Pair& pair : pairs_) ASSERT_TRUE(pair.client.send(std::to_string(number++)));
  number = 0;
  for (Pair& pair : pairs_) {
    EXPECT_EQ(pair.server.receive(), std::to_string(number));
    ASSERT_TRUE(pair.server.send("answer " + std::to_string(number)));
    EXPECT_EQ(pair.client.receive(), "answer " + std::to_string(number));
    ++number;
  }
}

TEST_F(LcmSharing, AConnectionThatEndsTakesNoPortFromTheOthers) {
  for (int i = 0; i < 16; ++i) connect();
  for (int i = 0; i < 8; ++i) pairs_.pop_front();
  for (Pair& pair : pairs_) {
    ASSERT_TRUE(pair.client.send("still here"));
    EXPECT_EQ(pair.server.receive(), "still here");
    ASSERT_TRUE(pair.server.send("so am I"));
    EXPECT_EQ(pair.client.receive(), "so am I");
  }
}

TEST_F(LcmSharing, TwoReadersOfOneStreamGetAllSamplesAndTheOneThatIsClosedWakesNobody) {
  const auto writer = acceptor_->make_stream(100, 4);
  Pair& one = connect();
  Pair& other = connect();
  ASSERT_TRUE(one.server.connection->share(7, *writer));
  ASSERT_TRUE(other.server.connection->share(7, *writer));
  auto closing = one.client.wait_for_stream(7);
  const auto staying = other.client.wait_for_stream(7);
  ASSERT_TRUE(closing != nullptr && staying != nullptr);
  ASSERT_TRUE(writer->publish(bytes_of("first"), 1));
  StreamSample sample;
  EXPECT_TRUE(one.client.wait([&] { return closing->latest(0, sample); }));
  EXPECT_TRUE(other.client.wait([&] { return staying->latest(0, sample); }));

  closing.reset();
  while (!one.client.connection->prepare_to_sleep()) one.client.connection->woke();
  ASSERT_TRUE(writer->publish(bytes_of("second"), 2));
  ASSERT_NE(sleep_on(other.client.connection->descriptors(), too_late()), Wake::TimedOut);
  EXPECT_EQ(sleep_on(one.client.connection->descriptors(), std::chrono::steady_clock::now()),
            Wake::TimedOut)
      << "a sample of a stream that it no longer reads";
  one.client.connection->woke();
  EXPECT_TRUE(other.client.wait([&] { return staying->latest(1, sample); }));
  EXPECT_EQ(sample.sequence, 2U);
}

TEST_F(LcmSharing, ASampleIsOneDatagramForAllItsReaders) {
  const auto writer = acceptor_->make_stream(100, 4);
  const SharedStream where = dynamic_cast<SealedStreamWriter&>(*writer).stream()->where();
  Recorder recorder(where.port, channel_name("GS", where.channel));
  std::vector<std::unique_ptr<StreamReader>> readers;
  for (int i = 0; i < 3; ++i) {
    Pair& pair = connect();
    ASSERT_TRUE(pair.server.connection->share(7, *writer));
    readers.push_back(pair.client.wait_for_stream(7));
    ASSERT_NE(readers.back(), nullptr);
    // With it the server reads that the stream is open. A later reader would get a repetition.
    ASSERT_TRUE(pair.client.send("opened"));
    ASSERT_EQ(pair.server.receive(), "opened");
    ASSERT_EQ(pair.server.connection->loss(), Loss::None);
  }
  ASSERT_TRUE(writer->publish(bytes_of("first"), 1));
  ASSERT_TRUE(writer->publish(bytes_of("last"), 2));
  auto reader = readers.begin();
  for (Pair& pair : pairs_) {
    StreamSample sample;
    for (const std::string_view text : {"first", "last"}) {
      ASSERT_TRUE(pair.client.wait([&] { return (*reader)->next(sample.sequence, sample); }));
      EXPECT_EQ(text_of(sample.bytes), text);
    }
    ++reader;
  }
  const TimePoint end = too_late();
  while (recorder.all().size() < 2 && std::chrono::steady_clock::now() < end) recorder.look();
  recorder.look();
  ASSERT_EQ(recorder.all().size(), 2U);
  EXPECT_NE(recorder.all().front(), recorder.all().back());
}

}  // namespace
}  // namespace gecos::media
