// Packets of somebody on the wire who hears everything, may say anything, and has no key.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <random>
#include <vector>

#include "channel_pair.hpp"
#include "gecos/crypto/stream_seal.hpp"

namespace gecos::crypto {
namespace {

using gecos::testing::open_pair;

/// How many packets: 100,000, or what GECOS_HOSTILE_PACKETS says (a million in soak).
std::size_t most_packets() {
  const char* const asked = std::getenv("GECOS_HOSTILE_PACKETS");
  return asked == nullptr ? 100'000 : std::strtoull(asked, nullptr, 10);
}

class Attacker {
 public:
  explicit Attacker(std::uint64_t seed) : random_(seed) {}

  std::size_t below(std::size_t limit) { return random_() % limit; }

  Bytes noise(std::size_t size) {
    Bytes bytes(size);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random_());
    return bytes;
  }

  /// `frame`, but not any more what was sealed; nor `other`, which was sealed too.
  Bytes spoil(Bytes frame, const Bytes& other) {
    const Bytes before = frame;
    while (frame == before || frame == other) {
      switch (below(6)) {
        case 0:  // one bit, anywhere
          frame[below(frame.size())] ^= std::byte(1U << below(8));
          break;
        case 1:  // cut short
          frame.resize(below(frame.size()));
          break;
        case 2: {  // longer
          const Bytes more = noise(1 + below(40));
          frame.insert(frame.end(), more.begin(), more.end());
          break;
        }
        case 3:  // the counter of another packet
          std::copy_n(other.begin(), Sealer::text_at, frame.begin());
          break;
        case 4: {  // its head, and the tail of another
          const auto from =
              static_cast<std::ptrdiff_t>(below(std::min(frame.size(), other.size())));
          frame.resize(other.size());
          std::copy(other.begin() + from, other.end(), frame.begin() + from);
          break;
        }
        case 5:  // nothing of it, but a counter that may come
          frame = noise(frame.size());
          std::fill_n(frame.begin(), 7, std::byte{0});
          break;
      }
    }
    return frame;
  }

 private:
  std::mt19937_64 random_;
};

TEST(Hostile, OfForgedFlippedCutReplayedAndReorderedPacketsEachHonestOneIsDeliveredOnce) {
  Attacker attacker(2026);
  auto pair = open_pair({.packets = 1000});
  struct Sent {
    Bytes frame;
    std::uint64_t content = 0;
    bool delivered = false;
  };
  std::vector<Sent> wire;  // what was heard so far, newest last
  std::size_t delivered = 0;
  std::size_t refused = 0;
  std::uint64_t next_content = 0;
  const auto arrives = [&](Bytes frame, Sent* honest) {  // ASSERT leaves only this
    const auto text = pair.server.in.open({}, frame);
    if (!text) {
      ++refused;
      return;
    }
    ASSERT_NE(honest, nullptr) << "forged, and accepted";
    ASSERT_FALSE(honest->delivered) << "delivered twice";
    ASSERT_GE(text->size(), sizeof honest->content);
    std::uint64_t content = 0;
    std::memcpy(&content, text->data(), sizeof content);
    ASSERT_EQ(content, honest->content);
    honest->delivered = true;
    ++delivered;
  };
  for (std::size_t packet = 0; packet < most_packets() && !HasFatalFailure(); ++packet) {
    if (wire.empty() || attacker.below(4) == 0) {
      Sent sent{Bytes(Sealer::overhead + 8 + attacker.below(200)), next_content++};
      std::memcpy(sent.frame.data() + Sealer::text_at, &sent.content, sizeof sent.content);
      pair.client.out.seal({}, sent.frame);
      if (wire.size() == 512) wire.erase(wire.begin());
      wire.push_back(std::move(sent));
    }
    Sent& heard = wire[wire.size() - 1 - attacker.below(std::min<std::size_t>(wire.size(), 512))];
    const Sent& other = wire[attacker.below(wire.size())];
    if (attacker.below(3) == 0) {
      arrives(heard.frame, &heard);  // late, early, for the first time or again
    } else {
      arrives(attacker.spoil(heard.frame, other.frame), nullptr);
    }
  }
  EXPECT_GT(delivered, most_packets() / 20);
  EXPECT_GT(refused, most_packets() / 2);
  // After all of it the channel is as good as new.
  Bytes last(Sealer::overhead);
  pair.client.out.seal({}, last);
  EXPECT_TRUE(pair.server.in.open({}, last));
}

TEST(Hostile, NoForgedSampleOfAStreamIsAccepted) {
  Attacker attacker(7);
  StreamSealer writer;
  StreamOpener reader(writer.key());
  Bytes before(StreamSealer::overhead + 60);
  writer.seal({}, before);
  for (std::size_t i = 0; i < most_packets() / 10; ++i) {
    Bytes frame(StreamSealer::overhead + 60);
    writer.seal({}, frame);
    Bytes forged = attacker.spoil(frame, before);
    ASSERT_FALSE(reader.open({}, forged));
    before = frame;
    ASSERT_TRUE(reader.open({}, frame));
  }
}

TEST(Hostile, NoForgedHandshakeIsAnsweredAndNothingOfOneIsKept) {
  Attacker attacker(11);
  const Identity client(KeyPair::draw());
  const Identity server(KeyPair::draw());
  HandshakeAcceptor acceptor(server, [](const auto&) { return true; }, {.burst = 1'000'000'000});
  const Bytes one = HandshakeInitiator::begin(client, server.public_key(), {}, {})->first();
  const auto initiator = HandshakeInitiator::begin(client, server.public_key(), {}, {});
  // X25519 makes these a hundred times dearer than packets.
  for (std::size_t i = 0; i < most_packets() / 50; ++i) {
    ASSERT_FALSE(acceptor.answer(attacker.spoil(initiator->first(), one), {}, {}, TimePoint{}));
  }
  EXPECT_EQ(acceptor.remembered(), 0U);
  const auto answer = acceptor.answer(initiator->first(), {}, {}, TimePoint{});
  ASSERT_TRUE(answer);
  for (std::size_t i = 0; i < most_packets() / 50; ++i) {
    ASSERT_FALSE(initiator->finish(attacker.spoil(answer->second, one), TimePoint{}));
  }
  EXPECT_TRUE(initiator->finish(answer->second, TimePoint{}));
}

}  // namespace
}  // namespace gecos::crypto
