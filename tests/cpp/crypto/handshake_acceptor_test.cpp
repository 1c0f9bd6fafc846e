#include "gecos/crypto/handshake_acceptor.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <set>

#include "channel_pair.hpp"

namespace gecos::crypto {
namespace {

using gecos::testing::bytes_of;
using gecos::testing::opened;
using gecos::testing::sealed;
using gecos::testing::text_of;
using namespace std::chrono_literals;

class HandshakeAcceptorTest : public ::testing::Test {
 protected:
  HandshakeAcceptor make_acceptor(HandshakeRule rule = {}) {
    return HandshakeAcceptor(
        server, [this](const PublicKey& peer) { return admitted.count(peer) != 0; }, rule);
  }
  HandshakeInitiator begin(const Identity& who) {
    return HandshakeInitiator::begin(who, server.public_key(), place, bytes_of("hello")).value();
  }
  /// "second" and what of it; or why not.
  std::string answer(HandshakeAcceptor& acceptor, ByteView first) {
    const auto answered = acceptor.answer(first, place, {}, now);
    if (!answered) return std::string(to_string(answered.error().why));
    return answered->channel ? "a channel" : "again";
  }

  const Identity client{KeyPair::draw()};
  const Identity stranger{KeyPair::draw()};
  const Identity server{KeyPair::draw()};
  std::set<PublicKey> admitted{client.public_key()};
  const Bytes place = bytes_of("place");
  TimePoint now{1h};
};

TEST_F(HandshakeAcceptorTest, WhoIsAdmittedGetsAChannelAndBothKnowEachOther) {
  auto acceptor = make_acceptor();
  const auto initiator = begin(client);
  auto answer = acceptor.answer(initiator.first(), place, bytes_of("welcome"), now);
  ASSERT_TRUE(answer);
  EXPECT_EQ(text_of(answer->payload), "hello");
  ASSERT_TRUE(answer->channel);
  EXPECT_EQ(answer->channel->peer, client.public_key());
  EXPECT_FALSE(answer->channel->in.opened_any()) << "it may be a recording";

  auto finished = initiator.finish(answer->second, now);
  ASSERT_TRUE(finished);
  EXPECT_EQ(text_of(finished->payload), "welcome");
  EXPECT_EQ(finished->channel.peer, server.public_key());
  EXPECT_EQ(opened(answer->channel->in, sealed(finished->channel.out, "call")), "call");
  EXPECT_EQ(opened(finished->channel.in, sealed(answer->channel->out, "reply")), "reply");
  EXPECT_TRUE(answer->channel->in.opened_any());
}

TEST_F(HandshakeAcceptorTest, WhoIsNotAdmittedIsNamedAndNothingOfItIsKept) {
  auto acceptor = make_acceptor();
  const auto refused = acceptor.answer(begin(stranger).first(), place, {}, now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().why, Refusal::NotAdmitted);
  EXPECT_EQ(refused.error().who, stranger.public_key());
  EXPECT_EQ(acceptor.remembered(), 0U);
}

TEST_F(HandshakeAcceptorTest, NothingIsKeptOfWhatIsNotProved) {
  auto acceptor = make_acceptor({.burst = 10'000});
  const auto initiator = begin(client);
  for (std::size_t byte = 0; byte < initiator.first().size(); ++byte) {
    Bytes forged = initiator.first();
    forged[byte] ^= std::byte{4};
    ASSERT_EQ(answer(acceptor, forged), to_string(Refusal::Malformed)) << byte;
  }
  for (std::size_t size = 0; size < initiator.first().size(); ++size) {
    ASSERT_EQ(answer(acceptor, ByteView(initiator.first()).first(size)),
              to_string(Refusal::Malformed));
  }
  EXPECT_EQ(acceptor.remembered(), 0U);
  EXPECT_EQ(answer(acceptor, initiator.first()), "a channel");
}

TEST_F(HandshakeAcceptorTest, AFirstMessageOfAnotherPlaceIsWorthNothing) {
  auto acceptor = make_acceptor();
  const auto elsewhere =
      HandshakeInitiator::begin(client, server.public_key(), bytes_of("another place"), {}).value();
  EXPECT_EQ(answer(acceptor, elsewhere.first()), to_string(Refusal::Malformed));
}

TEST_F(HandshakeAcceptorTest, ARepetitionGetsTheSameAnswerAndNoSecondChannel) {
  auto acceptor = make_acceptor();
  const auto initiator = begin(client);
  auto lost = acceptor.answer(initiator.first(), place, {}, now);
  ASSERT_TRUE(lost);
  now += 160ms;
  const auto again = acceptor.answer(initiator.first(), place, {}, now);
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->channel);
  auto finished = initiator.finish(again->second, now);
  ASSERT_TRUE(finished);
  EXPECT_EQ(opened(lost->channel->in, sealed(finished->channel.out, "call")), "call");
}

TEST_F(HandshakeAcceptorTest, ARecordingPlayedLaterIsRefused) {
  auto acceptor = make_acceptor();
  const auto initiator = begin(client);
  EXPECT_EQ(answer(acceptor, initiator.first()), "a channel");
  now += HandshakeRule{}.answers_kept - 1ns;
  EXPECT_EQ(answer(acceptor, initiator.first()), "again");
  now += 1ns;
  EXPECT_EQ(answer(acceptor, initiator.first()), to_string(Refusal::Replayed));
  now += 1000h;
  EXPECT_EQ(answer(acceptor, initiator.first()), to_string(Refusal::Replayed));
}

TEST_F(HandshakeAcceptorTest, MemoryIsBoundedAndTheOldestGoesFirst) {
  auto acceptor = make_acceptor({.burst = 100, .remembered = 4});
  const auto first = begin(client);
  EXPECT_EQ(answer(acceptor, first.first()), "a channel");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(answer(acceptor, begin(client).first()), "a channel");
  EXPECT_EQ(answer(acceptor, first.first()), "again");
  now += 10s;
  EXPECT_EQ(answer(acceptor, first.first()), to_string(Refusal::Replayed));
  const auto newest = begin(client);
  EXPECT_EQ(answer(acceptor, newest.first()), "a channel");
  EXPECT_EQ(acceptor.remembered(), 4U);
  // Forgotten: it makes a channel, that nobody has the key of.
  EXPECT_EQ(answer(acceptor, first.first()), "a channel");
  EXPECT_EQ(answer(acceptor, newest.first()), "again");
}

TEST_F(HandshakeAcceptorTest, AFloodIsLookedAtOnlyAsOftenAsTheRuleSays) {
  auto acceptor = make_acceptor({.burst = 5, .per_second = 10});
  const Bytes garbage(IkInitiator::first_overhead);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(answer(acceptor, garbage), to_string(Refusal::Malformed));
  const auto honest = begin(client);
  EXPECT_EQ(answer(acceptor, honest.first()), to_string(Refusal::Busy));
  now += 99ms;
  EXPECT_EQ(answer(acceptor, honest.first()), to_string(Refusal::Busy));
  now += 2ms;
  EXPECT_EQ(answer(acceptor, honest.first()), "a channel");
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(answer(acceptor, honest.first()), "again") << "costs nothing";
  EXPECT_EQ(answer(acceptor, garbage), to_string(Refusal::Busy));
  now += 1h;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(answer(acceptor, garbage), to_string(Refusal::Malformed));
  EXPECT_EQ(answer(acceptor, garbage), to_string(Refusal::Busy)) << "rest is not saved up";
}

TEST_F(HandshakeAcceptorTest, AServerThatStartedAnewTakesTheSameClient) {
  auto before = make_acceptor();
  const auto initiator = begin(client);
  EXPECT_EQ(answer(before, initiator.first()), "a channel");
  auto after = make_acceptor();
  EXPECT_EQ(answer(after, begin(client).first()), "a channel");
}

TEST_F(HandshakeAcceptorTest, AClientThatStartedAnewIsAnotherChannel) {
  auto acceptor = make_acceptor();
  auto first = acceptor.answer(begin(client).first(), place, {}, now);
  auto second = acceptor.answer(begin(client).first(), place, {}, now);
  ASSERT_TRUE(first && second);
  EXPECT_NE(first->channel->binding, second->channel->binding);
  EXPECT_NE(opened(second->channel->in, sealed(first->channel->out, "x")), "x");
}

TEST_F(HandshakeAcceptorTest, APlayedBackFirstMessageGivesItsPlayerNothing) {
  auto before = make_acceptor();
  const auto initiator = begin(client);
  auto honest = before.answer(initiator.first(), place, {}, now);
  auto client_end = initiator.finish(honest->second, now);
  const Bytes call = sealed(client_end->channel.out, "call");
  auto after = make_acceptor();  // forgot everything
  auto replayed = after.answer(initiator.first(), place, {}, now);
  ASSERT_TRUE(replayed && replayed->channel);
  EXPECT_NE(opened(replayed->channel->in, call), "call") << "recorded calls do not open";
  EXPECT_FALSE(replayed->channel->in.opened_any());
}

}  // namespace
}  // namespace gecos::crypto
