// What every medium promises, run on every medium.

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>

#include <algorithm>
#include <stdexcept>
#include <thread>

#include "gecos/media/inproc/inproc.hpp"
#include "gecos/media/layers/checked.hpp"
#include "gecos/media/lcm/lcm.hpp"
#include "gecos/media/quiet.hpp"
#include "gecos/media/shm/shm.hpp"
#include "media_under_test.hpp"
#include "pair_medium.hpp"

namespace gecos::media {
namespace {

using namespace std::chrono_literals;

struct Candidate {
  std::string name;
  std::function<std::unique_ptr<Medium>(const std::string& directory)> make;
};

ByteView bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

void PrintTo(const Candidate& candidate, std::ostream* out) { *out << candidate.name; }

/// Keeps the test on the core that it is on.
class OnOneCore {
 public:
  OnOneCore() {
    ::sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(core_), &one);
    ::sched_setaffinity(0, sizeof one, &one);
  }
  ~OnOneCore() { ::sched_setaffinity(0, sizeof before_, &before_); }
  OnOneCore(const OnOneCore&) = delete;
  OnOneCore& operator=(const OnOneCore&) = delete;
  std::int32_t core() const { return core_; }

 private:
  const std::int32_t core_ = ::sched_getcpu();
  cpu_set_t before_{};
};

class Conformance : public testing::TestWithParam<Candidate> {
 protected:
  void SetUp() override {
    medium_ = GetParam().make(directory_.path());
    acceptor_ = listen("RX90");
    ASSERT_NE(acceptor_, nullptr);
    client_ = connect();
    ASSERT_NE(client_.connection, nullptr);
    server_ = End(wait_for_client(*acceptor_, *client_.connection), acceptor_.get());
    ASSERT_NE(server_.connection, nullptr);
  }

  std::unique_ptr<Acceptor> listen(std::string_view name, bool well_known = false) {
    auto acceptor = medium_->listen(name, well_known);
    if (!acceptor) ADD_FAILURE() << acceptor.error().text;
    return acceptor ? std::move(*acceptor) : nullptr;
  }
  End connect() {
    auto connection = medium_->connect(acceptor_->address());
    if (!connection) ADD_FAILURE() << connection.error().text;
    return End(connection ? std::move(*connection) : nullptr);
  }

  const ScratchDirectory directory_;
  std::unique_ptr<Medium> medium_;
  std::unique_ptr<Acceptor> acceptor_;
  End client_{nullptr};
  End server_{nullptr};
};

TEST_P(Conformance, CarriesPacketsBothWaysInOrder) {
  for (int i = 0; i < 100; ++i) {
    const std::string text = "packet " + std::to_string(i);
    ASSERT_TRUE(client_.send(text));
    ASSERT_TRUE(server_.send("answer to " + text));
  }
  for (int i = 0; i < 100; ++i) {
    const std::string text = "packet " + std::to_string(i);
    ASSERT_EQ(server_.receive(), text);
    ASSERT_EQ(client_.receive(), "answer to " + text);
  }
  EXPECT_FALSE(client_.connection->receive());
  EXPECT_FALSE(server_.connection->receive());
}

TEST_P(Conformance, CarriesEverySizeUpToTheLargest) {
  const std::size_t largest = medium_->capabilities().largest_packet;
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{48}, std::size_t{239}, std::size_t{240},
        std::size_t{241}, std::size_t{5000}, std::size_t{8'192}, std::size_t{8'193},
        std::size_t{2'000'000}, largest - 1, largest}) {
    if (size > largest) continue;
    std::string text(size, 'x');
    for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 31 + i / 256);
    ASSERT_TRUE(client_.send(text)) << size;
    ASSERT_EQ(server_.receive(), text) << size;
    ASSERT_TRUE(server_.send(text)) << size;
    ASSERT_EQ(client_.receive(), text) << size;
  }
}

TEST_P(Conformance, RefusesWhatNeverFits) {
  const std::string text(medium_->capabilities().largest_packet + 1, 'x');
  EXPECT_EQ(client_.send(text).error(), SendProblem::TooLarge);
  ASSERT_TRUE(client_.send("after it"));
  EXPECT_EQ(server_.receive(), "after it") << "nothing of the large one was sent";
}

TEST_P(Conformance, LargeAndSmallPacketsKeepTheirOrder) {
  if (!medium_->capabilities().ordered) GTEST_SKIP() << "small ones overtake";
  const std::size_t large =
      std::min(std::size_t{1'000'000}, medium_->capabilities().largest_packet - 30);
  std::vector<std::string> sent;
  for (int i = 0; i < 30; ++i) {
    const std::size_t size = i % 3 == 0 ? large + static_cast<std::size_t>(i) : 100;
    sent.emplace_back(size, static_cast<char>('a' + i % 26));
  }
  for (int round = 0; round < 5; ++round) {
    for (const std::string& text : sent) ASSERT_TRUE(client_.send(text));
    for (const std::string& text : sent) ASSERT_TRUE(server_.receive() == text) << text.size();
  }
}

TEST_P(Conformance, SaysFullOfLargePacketsTooAndLosesNone) {
  if (!medium_->capabilities().reliable) GTEST_SKIP() << "promises no room";
  const std::string text(5'000'000, 'x');
  for (int round = 0; round < 2; ++round) {
    // loss() looks for what the server has said as well
    ASSERT_EQ(client_.connection->loss(), Loss::None);
    int sent = 0;
    while (client_.send(text + std::to_string(sent))) ++sent;
    EXPECT_EQ(client_.send(text).error(), SendProblem::Full);
    EXPECT_GE(sent, 6);
    EXPECT_TRUE(client_.send("a small one finds room"));
    for (int i = 0; i < sent; ++i) ASSERT_TRUE(server_.receive() == text + std::to_string(i)) << i;
    EXPECT_EQ(server_.receive(), "a small one finds room");
  }
}

TEST_P(Conformance, NumbersItsPacketsFromOne) {
  for (std::uint64_t i = 1; i <= 5; ++i) EXPECT_EQ(client_.send("x").value(), i);
  EXPECT_EQ(server_.send("y").value(), 1u);
}

TEST_P(Conformance, SaysFullAndLosesNothingWhereItIsReliable) {
  if (!medium_->capabilities().reliable) GTEST_SKIP() << "promises no room";
  const std::string text(1000, 'x');
  int sent = 0;
  while (client_.send(text + std::to_string(sent))) ++sent;
  EXPECT_EQ(client_.send(text).error(), SendProblem::Full);
  EXPECT_GT(sent, 100);
  for (int i = 0; i < sent; ++i) ASSERT_EQ(server_.receive(), text + std::to_string(i));
  EXPECT_TRUE(client_.send("there is room again"));
  EXPECT_EQ(server_.receive(), "there is room again");
}

TEST_P(Conformance, TellsWhatThePeerHasTakenWhereItCan) {
  if (!client_.connection->taken_by_peer()) GTEST_SKIP() << "cannot know";
  ASSERT_TRUE(client_.send("one"));
  ASSERT_TRUE(client_.send("two"));
  EXPECT_EQ(client_.connection->taken_by_peer(), 0u);
  EXPECT_EQ(server_.receive(), "one");
  EXPECT_EQ(client_.connection->taken_by_peer(), 1u);
  EXPECT_EQ(server_.receive(), "two");
  EXPECT_EQ(client_.connection->taken_by_peer(), 2u);
}

TEST_P(Conformance, AnOrderlyCloseIsSeenAfterTheLastPacket) {
  ASSERT_TRUE(server_.send("last words"));
  server_.connection.reset();
  EXPECT_EQ(client_.receive(), "last words");
  EXPECT_EQ(client_.wait_for_loss(), Loss::Closed);
  EXPECT_FALSE(client_.connection->loss_text().empty());
  EXPECT_EQ(client_.send("too late").error(), SendProblem::Lost);
  EXPECT_FALSE(client_.connection->prepare_to_sleep()) << "nothing will come: do not sleep";
}

TEST_P(Conformance, TheServerSeesItsClientClose) {
  ASSERT_TRUE(client_.send("last words"));
  client_.connection.reset();
  EXPECT_EQ(server_.receive(), "last words");
  EXPECT_EQ(server_.wait_for_loss(), Loss::Closed);
  EXPECT_EQ(server_.send("too late").error(), SendProblem::Lost);
}

TEST_P(Conformance, ACloseWakesASleeper) {
  std::thread closing([&] { server_.connection.reset(); });
  EXPECT_EQ(client_.wait_for_loss(), Loss::Closed);
  closing.join();
}

TEST_P(Conformance, ConnectionsOutliveTheirAcceptor) {
  server_ = End(std::move(server_.connection));
  if (!medium_->capabilities().connectionless) acceptor_.reset();
  ASSERT_TRUE(server_.send("still here"));
  EXPECT_EQ(client_.receive(), "still here");
  EXPECT_EQ(client_.connection->loss(), Loss::None);
}

TEST_P(Conformance, BeatsAreSeenWithoutPackets) {
  const std::uint64_t before = server_.connection->beats_seen();
  client_.connection->beat();
  EXPECT_TRUE(server_.wait([&] {
    server_.connection->receive();
    if (server_.connection->beats_seen() > before) return true;
    client_.connection->beat();  // a beat wakes nobody: another one, as maintenance sends them
    return server_.connection->beats_seen() > before;
  }));
}

TEST_P(Conformance, WordsAreReadByThePeerWithoutAPacket) {
  if (!client_.connection->capabilities().shared_words) GTEST_SKIP() << "it has none";
  ASSERT_TRUE(client_.send("both ends know each other"));
  ASSERT_EQ(server_.receive(), "both ends know each other");
  ASSERT_TRUE(server_.send("now"));
  ASSERT_EQ(client_.receive(), "now");
  for (std::size_t word = 0; word < shared_word_count; ++word) {
    EXPECT_EQ(client_.connection->peer_word(word), 0u);
    client_.connection->write_word(word, 10 + word);
    server_.connection->write_word(word, 20 + word);
    EXPECT_EQ(server_.connection->peer_word(word), 10 + word);
    EXPECT_EQ(client_.connection->peer_word(word), 20 + word);
  }
}

TEST_P(Conformance, AnEndSaysWhereItLooksWhetherItSleepsAndWhenItRang) {
  if (!client_.connection->capabilities().shared_words) {
    EXPECT_EQ(client_.connection->peer_whereabouts().core, unknown_core);
    GTEST_SKIP() << "it shares no memory";
  }
  ASSERT_TRUE(client_.send("both ends know each other"));
  ASSERT_EQ(server_.receive(), "both ends know each other");
  ASSERT_TRUE(server_.send("now"));
  ASSERT_EQ(client_.receive(), "now");

  const OnOneCore pinned;
  EXPECT_FALSE(server_.connection->receive());
  EXPECT_EQ(client_.connection->peer_whereabouts().core, pinned.core());
  EXPECT_FALSE(client_.connection->peer_whereabouts().asleep);

  ASSERT_TRUE(server_.connection->prepare_to_sleep());
  EXPECT_TRUE(client_.connection->peer_whereabouts().asleep);
  const TimePoint before = std::chrono::steady_clock::now();
  ASSERT_TRUE(client_.send("wake up"));
  EXPECT_GE(server_.connection->peer_whereabouts().rang_at, before);
  EXPECT_LE(server_.connection->peer_whereabouts().rang_at, std::chrono::steady_clock::now());
  server_.connection->woke();
  EXPECT_FALSE(client_.connection->peer_whereabouts().asleep);

  const TimePoint rang_at = server_.connection->peer_whereabouts().rang_at;
  ASSERT_TRUE(client_.send("it is awake"));
  EXPECT_EQ(server_.connection->peer_whereabouts().rang_at, rang_at) << "nobody had to be woken";
}

TEST_P(Conformance, QuietPacketsAreReadBeforeThePacketThatWakes) {
  ASSERT_TRUE(client_.send("both ends know each other"));
  ASSERT_EQ(server_.receive(), "both ends know each other");
  ASSERT_TRUE(server_.send("now"));
  ASSERT_EQ(client_.receive(), "now");

  const bool quiet = dynamic_cast<QuietSender*>(server_.connection.get()) != nullptr;
  EXPECT_EQ(quiet, GetParam().name == "inproc" || GetParam().name == "shm");
  client_.connection->woke();
  ASSERT_TRUE(client_.connection->prepare_to_sleep());
  ASSERT_TRUE(send_quietly(*server_.connection, bytes_of("news"), bytes_of(" 1")));
  if (quiet) {
    EXPECT_EQ(sleep_on(client_.connection->descriptors(), TimePoint{}), Wake::TimedOut);
    const auto read_in_its_sleep = client_.connection->receive();
    ASSERT_TRUE(read_in_its_sleep);
    EXPECT_TRUE(std::ranges::equal(*read_in_its_sleep, bytes_of("news 1")));
  } else {
    client_.connection->woke();
    EXPECT_EQ(client_.receive(), "news 1");
    ASSERT_TRUE(client_.connection->prepare_to_sleep());
  }
  ASSERT_TRUE(send_quietly(*server_.connection, bytes_of("news"), bytes_of(" 2")));
  ASSERT_TRUE(server_.send("the end"));
  EXPECT_NE(sleep_on(client_.connection->descriptors(), too_late()), Wake::TimedOut);
  client_.connection->woke();
  EXPECT_EQ(client_.receive(), "news 2");
  EXPECT_EQ(client_.receive(), "the end");
}

TEST_P(Conformance, QuietPacketsWakeThePeerBeforeTheyTakeTheRoomOfOthers) {
  if (dynamic_cast<QuietSender*>(server_.connection.get()) == nullptr) {
    GTEST_SKIP() << "every packet wakes its peer";
  }
  ASSERT_TRUE(client_.send("both ends know each other"));
  ASSERT_EQ(server_.receive(), "both ends know each other");
  ASSERT_TRUE(server_.send("now"));
  ASSERT_EQ(client_.receive(), "now");

  const auto woken = [&] {
    return sleep_on(client_.connection->descriptors(), TimePoint{}) == Wake::Ready;
  };
  client_.connection->woke();
  ASSERT_TRUE(client_.connection->prepare_to_sleep());
  std::size_t sent = 0;
  for (; !woken(); ++sent) ASSERT_TRUE(send_quietly(*server_.connection, bytes_of("news"), {}));
  EXPECT_GT(sent, 100u);
  for (std::size_t i = 0; i < sent / 2; ++i) ASSERT_TRUE(server_.send("there is room")) << i;
  client_.connection->woke();
  while (client_.connection->receive()) {
  }

  ASSERT_TRUE(client_.connection->prepare_to_sleep());
  const std::string large(100'000, 'x');
  ASSERT_TRUE(send_quietly(*server_.connection, bytes_of(large), {}));
  EXPECT_TRUE(woken()) << "it lies beside the ring, where room is scarce";
  client_.connection->woke();
  EXPECT_EQ(client_.receive(), large);
}

TEST_P(Conformance, PrepareToSleepFindsAQuietPacket) {
  ASSERT_TRUE(client_.send("both ends know each other"));
  ASSERT_EQ(server_.receive(), "both ends know each other");
  ASSERT_TRUE(send_quietly(*server_.connection, bytes_of("news"), {}));
  ASSERT_TRUE(client_.wait([&] {
    return !client_.connection->prepare_to_sleep() || (client_.connection->woke(), false);
  }));
  EXPECT_EQ(client_.receive(), "news");
}

TEST_P(Conformance, PrepareToSleepFindsWhatIsThereAlready) {
  ASSERT_TRUE(client_.send("first"));
  ASSERT_TRUE(server_.wait([&] {
    return !server_.connection->prepare_to_sleep() || (server_.connection->woke(), false);
  }));
  EXPECT_EQ(server_.receive(), "first");
}

TEST_P(Conformance, DescriptorsAreQuietAfterWoke) {
  ASSERT_TRUE(server_.connection->prepare_to_sleep());
  ASSERT_TRUE(client_.send("wake up"));
  EXPECT_EQ(server_.receive(), "wake up");
  server_.connection->woke();
  EXPECT_EQ(sleep_on(server_.connection->descriptors(), TimePoint{}), Wake::TimedOut);
}

TEST_P(Conformance, NoWakeUpIsLost) {
  constexpr int rounds = 5'000;
  std::thread echoing([&] {
    for (int i = 0; i < rounds; ++i) {
      ASSERT_EQ(server_.receive(), "to " + std::to_string(i));
      ASSERT_TRUE(server_.send("fro " + std::to_string(i)));
    }
  });
  for (int i = 0; i < rounds; ++i) {
    ASSERT_TRUE(client_.send("to " + std::to_string(i)));
    ASSERT_EQ(client_.receive(), "fro " + std::to_string(i));
  }
  echoing.join();
}

TEST_P(Conformance, WhoAsksForALossTakesNoWakeUpFromASleeper) {
  ASSERT_TRUE(server_.connection->prepare_to_sleep());
  ASSERT_TRUE(client_.send("before it has heard of the server"));
  EXPECT_EQ(server_.connection->loss(), Loss::None)
      << "as maintenance asks, beside the thread that sleeps";
  std::vector<int> all(server_.connection->descriptors().begin(),
                       server_.connection->descriptors().end());
  all.insert(all.end(), acceptor_->descriptors().begin(), acceptor_->descriptors().end());
  EXPECT_EQ(sleep_on(all, too_late()), Wake::Ready);
  server_.connection->woke();
  EXPECT_EQ(server_.receive(), "before it has heard of the server");
}

TEST_P(Conformance, MaintenanceMayBeatBesideEverything) {
  std::atomic<bool> done{false};
  std::thread maintenance([&] {
    while (!done.load()) {
      client_.connection->beat();
      server_.connection->beat();
      EXPECT_EQ(client_.connection->loss(), Loss::None);
      EXPECT_EQ(server_.connection->loss(), Loss::None);
      client_.connection->beats_seen();
      client_.connection->taken_by_peer();
      std::this_thread::yield();
    }
  });
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(client_.send(std::to_string(i)));
    ASSERT_EQ(server_.receive(), std::to_string(i));
  }
  done.store(true);
  maintenance.join();
}

TEST_P(Conformance, AnAcceptorHasManyConnectionsThatDoNotMix) {
  constexpr std::size_t count = 12;
  std::vector<End> clients;
  std::vector<End> servers;
  for (std::size_t i = 0; i < count; ++i) {
    clients.push_back(connect());
    ASSERT_TRUE(clients.back().send("I am " + std::to_string(i)));
    auto connection = wait_for_client(*acceptor_, *clients.back().connection);
    ASSERT_NE(connection, nullptr);
    servers.emplace_back(std::move(connection), acceptor_.get());
    ASSERT_EQ(servers.back().receive(), "I am " + std::to_string(i));
  }
  for (std::size_t i = 0; i < count; ++i) {
    ASSERT_TRUE(servers[i].send("you are " + std::to_string(i)));
  }
  for (std::size_t i = 0; i < count; ++i) {
    ASSERT_EQ(clients[i].receive(), "you are " + std::to_string(i));
    ASSERT_FALSE(clients[i].connection->receive());
  }
  clients[3].connection.reset();
  EXPECT_EQ(servers[3].wait_for_loss(), Loss::Closed);
  EXPECT_EQ(servers[4].connection->loss(), Loss::None);
}

TEST_P(Conformance, AStreamIsReadNewestFirstOrOneByOne) {
  const auto writer = acceptor_->make_stream(100, 4);
  ASSERT_TRUE(server_.connection->share(7, *writer));
  const auto reader = client_.wait_for_stream(7);
  ASSERT_NE(reader, nullptr);
  StreamSample sample;
  EXPECT_FALSE(reader->latest(0, sample)) << "nothing was published";
  EXPECT_EQ(client_.connection->open_stream(8), nullptr) << "nothing was shared under this number";

  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(writer->publish(bytes_of(std::to_string(i)), 1000 + i));
  for (std::uint64_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(client_.wait([&] { return reader->next(i - 1, sample); }));
    EXPECT_EQ(sample.sequence, i);
    EXPECT_EQ(sample.stamp_ns, static_cast<std::int64_t>(1000 + i));
    EXPECT_EQ(text_of(sample.bytes), std::to_string(i));
  }
  EXPECT_FALSE(reader->next(3, sample));
  EXPECT_TRUE(reader->latest(2, sample));
  EXPECT_EQ(sample.sequence, 3u);
  EXPECT_FALSE(reader->latest(3, sample));
}

TEST_P(Conformance, AWriterKnowsTheSequenceNumberOfItsNewestSample) {
  for (const auto& writer :
       {acceptor_->make_stream(10, 4), client_.connection->make_stream(10, 4)}) {
    EXPECT_EQ(writer->newest(), 0U);
    ASSERT_TRUE(writer->publish(bytes_of("first"), 1));
    EXPECT_FALSE(writer->publish(bytes_of("eleven bytes"), 2));
    ASSERT_TRUE(writer->lend(5));
    writer->publish_lent(3);
    EXPECT_EQ(writer->newest(), 2U);
  }
}

TEST_P(Conformance, AStreamGoesOnAfterTheNumberThatItIsGiven) {
  const auto writer = acceptor_->make_stream(100, 4);
  writer->number_after(41);
  EXPECT_EQ(writer->newest(), 41U);
  ASSERT_TRUE(server_.connection->share(7, *writer));
  const auto reader = client_.wait_for_stream(7);
  ASSERT_NE(reader, nullptr);
  StreamSample sample;
  EXPECT_FALSE(reader->latest(0, sample));
  ASSERT_TRUE(writer->publish(bytes_of("42"), 1));
  ASSERT_TRUE(client_.wait([&] { return reader->next(41, sample); }));
  EXPECT_EQ(sample.sequence, 42U);
  EXPECT_FALSE(reader->next(42, sample));
  ASSERT_TRUE(writer->publish(bytes_of("43"), 2));
  ASSERT_TRUE(client_.wait([&] { return reader->next(42, sample); }));
  EXPECT_EQ(sample.sequence, 43U);
}

TEST_P(Conformance, AReaderOfALateStreamMayBeginWithAnOlderSample) {
  const auto writer = acceptor_->make_stream(100, 4);
  ASSERT_TRUE(server_.connection->share(7, *writer));
  const auto early = client_.wait_for_stream(7);
  ASSERT_NE(early, nullptr);
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(writer->publish(bytes_of(std::to_string(i)), i));
  StreamSample sample;
  ASSERT_TRUE(client_.wait([&] { return early->latest(2, sample); }));
  const auto late = client_.connection->open_stream(7);
  ASSERT_NE(late, nullptr);
  ASSERT_TRUE(wait_ticking(server_, client_, [&] {
    server_.connection->receive();
    client_.connection->receive();
    return late->next(1, sample);
  }));
  const bool kept = !medium_->capabilities().connectionless;  // else only the newest is sent again
  EXPECT_EQ(sample.sequence, kept ? 2U : 3U);
}

TEST_P(Conformance, AStreamForWhichThisProcessHasNoDescriptorSaysSoAndCanBeSharedAgain) {
  if (medium_->capabilities().reach == Reach::Process && !medium_->capabilities().connectionless) {
    GTEST_SKIP() << "its samples lie in memory that both ends have: it needs none";
  }
  const auto writer = acceptor_->make_stream(100, 4);
  ASSERT_EQ(client_.connection->loss(), Loss::None) << "it has heard the server's answer";
  ASSERT_TRUE(server_.connection->share(7, *writer));
  EXPECT_EQ(client_.connection->why_no_stream(7), "");
  {
    const NoDescriptorLeft none;
    EXPECT_TRUE(client_.wait([&] {
      EXPECT_EQ(client_.connection->open_stream(7), nullptr);
      return !client_.connection->why_no_stream(7).empty() ||
             client_.connection->loss() != Loss::None;
    }));
  }
  EXPECT_NE(client_.connection->why_no_stream(7).find("Too many open files"), std::string::npos)
      << client_.connection->why_no_stream(7);
  ASSERT_TRUE(server_.connection->share(7, *writer));
  EXPECT_NE(client_.wait_for_stream(7), nullptr);
  EXPECT_EQ(client_.connection->why_no_stream(7), "");
}

TEST_P(Conformance, AStreamKeepsAsManySamplesAsWasAskedForOrIsRefused) {
  constexpr std::size_t depth = 4096;
  for (Connection* from : {server_.connection.get(), client_.connection.get()}) {
    try {
      const auto writer = from->make_stream(10, depth);
      ASSERT_FALSE(medium_->capabilities().connectionless) << "it keeps 1024 at most";
      End& to = from == client_.connection.get() ? server_ : client_;
      ASSERT_TRUE(from->share(5, *writer));
      const auto reader = to.wait_for_stream(5);
      ASSERT_NE(reader, nullptr);
      for (int i = 0; i < 3000; ++i) ASSERT_TRUE(writer->publish(bytes_of("sample"), i));
      StreamSample sample;
      ASSERT_TRUE(reader->next(0, sample));
      EXPECT_EQ(sample.sequence, 1u);
    } catch (const std::runtime_error& refused) {
      EXPECT_STREQ(refused.what(),
                   "this medium keeps at most 1024 samples of a stream, and the interface asks for "
                   "depth=4096; use the stream on the host of its server, or reduce the depth");
    }
  }
}

TEST_P(Conformance, ASlowReaderLosesOldSamplesAndSeesHowMany) {
  const auto writer = acceptor_->make_stream(100, 4);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  for (int i = 1; i <= 50; ++i) ASSERT_TRUE(writer->publish(bytes_of(std::to_string(i)), i));
  StreamSample sample;
  ASSERT_TRUE(client_.wait([&] { return reader->latest(49, sample); }));
  EXPECT_EQ(text_of(sample.bytes), "50");
  ASSERT_TRUE(reader->next(0, sample));
  EXPECT_EQ(sample.sequence, 47u) << "the four newest are kept";
  EXPECT_EQ(text_of(sample.bytes), "47");
}

TEST_P(Conformance, AStreamSharedLaterShowsItsLastSample) {
  const auto writer = acceptor_->make_stream(100, 4);
  ASSERT_TRUE(writer->publish(bytes_of("a pose at rest"), 5));
  ASSERT_TRUE(server_.connection->share(1, *writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  StreamSample sample;
  std::thread serving([&] {
    server_.wait([&] {
      server_.connection->receive();
      return server_.connection->loss() != Loss::None;
    });
  });
  EXPECT_TRUE(client_.wait([&] {
    client_.connection->receive();
    return reader->latest(0, sample);
  }));
  EXPECT_EQ(text_of(sample.bytes), "a pose at rest");
  EXPECT_EQ(sample.sequence, 1u);
  client_.connection.reset();
  serving.join();
}

TEST_P(Conformance, RefusesASampleThatIsTooLarge) {
  const auto writer = acceptor_->make_stream(10, 4);
  EXPECT_EQ(writer->publish(bytes_of("eleven bytes"), 1).error(), SendProblem::TooLarge);
  EXPECT_TRUE(writer->publish(bytes_of("ten bytes."), 1));
}

TEST_P(Conformance, APublisherWakesItsSleepingReaders) {
  const auto writer = acceptor_->make_stream(16, 8);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  End second = connect();
  auto second_server = wait_for_client(*acceptor_, *second.connection);
  ASSERT_NE(second_server, nullptr);
  ASSERT_TRUE(second_server->share(9, *writer));
  const auto reader = client_.wait_for_stream(1);
  const auto second_reader = second.wait_for_stream(9);
  ASSERT_NE(reader, nullptr);
  ASSERT_NE(second_reader, nullptr);

  constexpr std::uint64_t rounds = 500;
  StreamSample sample;
  StreamSample second_sample;
  for (std::uint64_t i = 1; i <= rounds; ++i) {
    std::thread reading;
    if (i % 50 == 0) {  // now and then the reader sleeps already
      reading = std::thread([&] {
        ASSERT_TRUE(second.wait([&] { return second_reader->latest(i - 1, second_sample); }));
      });
    }
    ASSERT_TRUE(writer->publish(bytes_of(std::to_string(i)), 0));
    ASSERT_TRUE(client_.wait([&] { return reader->next(i - 1, sample); }));
    ASSERT_EQ(text_of(sample.bytes), std::to_string(i));
    if (reading.joinable()) reading.join();
  }
  EXPECT_EQ(second_sample.sequence, rounds);
}

TEST_P(Conformance, AfterUnshareNobodyOpensTheStream) {
  const auto writer = acceptor_->make_stream(16, 8);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  ASSERT_NE(client_.wait_for_stream(1), nullptr);
  server_.connection->unshare(1);
  ASSERT_TRUE(server_.send("done"));
  ASSERT_EQ(client_.receive(), "done");
  EXPECT_TRUE(client_.wait([&] {
    client_.connection->receive();
    return client_.connection->open_stream(1) == nullptr;
  }));
  EXPECT_TRUE(writer->publish(bytes_of("for nobody"), 0));
}

TEST_P(Conformance, AStreamThatMovesOnIsReadOnByThoseWithWhomItIsSharedAndByNoOther) {
  const auto writer = acceptor_->make_stream(16, 8);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  End second = connect();
  auto second_server = wait_for_client(*acceptor_, *second.connection);
  ASSERT_NE(second_server, nullptr);
  ASSERT_TRUE(second_server->share(9, *writer));
  const auto reader = client_.wait_for_stream(1);
  const auto excluded = second.wait_for_stream(9);
  ASSERT_NE(reader, nullptr);
  ASSERT_NE(excluded, nullptr);
  ASSERT_TRUE(writer->publish(bytes_of("for both"), 1));
  StreamSample sample;
  ASSERT_TRUE(client_.wait([&] { return reader->next(0, sample); }));
  ASSERT_TRUE(second.wait([&] { return excluded->next(0, sample); }));

  second_server->unshare(9);
  for (std::uint64_t moves = 1; moves <= 3; ++moves) {
    writer->move_on();
    ASSERT_TRUE(writer->publish(bytes_of("for one"), 2));
    server_.connection->beat();
    const TimePoint end = too_late();
    while (!reader->latest(moves, sample) && std::chrono::steady_clock::now() < end) {
      client_.connection->loss();  // each end reads what the other says about the stream
      server_.connection->loss();
    }
    EXPECT_EQ(sample.sequence, moves + 1) << "the numbers go on";
    EXPECT_EQ(text_of(sample.bytes), "for one");
  }
  EXPECT_EQ(writer->newest(), 4u);
  if (second.connection->capabilities().reach == Reach::Process) return;
  second_server->beat();
  second.connection->loss();  // reads all that has come
  EXPECT_TRUE(excluded->latest(0, sample));
  EXPECT_EQ(text_of(sample.bytes), "for both");
  EXPECT_FALSE(excluded->latest(1, sample)) << "it reads what it had, and nothing newer";
}

TEST_P(Conformance, AConnectionMayGoWhileAStreamIsPublished) {
  const auto writer = acceptor_->make_stream(16, 8);
  std::atomic<bool> done{false};
  std::thread publishing([&] {
    while (!done.load()) {
      ASSERT_TRUE(writer->publish(bytes_of("x"), 0));
      std::this_thread::yield();
    }
  });
  for (int i = 0; i < 20; ++i) {
    End client = connect();
    auto server = wait_for_client(*acceptor_, *client.connection);
    ASSERT_NE(server, nullptr);
    ASSERT_TRUE(server->share(1, *writer));
    ASSERT_NE(client.wait_for_stream(1), nullptr);
  }
  done.store(true);
  publishing.join();
}

TEST_P(Conformance, TheNewestSamplesOfTheDepthAreStoredAndReadingTakesNone) {
  const auto writer = acceptor_->make_stream(16, 3);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  EXPECT_TRUE(reader->stored().empty());
  StreamSample sample;
  for (std::uint64_t i = 1; i <= 10; ++i) {
    ASSERT_TRUE(writer->publish(bytes_of(std::to_string(i)), static_cast<std::int64_t>(1000 + i)));
    ASSERT_TRUE(client_.wait([&] { return reader->latest(i - 1, sample); }));
    const auto stored = reader->stored();
    ASSERT_EQ(stored.size(), std::min<std::uint64_t>(i, 3));
    for (std::size_t k = 0; k < stored.size(); ++k) {
      const std::uint64_t sequence = i - stored.size() + k + 1;
      EXPECT_EQ(stored[k].sequence, sequence);
      EXPECT_EQ(stored[k].stamp_ns, static_cast<std::int64_t>(1000 + sequence));
      EXPECT_EQ(text_of(stored[k].bytes), std::to_string(sequence));
    }
  }
}

TEST_P(Conformance, SamplesOfAClientGoInward) {
  const auto writer = client_.connection->make_stream(100, 4);
  ASSERT_TRUE(client_.connection->share(7, *writer));
  std::unique_ptr<StreamReader> reader;
  ASSERT_TRUE(wait_ticking(server_, client_, [&] {
    server_.connection->receive();
    reader = server_.connection->open_stream(7);
    return reader != nullptr;
  }));
  EXPECT_EQ(server_.connection->open_stream(8), nullptr) << "nothing was shared under this number";
  StreamSample sample;
  EXPECT_FALSE(reader->latest(0, sample)) << "nothing was published";

  for (std::uint64_t i = 1; i <= 100; ++i) {
    ASSERT_TRUE(writer->publish(bytes_of(std::to_string(i)), static_cast<std::int64_t>(1000 + i)));
    ASSERT_TRUE(server_.wait([&] {
      server_.connection->receive();
      return reader->next(i - 1, sample);
    }));
    EXPECT_EQ(sample.sequence, i);
    EXPECT_EQ(sample.stamp_ns, static_cast<std::int64_t>(1000 + i));
    EXPECT_EQ(text_of(sample.bytes), std::to_string(i));
  }
  ASSERT_TRUE(client_.send("a packet beside the samples"));
  EXPECT_EQ(server_.receive(), "a packet beside the samples");
}

TEST_P(Conformance, BothEndsShareStreamsUnderTheSameNumber) {
  const auto outward = acceptor_->make_stream(16, 4);
  const auto inward = client_.connection->make_stream(16, 4);
  ASSERT_TRUE(server_.connection->share(1, *outward));
  ASSERT_TRUE(client_.connection->share(1, *inward));
  const auto at_client = client_.wait_for_stream(1);
  std::unique_ptr<StreamReader> at_server;
  ASSERT_TRUE(wait_ticking(server_, client_, [&] {
    server_.connection->receive();
    at_server = server_.connection->open_stream(1);
    return at_server != nullptr;
  }));
  ASSERT_NE(at_client, nullptr);
  ASSERT_TRUE(outward->publish(bytes_of("measured"), 1));
  ASSERT_TRUE(inward->publish(bytes_of("commanded"), 2));
  StreamSample sample;
  ASSERT_TRUE(client_.wait([&] { return at_client->latest(0, sample); }));
  EXPECT_EQ(text_of(sample.bytes), "measured");
  ASSERT_TRUE(server_.wait([&] {
    server_.connection->receive();
    return at_server->latest(0, sample);
  }));
  EXPECT_EQ(text_of(sample.bytes), "commanded");

  client_.connection->unshare(1);
  EXPECT_TRUE(wait_ticking(server_, client_, [&] {
    server_.connection->receive();
    return server_.connection->open_stream(1) == nullptr;
  }));
  EXPECT_TRUE(client_.connection->open_stream(1) != nullptr) << "the server's stream goes on";
}

TEST_P(Conformance, ASampleIsWrittenIntoLentMemoryAndReadInPlace) {
  const auto writer = acceptor_->make_stream(64, 4);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  EXPECT_FALSE(reader->lend_latest(0));
  EXPECT_EQ(writer->lend(65).error(), SendProblem::TooLarge);

  const auto abandoned = writer->lend(64);
  ASSERT_TRUE(abandoned);
  std::ranges::fill(*abandoned, std::byte{0xee});
  for (const std::string_view text : {"the first", "another"}) {
    const auto lent = writer->lend(text.size());
    ASSERT_TRUE(lent);
    ASSERT_EQ(lent->size(), text.size());
    std::ranges::copy(bytes_of(text), lent->begin());
    writer->publish_lent(5);
  }
  std::optional<LentSample> sample;
  ASSERT_TRUE(client_.wait([&] {
    client_.connection->receive();
    sample = reader->lend_latest(1);
    return sample.has_value();
  }));
  EXPECT_EQ(sample->sequence, 2u) << "an abandoned loan is no sample";
  EXPECT_EQ(sample->stamp_ns, 5);
  EXPECT_TRUE(std::ranges::equal(sample->bytes, bytes_of("another")));
  EXPECT_TRUE(sample->intact());
  EXPECT_FALSE(reader->lend_latest(2));

  ASSERT_TRUE(writer->publish(bytes_of("a copy"), 6));
  ASSERT_TRUE(client_.wait([&] {
    client_.connection->receive();
    sample = reader->lend_latest(2);
    return sample.has_value();
  }));
  EXPECT_TRUE(std::ranges::equal(sample->bytes, bytes_of("a copy")));
}

TEST_P(Conformance, SamplesAreReadInPlaceInOrderAndOutliveTheirReader) {
  auto writer = acceptor_->make_stream(64, 3);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  EXPECT_FALSE(reader->lend_next(0));
  std::vector<LentSample> held;
  const auto lend = [&](std::uint64_t after) {
    EXPECT_TRUE(client_.wait([&] {
      client_.connection->receive();
      auto sample = reader->lend_next(after);
      if (sample) held.push_back(*std::move(sample));
      return sample.has_value();
    }));
  };
  for (const std::string_view text : {"one", "two", "three"}) {
    ASSERT_TRUE(writer->publish(bytes_of(text), 7));
    lend(held.size());
  }
  ASSERT_EQ(held.size(), 3u);
  EXPECT_TRUE(std::ranges::equal(held[0].bytes, bytes_of("one"))) << "several are held";
  EXPECT_TRUE(std::ranges::equal(held[1].bytes, bytes_of("two")));
  EXPECT_EQ(held[2].sequence, 3u);
  EXPECT_EQ(held[2].stamp_ns, 7);
  EXPECT_FALSE(reader->lend_next(3));
  reader.reset();
  client_.connection.reset();
  server_.connection.reset();
  writer.reset();
  for (const LentSample& sample : held) EXPECT_TRUE(sample.intact());
  EXPECT_TRUE(std::ranges::equal(held[2].bytes, bytes_of("three")));
}

TEST_P(Conformance, AStreamThatMovesOnTakesItsLoanAndItsSamplesAlong) {
  const auto writer = acceptor_->make_stream(64, 3);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  ASSERT_TRUE(writer->publish(bytes_of("before"), 1));
  StreamSample sample;
  ASSERT_TRUE(client_.wait([&] {
    client_.connection->receive();
    return reader->latest(0, sample);
  }));
  const auto lent = writer->lend(6);
  ASSERT_TRUE(lent);
  const auto owner = writer->lent_owner();
  writer->move_on();
  std::ranges::copy(bytes_of("during"), lent->begin());
  writer->publish_lent(2);
  ASSERT_TRUE(writer->publish(bytes_of("after"), 3));
  std::vector<std::string> seen;
  ASSERT_TRUE(wait_ticking(server_, client_, [&] {
    client_.connection->loss();  // reads what the other end says about the stream
    if (!reader->next(sample.sequence, sample)) return false;
    seen.push_back(text_of(sample.bytes));
    return sample.sequence == 3;
  }));
  EXPECT_EQ(seen.back(), "after");
  if (medium_->capabilities().reliable) {
    EXPECT_EQ(seen, (std::vector<std::string>{"during", "after"}));
    EXPECT_EQ(reader->stored().size(), 3u) << "with the one before";
  }
}

TEST_P(Conformance, AWriterNeverWaitsForAReaderThatHoldsASample) {
  const auto writer = acceptor_->make_stream(16, 2);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  ASSERT_TRUE(writer->publish(bytes_of("0"), 0));
  std::optional<LentSample> held;
  ASSERT_TRUE(client_.wait([&] {
    client_.connection->receive();
    held = reader->lend_latest(0);
    return held.has_value();
  }));
  for (int i = 1; i <= 10; ++i) ASSERT_TRUE(writer->publish(bytes_of(std::to_string(i)), i));
  if (medium_->capabilities().shared_words) {
    EXPECT_FALSE(held->intact()) << "its slot is another's by now";
  }
  EXPECT_TRUE(!held->intact() || std::ranges::equal(held->bytes, bytes_of("0")));
  StreamSample sample;
  ASSERT_TRUE(client_.wait([&] {
    client_.connection->receive();
    return reader->latest(10, sample);
  }));
  EXPECT_EQ(text_of(sample.bytes), "10");
}

TEST_P(Conformance, NobodyIsAtAnUnknownAddress) {
  if (medium_->capabilities().connectionless) GTEST_SKIP() << "silence is all that a datagram gets";
  EXPECT_FALSE(medium_->connect(medium_->well_known_address("NOBODY")));
  EXPECT_FALSE(medium_->connect("nonsense"));
  const std::string address = acceptor_->address();
  acceptor_.reset();
  EXPECT_FALSE(medium_->connect(address));
}

TEST_P(Conformance, AClientOfAnAcceptorThatClosesIsTold) {
  if (medium_->capabilities().connectionless) GTEST_SKIP() << "silence is all that a datagram gets";
  End late = connect();
  ASSERT_TRUE(late.send("is anybody there?"));
  acceptor_.reset();
  EXPECT_EQ(late.wait_for_loss(), Loss::Closed);
}

TEST_P(Conformance, TheWellKnownPlaceIsTakenOnce) {
  auto broker = listen("BROKER", true);
  ASSERT_NE(broker, nullptr);
  EXPECT_EQ(broker->address(), medium_->well_known_address("BROKER"));
  const auto second = medium_->listen("BROKER", true);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().text.find("served already"), std::string::npos) << second.error().text;
  broker.reset();
  broker = listen("BROKER", true);
  ASSERT_NE(broker, nullptr);
  auto client = medium_->connect(medium_->well_known_address("BROKER"));
  ASSERT_TRUE(client);
  End end(std::move(*client));
  ASSERT_TRUE(end.send("hello"));
  EXPECT_NE(wait_for_client(*broker, *end.connection), nullptr);
}

TEST_P(Conformance, NothingIsLeftOpen) {
  const auto once = [&] {
    auto acceptor = listen("LASER");
    auto connection = medium_->connect(acceptor->address());
    ASSERT_TRUE(connection);
    End client(std::move(*connection));
    End server(wait_for_client(*acceptor, *client.connection), acceptor.get());
    const auto writer = acceptor->make_stream(100, 4);
    ASSERT_TRUE(server.connection->share(1, *writer));
    std::unique_ptr<StreamReader> reader;
    ASSERT_TRUE(wait_ticking(client, server, [&] {
      reader = client.connection->open_stream(1);
      return reader != nullptr;
    }));
    const std::string text(medium_->capabilities().reliable ? 1'000'000 : 1, 'x');
    ASSERT_TRUE(wait_ticking(server, client, [&] {
      EXPECT_TRUE(client.send(text));
      return server.connection->receive().has_value();
    }));
  };
  once();  // what is made once for the whole process
  const std::size_t before = open_descriptors();
  for (int i = 0; i < 5; ++i) once();
  EXPECT_EQ(open_descriptors(), before);
}

TEST_P(Conformance, AForkedChildFindsItsConnectionsDead) {
  const std::string large(std::min(std::size_t{1'000'000}, medium_->capabilities().largest_packet),
                          'x');
  ASSERT_TRUE(server_.send(large));
  ASSERT_TRUE(client_.receive() == large);
  ASSERT_TRUE(client_.send("for the parent"));
  const pid_t child = ::fork();
  if (child == 0) {
    int wrong = 0;
    if (client_.connection->loss() != Loss::Broken) wrong |= 1;
    if (client_.connection->send({}, {}).has_value()) wrong |= 2;
    if (server_.send(large).has_value()) wrong |= 32;
    client_.connection->beat();
    if (client_.connection->receive().has_value()) wrong |= 64;
    if (server_.connection->loss() != Loss::Broken) wrong |= 4;
    if (client_.connection->loss_text().find("fork") == std::string::npos) wrong |= 8;
    if (client_.connection->prepare_to_sleep()) wrong |= 16;
    client_.connection->woke();
    client_.connection.reset();  // must not say goodbye in the parent's name
    server_.connection.reset();
    acceptor_.reset();
    ::_exit(wrong);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(server_.receive(), "for the parent");
  ASSERT_TRUE(server_.send(large));
  EXPECT_TRUE(client_.receive() == large);
  EXPECT_EQ(client_.connection->loss(), Loss::None);
  auto another = connect();
  EXPECT_NE(wait_for_client(*acceptor_, *another.connection), nullptr)
      << "the acceptor still accepts";
}

INSTANTIATE_TEST_SUITE_P(
    Media, Conformance,
    testing::Values(
        Candidate{"inproc", [](const std::string&) { return make_inproc(); }},
        Candidate{"checked", [](const std::string&) { return make_checked(make_inproc()); }},
        Candidate{"shm",
                  [](const std::string& directory) { return make_shm({.directory = directory}); }},
        Candidate{"pair", [](const std::string&) { return make_pair_medium(); }},
        Candidate{
            "sealed_pair",
            [](const std::string& directory) { return make_sealed_pair(directory + "/keys"); }},
        Candidate{"lcm",
                  [](const std::string& directory) {
                    // A well-known place of this process: a broker may run on this host.
                    LcmOptions options;
                    options.well_known_port = port_of_this_process();
                    options.key_directory = directory + "/keys";
                    return make_lcm(options);
                  }}),
    [](const auto& candidate) { return candidate.param.name; });

}  // namespace
}  // namespace gecos::media
