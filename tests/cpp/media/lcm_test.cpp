// What is lcm's own: its bytes, its addresses, and strangers on its ports.

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/stat.h>

#include <random>

#include "gecos/crypto/opening.hpp"
#include "gecos/media/lcm.hpp"
#include "gecos/media/lcm/datagram.hpp"
#include "gecos/media/lcm/inbox.hpp"
#include "gecos/media/lcm/keys.hpp"
#include "gecos/media/lcm/outlet.hpp"
#include "gecos/media/lcm/port.hpp"
#include "gecos/media/lcm/stream.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

TEST(LcmDatagram, TheHeaderComesBackAndIsBigEndian) {
  const DatagramHeader header{
      .kind = DatagramKind::First, .reply_port = 0x1234, .client = 0x0102030405060708};
  std::array<std::byte, DatagramHeader::bytes> bytes;
  header.write(bytes);
  EXPECT_EQ(bytes[4], std::byte{0x12});
  EXPECT_EQ(bytes[8], std::byte{0x01});
  EXPECT_EQ(bytes[15], std::byte{0x08});
  const auto read = DatagramHeader::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->kind, header.kind);
  EXPECT_EQ(read->reply_port, header.reply_port);
  EXPECT_EQ(read->client, header.client);
}

TEST(LcmDatagram, WhatIsSealedSaysWhatItIs) {
  std::array<std::byte, InnerHeader::bytes> bytes;
  InnerHeader{InnerKind::Opened, 258, 0x0102}.write(bytes);
  EXPECT_EQ(bytes[7], std::byte{1});
  EXPECT_EQ(bytes[8], std::byte{2});
  const auto read = InnerHeader::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->kind, InnerKind::Opened);
  EXPECT_EQ(read->number, 258u);
  EXPECT_EQ(read->sent_ns, 0x0102);
  EXPECT_FALSE(InnerHeader::read(ByteView(bytes).first(InnerHeader::bytes - 1)));
  for (const std::byte wrong : {std::byte{0}, std::byte{7}, std::byte{0xff}}) {
    bytes[0] = wrong;
    EXPECT_FALSE(InnerHeader::read(bytes));
  }
}

TEST(LcmDatagram, StrangersBytesAreNoDatagram) {
  std::array<std::byte, DatagramHeader::bytes> bytes;
  DatagramHeader{}.write(bytes);
  ASSERT_TRUE(DatagramHeader::read(bytes));
  EXPECT_FALSE(DatagramHeader::read(ByteView(bytes).first(DatagramHeader::bytes - 1)));
  EXPECT_FALSE(DatagramHeader::read({}));
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{3}}) {
    auto wrong = bytes;
    wrong[at] = std::byte{0xff};
    EXPECT_FALSE(DatagramHeader::read(wrong)) << at;
  }
}

TEST(LcmDatagram, ASharedStreamComesBackAndIsChecked) {
  const crypto::StreamSealer sealer;
  const SharedStream stream{
      .id = 1, .largest = 2, .depth = 3, .port = 4, .channel = 5, .key = sealer.key()};
  std::array<std::byte, SharedStream::bytes> bytes;
  stream.write(bytes);
  const auto read = SharedStream::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->channel, 5u);
  EXPECT_EQ(read->depth, 3u);
  EXPECT_TRUE(std::ranges::equal(read->key.key.bytes(), sealer.key().key.bytes()));
  EXPECT_EQ(read->key.signer, sealer.key().signer);
  EXPECT_FALSE(SharedStream::read(ByteView(bytes).first(SharedStream::bytes - 1)));
  bytes[8] = bytes[9] = std::byte{0xff};
  EXPECT_FALSE(SharedStream::read(bytes)) << "a stream that keeps more than any of ours";
  bytes[8] = bytes[9] = std::byte{0};
  EXPECT_FALSE(SharedStream::read(bytes)) << "a stream that keeps nothing";
}

TEST(LcmAddress, ReadsWhatItWrites) {
  LcmAddress address{"239.255.76.67", 20017, "GO0123456789abcdef", std::nullopt};
  EXPECT_EQ(address.to_string(), "lcm:239.255.76.67:20017/GO0123456789abcdef");
  EXPECT_FALSE(LcmAddress::parse(address.to_string()).value().key);
  address.key = crypto::KeyPair::draw().public_key;
  EXPECT_EQ(address.place(), "lcm:239.255.76.67:20017/GO0123456789abcdef");
  EXPECT_EQ(address.to_string(), address.place() + "#" + address.key->to_string());
  const auto read = LcmAddress::parse(address.to_string());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->group, address.group);
  EXPECT_EQ(read->port, address.port);
  EXPECT_EQ(read->channel, address.channel);
  EXPECT_EQ(read->key, address.key);
}

TEST(LcmAddress, RefusesWhatIsNone) {
  for (const char* wrong :
       {"", "lcm:", "lcm:239.255.76.67", "lcm:239.255.76.67:1", "lcm:239.255.76.67:1/",
        "lcm:239.255.76.67:0/X", "lcm:239.255.76.67:70000/X", "lcm:239.255.76.67:1x/X", "lcm::1/X",
        "lcm:239.255.76.67?ttl=255&x:1/X", "lcm:239.255.76.67:1/X#",
        "lcm:239.255.76.67:1/X#12ab", "shm:/run/x.sock"}) {
    EXPECT_FALSE(LcmAddress::parse(wrong)) << wrong;
  }
  EXPECT_FALSE(LcmAddress::parse("lcm:239.255.76.67:1/" + std::string(64, 'X')));
}

TEST(SendersClock, TellsHowLongPacketsWaited) {
  SendersClock clock;
  const TimePoint begun{std::chrono::hours(5)};
  using namespace std::chrono_literals;
  const auto sent = [](Duration after) { return (std::chrono::hours(99) + after).count(); };
  EXPECT_EQ(clock.age(sent(0ms), begun + 3ms), 0ms) << "nothing is known yet";
  EXPECT_EQ(clock.age(sent(10ms), begun + 11ms), 0ms) << "2 ms quicker than the first";
  EXPECT_EQ(clock.age(sent(20ms), begun + 21ms), 0ms);
  const Duration waited = clock.age(sent(30ms), begun + 3031ms);
  EXPECT_LE(waited, 3s);
  EXPECT_GE(waited, 3s - 2ms) << "less what the clocks may have drifted meanwhile";
  EXPECT_EQ(clock.age(sent(3100ms), begun + 3101ms), 0ms);
}

TEST(SendersClock, GoesAlongWithAClockThatIsSlow) {
  SendersClock clock;
  for (int seconds = 0; seconds < 100'000; ++seconds) {
    const Duration here = std::chrono::seconds(seconds);
    ASSERT_EQ(clock.age((here - here / 5000).count(), TimePoint{here}), Duration::zero()) << seconds;
  }
}

TEST(SendersClock, IsNotUpsetByAnyNumber) {
  SendersClock clock;
  for (const std::int64_t sent : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1},
                                  std::int64_t{0}, std::numeric_limits<std::int64_t>::max()}) {
    clock.age(sent, TimePoint{});
    clock.age(sent, TimePoint::max());
  }
}

TEST(LcmInbox, BoundsItsMemoryAndCountsWhatItDropped) {
  LcmInbox inbox;
  const auto frame_of = [](std::size_t size) {
    Bytes frame(crypto::Sealer::overhead + InnerHeader::bytes + size);
    InnerHeader{InnerKind::Packet, 1}.write(
        std::span(frame).subspan<crypto::Sealer::text_at, InnerHeader::bytes>());
    return frame;
  };
  const std::size_t fits = LcmInbox::most_bytes / frame_of(1024).size();
  for (std::size_t i = 0; i < fits + 10; ++i) inbox.put(frame_of(1024), TimePoint{});
  EXPECT_EQ(inbox.dropped(), 10u);
  LcmInbox::Packet packet;
  ASSERT_TRUE(inbox.pop(packet));
  EXPECT_EQ(LcmInbox::packet_in(packet.frame).size(), 1024u);
  inbox.put(frame_of(1024), TimePoint{});
  EXPECT_EQ(inbox.dropped(), 10u);
  for (std::size_t i = 0; i < LcmInbox::most_packets; ++i) inbox.put(frame_of(0), TimePoint{});
  EXPECT_GT(inbox.dropped(), 10u) << "empty packets take memory too";
}

TEST(LcmPort, RunsOutOfDescriptorsWithAWord) {
  rlimit usual{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &usual), 0);
  const auto used = static_cast<rlim_t>(open_descriptors());
  int refused = 0;
  for (rlim_t spare = 0; spare < 24; ++spare) {
    const rlimit few{used + spare, usual.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
    auto port = LcmPort::open({}, draw_port());
    auto heard = port ? (*port)->subscribe("X", [](ByteView) {}) : tl::expected<void, MediumError>{};
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &usual), 0);
    if (port && heard) continue;
    const std::string text = port ? heard.error().text : port.error().text;
    EXPECT_NE(text.find("no descriptors are left"), std::string::npos) << text;
    ++refused;
  }
  EXPECT_GT(refused, 10);
}

TEST(LcmPort, AdvisesNoRouteToWhatIsNoMulticastGroup) {
  LcmOptions options;
  options.group = "1.2.3.4";
  const auto port = LcmPort::open(options, 20017);
  ASSERT_FALSE(port);
  EXPECT_NE(port.error().text.find("1.2.3.4 is no multicast group"), std::string::npos);
  EXPECT_EQ(port.error().text.find("ip route"), std::string::npos) << port.error().text;
}

/// Hears all that is sent to a channel of a port.
class Recorder {
 public:
  Recorder(std::uint16_t port, const std::string& channel) : port_(LcmPort::open({}, port).value()) {
    const auto heard = port_->subscribe(
        channel, [this](ByteView datagram) { all_.emplace_back(datagram.begin(), datagram.end()); });
    if (!heard) throw std::runtime_error(heard.error().text);
  }
  /// What came so far, at least one of `kind`.
  std::vector<Bytes> of(DatagramKind kind) {
    for (;;) {
      look();
      std::vector<Bytes> found;
      for (const Bytes& datagram : all_) {
        const auto header = DatagramHeader::read(datagram);
        if (header && header->kind == kind) found.push_back(datagram);
      }
      if (!found.empty()) return found;
      const std::array<int, 1> one{port_->descriptor()};
      if (sleep_on(one, too_late()) == Wake::TimedOut) return found;
    }
  }
  void look() {
    while (port_->pump()) continue;
  }
  const std::vector<Bytes>& all() const { return all_; }
  void say(const std::string& channel, ByteView datagram) { port_->publish(channel, datagram); }

 private:
  std::vector<Bytes> all_;
  const std::unique_ptr<LcmPort> port_;
};

LcmOptions with_keys(const ScratchDirectory& directory, const std::string& whose = "keys") {
  LcmOptions options;
  options.well_known_port = port_of_this_process();
  options.key_directory = directory.path() + "/" + whose;
  return options;
}

class LcmStrangers : public testing::Test {
 protected:
  explicit LcmStrangers(crypto::RekeyRule rekey = {})
      : medium_(make_lcm([&] {
          LcmOptions options = with_keys(directory_);
          options.rekey = rekey;
          return options;
        }())),
        door_(medium_->listen("RX90", false).value()),
        where_(LcmAddress::parse(door_->address()).value()),
        stranger_(where_.port, where_.channel),
        client_(std::move(*medium_->connect(door_->address()))),
        server_(wait_for_client(*door_, *client_.link), door_.get()) {}

  void expect_an_honest_call() {
    ASSERT_TRUE(client_.send("an honest call"));
    EXPECT_EQ(server_.receive(), "an honest call");
    EXPECT_TRUE(server_.others.empty());
    ASSERT_TRUE(server_.send("and its answer"));
    EXPECT_EQ(client_.receive(), "and its answer");
  }

  const ScratchDirectory directory_;
  const std::unique_ptr<Medium> medium_;
  const std::unique_ptr<Acceptor> door_;
  const LcmAddress where_;
  Recorder stranger_;
  End client_;
  End server_;
};

TEST_F(LcmStrangers, GarbageOnAnObjectsChannelMakesNoLinkAndStopsNothing) {
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
  EXPECT_TRUE(medium_->offer().authenticated);
  const std::string key = "key " + where_.key->short_name() + ", 239.255.76.67:";
  EXPECT_TRUE(client_.link->peer().description.starts_with(key));
  EXPECT_TRUE(server_.link->peer().description.starts_with(key)) << "one user, one key";
}

TEST_F(LcmStrangers, WhatIsForgedAlteredOrPlayedBackIsNotThePeers) {
  ASSERT_TRUE(client_.send("once"));
  ASSERT_EQ(server_.receive(), "once");
  const std::vector<Bytes> recorded = stranger_.of(DatagramKind::Sealed);
  const std::uint64_t beats = server_.link->beats_seen();
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
        std::span(forged).subspan<DatagramHeader::bytes + crypto::Sealer::text_at,
                                  InnerHeader::bytes>());
    crypto::Sealer other(crypto::Key{}, TimePoint{});
    other.seal(ByteView(forged).first(DatagramHeader::bytes),
               std::span(forged).subspan(DatagramHeader::bytes));
    stranger_.say(where_.channel, forged);
  }
  expect_an_honest_call();
  EXPECT_EQ(server_.link->beats_seen(), beats + 1) << "the honest call, and nothing else";
  EXPECT_EQ(server_.link->loss(), Loss::None);
  EXPECT_FALSE(server_.link->receive());
}

TEST_F(LcmStrangers, AFirstMessagePlayedBackMakesNoLink) {
  const std::size_t before = open_descriptors();
  const auto recorded = stranger_.of(DatagramKind::First);  // several on a busy machine
  for (const Bytes& first : recorded) stranger_.say(where_.channel, first);
  client_.link.reset();
  EXPECT_EQ(server_.wait_for_loss(), Loss::Closed);
  server_.link.reset();
  for (const Bytes& first : recorded) stranger_.say(where_.channel, first);
  client_ = End(std::move(*medium_->connect(door_->address())));
  server_ = End(wait_for_client(*door_, *client_.link), door_.get());
  expect_an_honest_call();
  EXPECT_LE(open_descriptors(), before);
}

TEST_F(LcmStrangers, FirstMessagesAloneHoldNoDescriptor) {
  const auto keys = LcmKeys::open(with_keys(directory_).key_directory).value();
  ASSERT_NE(keys, nullptr);
  const std::size_t before = open_descriptors();
  for (std::uint64_t i = 1; i <= 400; ++i) {
    Bytes first(DatagramHeader::bytes);
    DatagramHeader{DatagramKind::First, 20000, i}.write(
        std::span(first).first<DatagramHeader::bytes>());
    const auto opening =
        crypto::Opening::begin(keys->own, *where_.key, handshake_context(where_, first), {});
    first.insert(first.end(), opening->first().begin(), opening->first().end());
    stranger_.say(where_.channel, first);
  }
  expect_an_honest_call();
  EXPECT_EQ(door_->accept(), nullptr);
  EXPECT_EQ(open_descriptors(), before);
}

TEST_F(LcmStrangers, AClientWhoseAnswerWasLostGetsTheSameOneAgain) {
  const auto keys = LcmKeys::open(with_keys(directory_).key_directory).value();
  const std::uint64_t number = draw_number();
  const std::uint16_t reply_port = draw_port();
  Recorder client(reply_port, lcm_channel("GC", number));
  LcmOutlet outlet(LcmPort::open({}, where_.port).value(), where_.channel, number, reply_port);
  const auto opening = crypto::Opening::begin(
      keys->own, *where_.key, handshake_context(where_, outlet.header(DatagramKind::First)), {});
  ASSERT_TRUE(opening);
  for (std::size_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(outlet.send_bare(DatagramKind::First, opening->first()));
    const TimePoint end = too_late();
    while (client.all().size() < i && std::chrono::steady_clock::now() < end) {
      EXPECT_EQ(door_->accept(), nullptr) << "it has shown nothing yet";
      client.look();
    }
  }
  const auto answers = client.of(DatagramKind::Second);
  ASSERT_EQ(answers.size(), 3u);
  EXPECT_EQ(answers[0], answers[1]);
  EXPECT_EQ(answers[0], answers[2]);
  auto opened =
      opening->finish(ByteView(answers[2]).subspan(DatagramHeader::bytes), TimePoint{});
  ASSERT_TRUE(opened);
  outlet.open(std::move(opened->channel.out));
  Bytes memory;
  ASSERT_TRUE(outlet.send({InnerKind::Packet, 1}, bytes_of("met"), {}, memory));
  End met(wait_for_client(*door_), door_.get());
  ASSERT_NE(met.link, nullptr);
  EXPECT_EQ(met.receive(), "met");
  EXPECT_TRUE(met.others.empty()) << "three messages, one link";
}

TEST_F(LcmStrangers, AnotherChannelOfThePortIsNotHeard) {
  for (const Bytes& first : stranger_.of(DatagramKind::First)) {
    stranger_.say("GOsomebodyelse", first);
  }
  expect_an_honest_call();
}

TEST_F(LcmStrangers, AStreamThatWasRepeatedOrOvertakenNeverGoesBack) {
  const auto writer = door_->make_stream(100, 4);
  ASSERT_TRUE(server_.link->share(1, *writer));
  std::unique_ptr<StreamReader> reader;
  ASSERT_TRUE(wait_tended(client_, server_, [&] {
    reader = client_.link->open_stream(1);
    return reader != nullptr;
  }));
  ASSERT_TRUE(writer->publish(bytes_of("one"), 1));
  ASSERT_TRUE(writer->publish(bytes_of("two"), 2));
  StreamSample sample;
  ASSERT_TRUE(wait_tended(client_, server_, [&] { return reader->latest(1, sample); }));
  // Another reader opens it, so the last sample goes out again.
  ASSERT_TRUE(server_.link->share(1, *writer));
  const auto again = client_.link->open_stream(1);
  ASSERT_NE(again, nullptr);
  StreamSample same;
  ASSERT_TRUE(wait_tended(client_, server_, [&] { return again->latest(0, same); }));
  EXPECT_EQ(same.sequence, 2u);
  EXPECT_FALSE(reader->latest(2, sample));
  EXPECT_FALSE(reader->next(2, sample));
}

TEST_F(LcmStrangers, AReaderCannotForgeASampleToTheOthers) {
  const auto writer = door_->make_stream(100, 4);
  ASSERT_TRUE(server_.link->share(1, *writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  const SharedStream& where = dynamic_cast<LcmStreamWriter&>(*writer).stream()->where();
  const auto forger = LcmPort::open({}, where.port).value();
  // It has the stream's key, as every reader, and not what the writer signs with.
  Bytes forged(DatagramHeader::bytes + crypto::StreamSealer::overhead + 8 + 3);
  DatagramHeader{.kind = DatagramKind::Sample}.write(
      std::span(forged).first<DatagramHeader::bytes>());
  const std::span<std::byte> frame = std::span(forged).subspan(DatagramHeader::bytes);
  const std::size_t text = frame.size() - crypto::Sealer::overhead;
  crypto::aead_seal(where.key.key, 0, ByteView(forged).first(DatagramHeader::bytes),
                    frame.subspan(crypto::Sealer::text_at, text),
                    frame.last<crypto::tag_bytes>());
  forger->publish(lcm_channel("GS", where.channel), forged);
  ASSERT_TRUE(writer->publish(bytes_of("true"), 1));
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

/// Two users: each has a key directory.
class LcmUsers : public testing::Test {
 protected:
  void admit(const std::string& whom, const std::string& by) {
    const auto key = LcmKeys::open(options(whom).key_directory).value()->own.public_key();
    ASSERT_NE(LcmKeys::open(options(by).key_directory).value(), nullptr);
    const std::string file = "/" + key.to_string() + ".public";
    std::filesystem::copy(options(whom).key_directory + file, options(by).key_directory + file);
  }
  LcmOptions options(const std::string& whose) { return with_keys(directory_, whose); }
  /// What the client says of a server that it cannot meet.
  std::string trouble(Acceptor& door, Link& client, const std::string& expected) {
    const TimePoint end = too_late();
    while (client.loss_text().find(expected) == std::string::npos &&
           std::chrono::steady_clock::now() < end) {
      client.beat();
      EXPECT_EQ(client.loss(), Loss::None);
      EXPECT_EQ(door.accept(), nullptr);
    }
    return client.loss_text();
  }

  const ScratchDirectory directory_;
  const std::unique_ptr<Medium> ada_ = make_lcm(options("ada"));
  const std::unique_ptr<Medium> bob_ = make_lcm(options("bob"));
};

TEST_F(LcmUsers, AServerWhoseKeyIsNotAdmittedIsRefusedAtOnce) {
  const auto door = ada_->listen("RX90", false).value();
  const auto refused = bob_->connect(door->address());
  ASSERT_FALSE(refused);
  const auto key = LcmAddress::parse(door->address())->key.value();
  EXPECT_NE(refused.error().text.find("its key " + key.short_name() + " is not admitted here"),
            std::string::npos)
      << refused.error().text;
  EXPECT_NE(refused.error().text.find(options("bob").key_directory), std::string::npos);
}

TEST_F(LcmUsers, AClientWhoseKeyIsNotAdmittedIsNotMetAndToldWhatToDo) {
  admit("ada", "bob");
  const auto door = ada_->listen("RX90", false).value();
  auto client = std::move(*bob_->connect(door->address()));
  ASSERT_TRUE(client->send(bytes_of("let me in"), {}));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(door->accept(), nullptr);
  const std::string text = trouble(*door, *client, "is not admitted there");
  EXPECT_NE(text.find(options("bob").key_directory + "/"), std::string::npos) << text;
  admit("bob", "ada");
  EXPECT_NE(wait_for_client(*door, *client), nullptr) << "from now on, with the same link";
}

TEST_F(LcmUsers, AnImpostorAtAWellKnownPlaceIsRefused) {
  const auto impostor = ada_->listen("BROKER", true).value();
  auto client = std::move(*bob_->connect(bob_->well_known_address("BROKER")));
  const std::string text = trouble(*impostor, *client, "who answered there was refused");
  EXPECT_NE(text.find("is not admitted here"), std::string::npos) << text;
}

TEST_F(LcmUsers, AKeyDirectoryThatOthersMayReadIsAnErrorThatSaysSo) {
  ASSERT_TRUE(std::filesystem::create_directory(options("eve").key_directory));
  ASSERT_EQ(::chmod(options("eve").key_directory.c_str(), 0755), 0);
  const auto medium = make_lcm(options("eve"));
  const auto door = medium->listen("RX90", false);
  ASSERT_FALSE(door);
  EXPECT_NE(door.error().text.find("lcm needs a key"), std::string::npos) << door.error().text;
  EXPECT_NE(door.error().text.find("chmod 700"), std::string::npos) << door.error().text;
  ASSERT_EQ(::chmod(options("eve").key_directory.c_str(), 0700), 0);
  EXPECT_TRUE(medium->listen("RX90", false)) << "mended, it works without another medium";
}

TEST_F(LcmUsers, EachOfTwoUsersWhoAdmitEachOtherProvesItsKey) {
  admit("ada", "bob");
  admit("bob", "ada");
  const auto door = ada_->listen("RX90", false).value();
  End client(std::move(*bob_->connect(door->address())));
  End server(wait_for_client(*door, *client.link), door.get());
  ASSERT_NE(server.link, nullptr);
  const auto bob = LcmKeys::open(options("bob").key_directory).value()->own.public_key();
  EXPECT_TRUE(server.link->peer().description.starts_with("key " + bob.short_name()));
  ASSERT_TRUE(client.send("hello"));
  EXPECT_EQ(server.receive(), "hello");
}

TEST_F(LcmUsers, BothSidesMayBeginAgain) {
  for (int life = 0; life < 3; ++life) {
    const auto door = ada_->listen("BROKER", true).value();
    for (int client_life = 0; client_life < 3; ++client_life) {
      End client(std::move(*ada_->connect(door->address())));
      End server(wait_for_client(*door, *client.link), door.get());
      ASSERT_NE(server.link, nullptr);
      ASSERT_TRUE(client.send("hello"));
      ASSERT_EQ(server.receive(), "hello");
      if (client_life == 1) {
        client.link.reset();
        EXPECT_EQ(server.wait_for_loss(), Loss::Closed);
      } else {
        server.link.reset();
        EXPECT_EQ(client.wait_for_loss(), Loss::Closed);
      }
    }
  }
}

TEST_F(LcmUsers, ARecordingPlayedToTheNextLifeOfAServerMakesNoLink) {
  std::vector<Bytes> recorded;
  const LcmAddress place = LcmAddress::parse(ada_->well_known_address("BROKER")).value();
  Recorder stranger(place.port, place.channel);
  {
    const auto door = ada_->listen("BROKER", true).value();
    End client(std::move(*ada_->connect(door->address())));
    End server(wait_for_client(*door, *client.link), door.get());
    ASSERT_TRUE(client.send("move"));
    ASSERT_EQ(server.receive(), "move");
    ASSERT_FALSE(stranger.of(DatagramKind::Sealed).empty());
    recorded = stranger.all();
  }
  const auto door = ada_->listen("BROKER", true).value();
  for (const Bytes& datagram : recorded) stranger.say(place.channel, datagram);
  End client(std::move(*ada_->connect(door->address())));
  End server(wait_for_client(*door, *client.link), door.get());
  ASSERT_TRUE(client.send("hello"));
  EXPECT_EQ(server.receive(), "hello");
  EXPECT_TRUE(server.others.empty());
}

}  // namespace
}  // namespace gecos::media
