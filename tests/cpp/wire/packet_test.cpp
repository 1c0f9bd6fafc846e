#include "gecos/wire/packet.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "json.hpp"

namespace gecos::wire {
namespace {

using gecos::testing::Json;
using gecos::testing::to_hex;

PacketHeader header_of(const Json& json) {
  PacketHeader header;
  header.version = static_cast<std::int8_t>(json["version"].integer());
  header.kind = static_cast<PacketKind>(json["kind"].integer());
  header.flags = static_cast<std::int8_t>(json["flags"].integer());
  header.code = static_cast<FunctionCode>(json["code"].natural());
  header.session = SessionId{json["session"].natural()};
  header.counter = json["counter"].natural();
  header.acknowledged = json["acknowledged"].natural();
  header.epoch = Epoch{json["epoch"].natural()};
  header.deadline = Duration{json["deadline_ns"].integer()};
  return header;
}

const PacketHeader call{.kind = PacketKind::Call, .code = FunctionCode{5}, .counter = 3};
const Bytes body(5, std::byte{0xBB});
const Bytes tag(16, std::byte{0xAA});

TEST(Packet, AgreesWithTheSharedVectors) {
  const Json vectors = Json::from_vectors("packet.json");
  ASSERT_FALSE(vectors["accepted"].items.empty());
  for (const Json& json : vectors["accepted"].items) {
    const PacketHeader header = header_of(json);
    const Bytes bytes = encode_packet(header, json["body"].bytes(), json["tag"].bytes());
    EXPECT_EQ(to_hex(bytes), json["bytes"].text);
    const auto packet = decode_packet(bytes);
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->header, header);
    EXPECT_EQ(to_hex(packet->body), json["body"].text);
    EXPECT_EQ(to_hex(packet->tag), json["tag"].text);
  }
}

TEST(Packet, CanBeGatheredFromItsPieces) {
  Bytes bytes(packet_size(body.size(), tag.size()));
  const std::span<std::byte> all(bytes);
  encode_packet_head(all.first<packet_head_size>(), call, body.size());
  std::copy(body.begin(), body.end(), all.subspan(packet_head_size).begin());
  const auto rest = all.subspan(packet_head_size + body.size());
  encode_packet_tail(rest.first<packet_tail_size>(), tag.size());
  std::copy(tag.begin(), tag.end(), rest.subspan(packet_tail_size).begin());
  EXPECT_EQ(bytes, encode_packet(call, body, tag));
}

TEST(Packet, BorrowsBodyAndTag) {
  const Bytes bytes = encode_packet(call, body, tag);
  const auto packet = decode_packet(bytes);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->body.data(), bytes.data() + packet_head_size);
  EXPECT_EQ(packet->tag.data() + packet->tag.size(), bytes.data() + bytes.size());
}

TEST(Packet, ANewerPeersVersionAndKindAreHandedOn) {
  PacketHeader header = call;
  header.version = 99;
  header.kind = PacketKind{111};
  const auto packet = decode_packet(encode_packet(header, {}));
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->header, header);
}

TEST(Packet, EveryCutIsRefused) {
  const Bytes bytes = encode_packet(call, body, tag);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto packet = decode_packet(ByteView(bytes).first(size));
    ASSERT_FALSE(packet) << size;
    EXPECT_EQ(packet.error().problem, DecodeProblem::Truncated) << size;
    EXPECT_LE(packet.error().offset, size);
  }
}

TEST(Packet, NamesTheFieldThatIsWrong) {
  const auto refusal = [](auto&& spoil) {
    Bytes bytes = encode_packet(call, body, tag);
    spoil(bytes);
    const auto packet = decode_packet(bytes);
    return packet ? std::string("accepted") : packet.error().message();
  };
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes[0] ^= std::byte{1}; }),
            "at byte 0: a message of another type");
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes.resize(15); }),
            "field 'code' at byte 12: the bytes end before the value does");
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes.resize(55); }),
            "field 'deadline_ns' at byte 48: the bytes end before the value does");
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes.resize(56); }),
            "field 'body_n' at byte 56: the bytes end before the value does");
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes[48] = std::byte{0x80}; }),
            "field 'deadline_ns' at byte 48: outside its declared range");
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes[56] = std::byte{0x80}; }),
            "field 'body_n' at byte 56: the count is negative");
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes[56] = std::byte{0x7F}; }),
            "field 'body_n' at byte 56: the bytes end before the value does");
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes[65] = std::byte{0x7F}; }),
            "field 'tag_n' at byte 65: the bytes end before the value does");
  EXPECT_EQ(refusal([](Bytes& bytes) { bytes.push_back(std::byte{0}); }),
            "at byte 85: bytes are left over");
}

}  // namespace
}  // namespace gecos::wire
