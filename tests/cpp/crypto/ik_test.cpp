#include "gecos/crypto/ik.hpp"

#include <gtest/gtest.h>

#include "channel_pair.hpp"
#include "json.hpp"

namespace gecos::crypto {
namespace {

using gecos::testing::bytes_of;
using gecos::testing::Json;
using gecos::testing::to_hex;

KeyPair pair_of(const Json& secret) {
  const Bytes bytes = secret.bytes();
  return KeyPair::of(Secret<key_bytes>(std::span<const std::byte, key_bytes>(bytes)));
}

void expect_transport(const Key& key, std::uint64_t counter, const Json& message) {
  Bytes text = message["payload"].bytes();
  std::array<std::byte, tag_bytes> tag;
  aead_seal(key, counter, {}, text, tag);
  EXPECT_EQ(to_hex(text) + to_hex(tag), message["ciphertext"].text);
  ASSERT_TRUE(aead_open(key, counter, {}, text, tag));
  EXPECT_EQ(to_hex(text), message["payload"].text);
}

TEST(Ik, SpeaksAsThePublishedVectorsDo) {
  const Json file = Json::from_vectors("noise_ik.json");
  const auto& vectors = file["vectors"].items;
  ASSERT_EQ(vectors.size(), 6U);
  for (const Json& vector : vectors) {
    SCOPED_TRACE(vector["source"].text);
    const auto& messages = vector["messages"].items;
    const Identity initiators(pair_of(vector["initiator_static"]));
    const Identity responders(pair_of(vector["responder_static"]));
    const Bytes prologue = vector["prologue"].bytes();

    IkInitiator initiator(initiators, responders.public_key(), prologue,
                          pair_of(vector["initiator_ephemeral"]));
    const auto first = initiator.write_first(messages[0]["payload"].bytes());
    ASSERT_TRUE(first);
    EXPECT_EQ(to_hex(*first), messages[0]["ciphertext"].text);

    const auto responder = IkResponder::read_first(responders, *first, prologue);
    ASSERT_TRUE(responder);
    EXPECT_EQ(responder->initiator(), initiators.public_key());
    EXPECT_EQ(to_hex(responder->payload()), messages[0]["payload"].text);
    const auto theirs = responder->write_second(messages[1]["payload"].bytes(),
                                                pair_of(vector["responder_ephemeral"]));
    ASSERT_TRUE(theirs);
    EXPECT_EQ(to_hex(theirs->message), messages[1]["ciphertext"].text);

    const auto ours = initiator.read_second(theirs->message);
    ASSERT_TRUE(ours);
    EXPECT_EQ(to_hex(ours->payload), messages[1]["payload"].text);
    EXPECT_EQ(ours->keys.binding, theirs->keys.binding);
    if (vector.has("handshake_hash")) {
      EXPECT_EQ(to_hex(ours->keys.binding), vector["handshake_hash"].text);
    }
    for (std::size_t i = 2; i < messages.size(); ++i) {
      const bool by_initiator = i % 2 == 0;
      expect_transport(by_initiator ? ours->keys.send : theirs->keys.send, i / 2 - 1, messages[i]);
      expect_transport(by_initiator ? theirs->keys.receive : ours->keys.receive, i / 2 - 1,
                       messages[i]);
    }
  }
}

class IkTest : public ::testing::Test {
 protected:
  const Identity client{KeyPair::draw()};
  const Identity server{KeyPair::draw()};
  const Bytes prologue = bytes_of("place");
  IkInitiator initiator{client, server.public_key(), prologue};
  const Bytes first = initiator.write_first(bytes_of("hello")).value();
};

TEST_F(IkTest, AFirstMessageIsForOneKeyAndOnePlace) {
  const Identity other(KeyPair::draw());
  const auto by_other = IkResponder::read_first(other, first, prologue);
  ASSERT_FALSE(by_other);
  EXPECT_EQ(by_other.error(), HandshakeProblem::Forged);
  const auto elsewhere = IkResponder::read_first(server, first, bytes_of("another place"));
  ASSERT_FALSE(elsewhere);
  EXPECT_EQ(elsewhere.error(), HandshakeProblem::Forged);
  EXPECT_TRUE(IkResponder::read_first(server, first, prologue));
}

TEST_F(IkTest, EveryFlippedBitOfTheFirstMessageIsNoticed) {
  for (std::size_t bit = 0; bit < 8 * first.size(); ++bit) {
    Bytes flipped = first;
    flipped[bit / 8] ^= std::byte(1U << bit % 8);
    // X25519 ignores the highest bit of a public key; the hash does not.
    EXPECT_FALSE(IkResponder::read_first(server, flipped, prologue)) << "bit " << bit;
  }
}

TEST_F(IkTest, EveryLengthButItsOwnIsRefused) {
  for (std::size_t size = 0; size < first.size(); ++size) {
    const auto read = IkResponder::read_first(server, ByteView(first).first(size), prologue);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error(), size < IkInitiator::first_overhead ? HandshakeProblem::WrongSize
                                                               : HandshakeProblem::Forged);
  }
  Bytes longer = first;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(IkResponder::read_first(server, longer, prologue));
}

TEST_F(IkTest, AForgedAnswerDoesNotSpoilTheRightOne) {
  const auto answer =
      IkResponder::read_first(server, first, prologue)->write_second(bytes_of("welcome")).value();
  for (std::size_t byte = 0; byte < answer.message.size(); ++byte) {
    Bytes flipped = answer.message;
    flipped[byte] ^= std::byte{0x10};
    EXPECT_FALSE(initiator.read_second(flipped)) << "byte " << byte;
  }
  EXPECT_FALSE(initiator.read_second({}));
  const auto finished = initiator.read_second(answer.message);
  ASSERT_TRUE(finished);
  EXPECT_EQ(to_hex(finished->payload), to_hex(bytes_of("welcome")));
}

TEST_F(IkTest, AnImpostorWithoutTheServersSecretCannotAnswer) {
  IkInitiator other(client, server.public_key(), prologue);
  const Bytes others_first = other.write_first({}).value();
  const auto others_answer =
      IkResponder::read_first(server, others_first, prologue)->write_second({}).value();
  const auto mixed_up = initiator.read_second(others_answer.message);
  ASSERT_FALSE(mixed_up);
  EXPECT_EQ(mixed_up.error(), HandshakeProblem::Forged);
}

TEST_F(IkTest, WeakPublicKeysAreRefusedBeforeAnythingIsDerived) {
  const PublicKey zero{};
  const auto to_weak = IkInitiator(client, zero, prologue).write_first({});
  ASSERT_FALSE(to_weak);
  EXPECT_EQ(to_weak.error(), HandshakeProblem::WeakKey);
  Bytes weak = first;
  std::ranges::fill(std::span(weak).first<key_bytes>(), std::byte{0});
  const auto from_weak = IkResponder::read_first(server, weak, prologue);
  ASSERT_FALSE(from_weak);
  EXPECT_EQ(from_weak.error(), HandshakeProblem::WeakKey);
}

TEST_F(IkTest, OneUsersProgramsMeetWithOneKey) {
  IkInitiator same(server, server.public_key(), prologue);
  const Bytes hello = same.write_first({}).value();
  const auto read = IkResponder::read_first(server, hello, prologue);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->initiator(), server.public_key());
  EXPECT_TRUE(same.read_second(read->write_second({})->message));
}

TEST(PublicKey, IsReadAsItIsWritten) {
  const PublicKey key = KeyPair::draw().public_key;
  EXPECT_EQ(PublicKey::parse(key.to_string()), key);
  EXPECT_EQ(key.to_string().size(), 64U);
  EXPECT_EQ(key.short_name(), key.to_string().substr(0, 8));
  for (const std::string& wrong : {std::string(), key.to_string() + "0", key.to_string().substr(1),
                                   std::string(64, 'g'), std::string(63, '0') + ' '}) {
    EXPECT_FALSE(PublicKey::parse(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace gecos::crypto
