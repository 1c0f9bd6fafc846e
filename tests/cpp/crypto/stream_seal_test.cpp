#include "gecos/crypto/stream_seal.hpp"

#include <gtest/gtest.h>

#include "channel_pair.hpp"

namespace gecos::crypto {
namespace {

using gecos::testing::bytes_of;
using gecos::testing::text_of;

Bytes sample(StreamSealer& sealer, std::string_view text, ByteView associated = {}) {
  Bytes frame(StreamSealer::overhead + text.size());
  std::ranges::copy(bytes_of(text), frame.begin() + StreamSealer::text_at);
  sealer.seal(associated, frame);
  return frame;
}

std::string opened(StreamOpener& opener, Bytes frame, ByteView associated = {}) {
  const auto text = opener.open(associated, frame);
  return text ? text_of(*text) : "refused: " + std::string(to_string(text.error()));
}

/// As it arrives in a reader's own channel.
StreamKey passed_on(const StreamSealer& sealer) {
  std::array<std::byte, StreamKey::bytes> bytes;
  sealer.key().write(bytes);
  return StreamKey::read(bytes);
}

TEST(StreamSeal, OneFrameIsReadByAll) {
  StreamSealer writer;
  StreamOpener one(passed_on(writer));
  StreamOpener other(passed_on(writer));
  const Bytes frame = sample(writer, "pose");
  EXPECT_EQ(frame.size(), 4 + StreamSealer::overhead);
  EXPECT_EQ(opened(one, frame), "pose");
  EXPECT_EQ(opened(one, frame), "refused: the packet was delivered already");
  EXPECT_EQ(opened(other, frame), "pose");
  EXPECT_EQ(opened(one, sample(writer, "")), "");
}

TEST(StreamSeal, WhoComesLateReadsOnFromThere) {
  StreamSealer writer;
  for (int i = 0; i < 5000; ++i) sample(writer, "before");
  StreamOpener late(passed_on(writer));
  EXPECT_EQ(opened(late, sample(writer, "now")), "now");
}

TEST(StreamSeal, AReaderCannotForgeASampleToTheOthers) {
  StreamSealer writer;
  StreamOpener honest(passed_on(writer));
  const Bytes real = sample(writer, "true!");
  const StreamKey stolen = passed_on(writer);  // all that a reader has

  // It opens the sample, changes it, and seals it again under the key that it rightly has.
  Bytes forged = real;
  const auto inside =
      std::span(forged).subspan(StreamSealer::text_at, forged.size() - Sealer::overhead);
  const auto tag = std::span(forged).last<tag_bytes>();
  ASSERT_TRUE(aead_open(stolen.key, 0, {}, inside, tag));
  ASSERT_EQ(text_of(inside.first(5)), "true!");
  inside[0] = std::byte{'T'};
  aead_seal(stolen.key, 0, {}, inside, tag);
  EXPECT_EQ(opened(honest, forged), "refused: the packet is not from the peer, or it was altered");

  // The right words under a later counter are another sample, and signed by nobody.
  Bytes moved = real;
  const auto moved_inside =
      std::span(moved).subspan(StreamSealer::text_at, moved.size() - Sealer::overhead);
  ASSERT_TRUE(aead_open(stolen.key, 0, {}, moved_inside, std::span(moved).last<tag_bytes>()));
  moved[7] = std::byte{9};
  aead_seal(stolen.key, 9, {}, moved_inside, std::span(moved).last<tag_bytes>());
  EXPECT_EQ(opened(honest, moved), "refused: the packet is not from the peer, or it was altered");
  EXPECT_EQ(opened(honest, real), "true!");
}

TEST(StreamSeal, WhoHasNoKeyCanNeitherReadNorWrite) {
  StreamSealer writer;
  StreamSealer another;
  StreamOpener reader(passed_on(writer));
  StreamOpener revoked(passed_on(another));
  const Bytes frame = sample(writer, "secret sample");
  EXPECT_EQ(text_of(frame).find("secret"), std::string::npos);
  EXPECT_EQ(opened(revoked, frame), "refused: the packet is not from the peer, or it was altered");
  EXPECT_EQ(opened(reader, sample(another, "x")),
            "refused: the packet is not from the peer, or it was altered");
}

TEST(StreamSeal, EveryChangedByteAndEveryLengthIsNoticed) {
  StreamSealer writer;
  StreamOpener reader(passed_on(writer));
  const Bytes header = bytes_of("stream 7");
  const Bytes frame = sample(writer, "pose", header);
  for (std::size_t byte = 0; byte < frame.size(); ++byte) {
    Bytes changed = frame;
    changed[byte] ^= std::byte{0x80};
    ASSERT_NE(opened(reader, changed, header), "pose") << byte;
    const Bytes shorter(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(byte));
    ASSERT_NE(opened(reader, shorter, header), "pose") << byte;
  }
  EXPECT_EQ(opened(reader, frame, bytes_of("stream 8")),
            "refused: the packet is not from the peer, or it was altered");
  EXPECT_EQ(opened(reader, frame, header), "pose");
  Bytes last_counter(StreamSealer::overhead, std::byte{0xff});
  EXPECT_EQ(opened(reader, last_counter),
            "refused: the packet is sealed under a key that the peer cannot use yet");
}

}  // namespace
}  // namespace gecos::crypto
