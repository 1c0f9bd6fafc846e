// Strangers on lcm's ports: what they hear, forge, alter and play back.
#include <gtest/gtest.h>

#include <random>

#include "gecos/crypto/handshake_initiator.hpp"
#include "gecos/media/sealed/keys.hpp"
#include "gecos/media/sealed/sender.hpp"
#include "gecos/media/sealed/stream.hpp"
#include "lcm_recorder.hpp"

namespace gecos::media {
namespace {

class LcmStrangers : public testing::Test {
 protected:
  explicit LcmStrangers(crypto::RekeyRule rekey = {})
      : medium_(make_lcm([&] {
          LcmOptions options = with_keys(directory_);
          options.rekey = rekey;
          return options;
        }())),
        acceptor_(medium_->listen("RX90", false).value()),
        where_(SealedAddress::parse(acceptor_->address()).value()),
        stranger_(where_.port, where_.channel),
        client_(std::move(*medium_->connect(acceptor_->address()))),
        server_(wait_for_client(*acceptor_, *client_.connection), acceptor_.get()) {}

  void expect_an_honest_call() {
    ASSERT_TRUE(client_.send("an honest call"));
    EXPECT_EQ(server_.receive(), "an honest call");
    EXPECT_TRUE(server_.others.empty());
    ASSERT_TRUE(server_.send("and its answer"));
    EXPECT_EQ(client_.receive(), "and its answer");
  }

  const ScratchDirectory directory_;
  const std::unique_ptr<Medium> medium_;
  const std::unique_ptr<Acceptor> acceptor_;
  const SealedAddress where_;
  Recorder stranger_;
  End client_;
  End server_;
};

TEST_F(LcmStrangers, GarbageOnAnObjectsChannelMakesNoConnectionAndStopsNothing) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 500; ++i) {
    Bytes garbage(random() % 200);
    for (std::byte& byte : garbage) byte = static_cast<std::byte>(random());
    if (i % 2 == 0 && garbage.size() >= DatagramHeader::bytes) {
      DatagramHeader{static_cast<DatagramKind>(1 + i / 2 % 6), 20000, random()}.write(
          std::span(garbage).first<DatagramHeader::bytes>());
    }
    stranger_.say(where_.channel, garbage);
  }
  expect_an_honest_call();
}

TEST_F(LcmStrangers, NothingIsInClearButWhoSendsToWhom) {
  const std::string text = "move to the left, forty-two millimetres";
  ASSERT_TRUE(client_.send(text));
  ASSERT_EQ(server_.receive(), text);
  ASSERT_FALSE(stranger_.of(DatagramKind::Sealed).empty());
  for (const Bytes& datagram : stranger_.all()) {
    EXPECT_EQ(text_of(datagram).find("forty"), std::string::npos);
    const auto kind = DatagramHeader::read(datagram).value().kind;
    EXPECT_TRUE(kind == DatagramKind::First || kind == DatagramKind::Sealed);
  }
  EXPECT_TRUE(medium_->capabilities().authenticated);
  const std::string key = "key " + where_.key->short_name() + ", 239.255.76.67:";
  EXPECT_TRUE(client_.connection->peer().description.starts_with(key));
  EXPECT_TRUE(server_.connection->peer().description.starts_with(key)) << "one user, one key";
}

TEST_F(LcmStrangers, WhatIsForgedAlteredOrPlayedBackIsNotThePeers) {
  ASSERT_TRUE(client_.send("once"));
  ASSERT_EQ(server_.receive(), "once");
  const std::vector<Bytes> recorded = stranger_.of(DatagramKind::Sealed);
  const std::uint64_t beats = server_.connection->beats_seen();
  for (const Bytes& datagram : recorded) {
    stranger_.say(where_.channel, datagram);
    for (std::size_t at = 4; at < datagram.size(); ++at) {
      Bytes altered = datagram;
      altered[at] ^= std::byte{1};
      stranger_.say(where_.channel, altered);
    }
  }
  // A goodbye and a beat by somebody who has everything but the key.
  for (const InnerKind kind : {InnerKind::Bye, InnerKind::Beat}) {
    Bytes forged = recorded.front();
    forged.resize(DatagramHeader::bytes + crypto::Sealer::overhead + InnerHeader::bytes);
    InnerHeader{kind, 0}.write(
        std::span(forged)
            .subspan<DatagramHeader::bytes + crypto::Sealer::text_at, InnerHeader::bytes>());
    crypto::Sealer other(crypto::Key{}, TimePoint{});
    other.seal(ByteView(forged).first(DatagramHeader::bytes),
               std::span(forged).subspan(DatagramHeader::bytes));
    stranger_.say(where_.channel, forged);
  }
  expect_an_honest_call();
  EXPECT_EQ(server_.connection->beats_seen(), beats + 1) << "the honest call, and nothing else";
  EXPECT_EQ(server_.connection->loss(), Loss::None);
  EXPECT_FALSE(server_.connection->receive());
}

TEST_F(LcmStrangers, AFirstMessagePlayedBackMakesNoConnection) {
  const std::size_t before = open_descriptors();
  const auto recorded = stranger_.of(DatagramKind::First);  // several on a busy machine
  for (const Bytes& first : recorded) stranger_.say(where_.channel, first);
  client_.connection.reset();
  EXPECT_EQ(server_.wait_for_loss(), Loss::Closed);
  server_.connection.reset();
  for (const Bytes& first : recorded) stranger_.say(where_.channel, first);
  client_ = End(std::move(*medium_->connect(acceptor_->address())));
  server_ = End(wait_for_client(*acceptor_, *client_.connection), acceptor_.get());
  expect_an_honest_call();
  EXPECT_LE(open_descriptors(), before);
}

TEST_F(LcmStrangers, FirstMessagesAloneHoldNoDescriptor) {
  const auto keys = SealedKeys::open(with_keys(directory_).key_directory).value();
  ASSERT_NE(keys, nullptr);
  const std::size_t before = open_descriptors();
  for (std::uint64_t i = 1; i <= 400; ++i) {
    Bytes first(DatagramHeader::bytes);
    DatagramHeader{DatagramKind::First, 20000, i}.write(
        std::span(first).first<DatagramHeader::bytes>());
    const auto initiator = crypto::HandshakeInitiator::begin(keys->own, *where_.key,
                                                             handshake_context(where_, first), {});
    first.insert(first.end(), initiator->first().begin(), initiator->first().end());
    stranger_.say(where_.channel, first);
  }
  expect_an_honest_call();
  EXPECT_EQ(acceptor_->accept(), nullptr);
  EXPECT_EQ(open_descriptors(), before);
}

TEST_F(LcmStrangers, AClientWhoseAnswerWasLostGetsTheSameOneAgain) {
  const auto keys = SealedKeys::open(with_keys(directory_).key_directory).value();
  const std::uint64_t number = draw_number();
  const std::uint16_t reply_port = draw_port();
  Recorder client(reply_port, channel_name("GC", number));
  SealedSender sender(LcmPort::open({}, where_.port).value(), where_.channel, number, reply_port);
  const auto initiator = crypto::HandshakeInitiator::begin(
      keys->own, *where_.key, handshake_context(where_, sender.header(DatagramKind::First)), {});
  ASSERT_TRUE(initiator);
  for (std::size_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(sender.send_bare(DatagramKind::First, initiator->first()));
    const TimePoint end = too_late();
    while (client.all().size() < i && std::chrono::steady_clock::now() < end) {
      EXPECT_EQ(acceptor_->accept(), nullptr) << "it has shown nothing yet";
      client.look();
    }
  }
  const auto answers = client.of(DatagramKind::Second);
  ASSERT_EQ(answers.size(), 3u);
  EXPECT_EQ(answers[0], answers[1]);
  EXPECT_EQ(answers[0], answers[2]);
  auto opened = initiator->finish(ByteView(answers[2]).subspan(DatagramHeader::bytes), TimePoint{});
  ASSERT_TRUE(opened);
  sender.open(std::move(opened->channel.out));
  Bytes memory;
  ASSERT_TRUE(sender.send({InnerKind::Packet, 1}, bytes_of("met"), {}, memory));
  End met(wait_for_client(*acceptor_), acceptor_.get());
  ASSERT_NE(met.connection, nullptr);
  EXPECT_EQ(met.receive(), "met");
  EXPECT_TRUE(met.others.empty()) << "three messages, one connection";
}

TEST_F(LcmStrangers, AnotherChannelOfThePortIsNotHeard) {
  for (const Bytes& first : stranger_.of(DatagramKind::First)) {
    stranger_.say("GOsomebodyelse", first);
  }
  expect_an_honest_call();
}

TEST_F(LcmStrangers, AStreamThatWasRepeatedOrOvertakenNeverGoesBack) {
  const auto writer = acceptor_->make_stream(100, 4);
  ASSERT_TRUE(server_.connection->share(1, *writer));
  std::unique_ptr<StreamReader> reader;
  ASSERT_TRUE(wait_ticking(client_, server_, [&] {
    reader = client_.connection->open_stream(1);
    return reader != nullptr;
  }));
  ASSERT_TRUE(writer->publish(bytes_of("one"), 1));
  ASSERT_TRUE(writer->publish(bytes_of("two"), 2));
  StreamSample sample;
  ASSERT_TRUE(wait_ticking(client_, server_, [&] { return reader->latest(1, sample); }));
  // Another reader opens it, so the last sample goes out again.
  ASSERT_TRUE(server_.connection->share(1, *writer));
  const auto again = client_.connection->open_stream(1);
  ASSERT_NE(again, nullptr);
  StreamSample same;
  ASSERT_TRUE(wait_ticking(client_, server_, [&] { return again->latest(0, same); }));
  EXPECT_EQ(same.sequence, 2u);
  EXPECT_FALSE(reader->latest(2, sample));
  EXPECT_FALSE(reader->next(2, sample));
}

/// Sends nothing, and keeps the last datagram for the test.
class HoldingPort final : public DatagramPort {
 public:
  tl::expected<std::uint64_t, MediumError> subscribe(const std::string&, Take) override {
    return 0;
  }
  void unsubscribe(std::uint64_t) override {}
  int descriptor() const override { return -1; }
  bool pump(int) override { return false; }
  bool publish(const std::string&, ByteView datagram) override {
    held.assign(datagram.begin(), datagram.end());
    return true;
  }
  Bytes held;
};

TEST_F(LcmStrangers, AReaderCannotForgeASampleToTheOthers) {
  const auto port = std::make_shared<HoldingPort>();
  const auto made = acceptor_->make_stream(100, 4);
  SealedStreamWriter writer(std::make_shared<SealedStream>(
      port, dynamic_cast<SealedStreamWriter&>(*made).stream()->where()));
  ASSERT_TRUE(server_.connection->share(1, writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  ASSERT_TRUE(writer.publish(bytes_of("true"), 1));
  const Bytes by_the_writer = port->held;
  const SharedStream where = writer.stream()->where();
  // The forger has the stream's key, as every reader, and not what the writer signs with.
  const auto sealed_again = [&](std::string_view sample, bool keep_signature) {
    Bytes datagram = by_the_writer;
    const ByteView header = ByteView(datagram).first(DatagramHeader::bytes);
    const auto frame = std::span(datagram).subspan(DatagramHeader::bytes);
    const auto text =
        frame.subspan(crypto::Sealer::text_at, frame.size() - crypto::Sealer::overhead);
    const auto tag = frame.last<crypto::tag_bytes>();
    EXPECT_TRUE(crypto::aead_open(where.key.key, 0, header, text, tag));
    std::ranges::copy(bytes_of(sample), text.begin() + stamp_bytes);
    if (!keep_signature) {
      std::ranges::fill(text.last(crypto::StreamSealer::signature_bytes), std::byte{});
    }
    crypto::aead_seal(where.key.key, 0, header, text, tag);
    return datagram;
  };
  ASSERT_EQ(sealed_again("true", true), by_the_writer) << "all but the signature is right";
  const auto forger = LcmPort::open({}, where.port).value();
  const std::string channel = channel_name("GS", where.channel);
  forger->publish(channel, sealed_again("lies", true));
  forger->publish(channel, sealed_again("lies", false));
  forger->publish(channel, by_the_writer);
  StreamSample sample;
  ASSERT_TRUE(client_.wait([&] { return reader->next(0, sample); }));
  EXPECT_EQ(text_of(sample.bytes), "true");
}

class LcmRekeying : public LcmStrangers {
 protected:
  LcmRekeying() : LcmStrangers({.packets = 3}) {}
};

TEST_F(LcmRekeying, KeysMoveOnWhileCallsGoBothWays) {
  for (int i = 0; i < 100; ++i) expect_an_honest_call();
}

}  // namespace
}  // namespace gecos::media
