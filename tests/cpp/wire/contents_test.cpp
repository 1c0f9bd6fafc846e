#include "gecos/wire/contents.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace gecos::wire {
namespace {

/// Like what `gidl gen` writes, in small; a tree, so that it can be too deep.
struct Node {
  std::string name;
  std::vector<Node> children;

  std::size_t encoded_size() const {
    std::size_t size = string_size(name) + 4;
    for (const Node& child : children) size += child.encoded_size();
    return size;
  }

  void encode(Encoder& to) const {
    to.put_string(name);
    to.put_count(children.size());
    for (const Node& child : children) child.encode(to);
  }

  bool decode(Decoder& from) {
    const DepthGuard deeper(from, "children");
    std::size_t count = 0;
    if (!deeper || !from.get_string(name, 16, "name") ||
        !from.get_count(count, 9, npos, "children")) {
      return false;
    }
    children.resize(count);
    for (Node& child : children) {
      if (!child.decode(from)) return false;
    }
    return true;
  }

  static std::int64_t fingerprint() { return 0x1122334455667788; }

  friend bool operator==(const Node&, const Node&) = default;
};

static_assert(GeneralContents<Node>);
static_assert(!GeneralContents<int>);

Node chain(int levels) {
  Node node{"leaf", {}};
  for (int i = 1; i < levels; ++i) node = Node{"n", {node}};
  return node;
}

TEST(Contents, ComeBackFromTheirBytes) {
  const Node tree{"root", {Node{"left", {}}, Node{"right", {Node{"leaf", {}}}}}};
  EXPECT_EQ(to_bytes(tree).size(), tree.encoded_size());
  EXPECT_EQ(from_bytes<Node>(to_bytes(tree)), tree);
  EXPECT_EQ(from_message<Node>(to_message(tree)), tree);
}

TEST(Contents, AMessageStartsWithTheFingerprint) {
  const Bytes message = to_message(Node{});
  EXPECT_EQ(load_big_endian<std::int64_t>(message.data()), Node::fingerprint());
  EXPECT_EQ(Bytes(message.begin() + 8, message.end()), to_bytes(Node{}));
}

TEST(Contents, AMessageOfAnotherTypeIsRefused) {
  Bytes message = to_message(Node{});
  message[7] ^= std::byte{1};
  const auto result = from_message<Node>(message);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(), (DecodeError{DecodeProblem::WrongFingerprint, 0, ""}));
}

TEST(Contents, EveryCutIsRefused) {
  const Bytes bytes = to_bytes(chain(3));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto result = from_bytes<Node>(ByteView(bytes).first(size));
    ASSERT_FALSE(result) << size;
    EXPECT_EQ(result.error().problem, DecodeProblem::Truncated) << size;
    EXPECT_FALSE(from_message<Node>(ByteView(to_message(chain(3))).first(size))) << size;
  }
}

TEST(Contents, BytesLeftOverAreRefused) {
  Bytes bytes = to_bytes(Node{});
  bytes.push_back(std::byte{0});
  const auto result = from_bytes<Node>(bytes);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(), (DecodeError{DecodeProblem::TrailingBytes, 9, ""}));
}

// Under the sanitizers this also shows that nothing outside the bytes is read.
TEST(Contents, MutatedBytesAreRefusedOrTheEncodingOfWhatWasRead) {
  std::mt19937 random(1994);
  const auto below = [&random](std::size_t limit) {
    return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random);
  };
  const Bytes original = to_bytes(Node{"root", {Node{"left", {}}, chain(4)}});
  int refused = 0;
  for (int round = 0; round < 20'000; ++round) {
    Bytes bytes = original;
    bytes[below(bytes.size())] = static_cast<std::byte>(below(256));
    bytes[below(bytes.size())] ^= static_cast<std::byte>(1u << below(8));
    if (below(4) == 0) bytes.resize(below(bytes.size() + 8));
    const auto result = from_bytes<Node>(bytes);
    if (result) {
      ASSERT_EQ(to_bytes(*result), bytes);
    } else {
      ++refused;
      ASSERT_LE(result.error().offset, bytes.size());
    }
  }
  EXPECT_GT(refused, 1'000);
  EXPECT_LT(refused, 20'000);
}

TEST(Contents, SixteenLevelsPassAndSeventeenAreRefused) {
  EXPECT_TRUE(from_bytes<Node>(to_bytes(chain(16))));
  const auto result = from_bytes<Node>(to_bytes(chain(17)));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().problem, DecodeProblem::TooDeep);
}

}  // namespace
}  // namespace gecos::wire
