// Large packets over lines that lose, repeat and reorder what they are cut into.

#include "gecos/media/layers/fragments.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <random>
#include <thread>
#include <utility>

#include "gecos/media/kinds.hpp"
#include "gecos/media/layers/layer.hpp"
#include "gecos/media/layers/transfer.hpp"
#include "gecos/media/lcm/lcm.hpp"
#include "gecos/media/testing/faulty.hpp"
#include "media_under_test.hpp"
#include "pair_medium.hpp"

namespace gecos::media {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t piece_bytes = largest_lcm_piece;

Bytes random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

/// One transfer by a fake clock. `lose` says which sending does not arrive.
struct Result {
  Bytes arrived;
  std::size_t sendings = 0;
};
Result transfer(const Bytes& packet, const std::function<bool(std::size_t sending)>& lose) {
  OutgoingTransfer out(1, packet, piece_bytes);
  IncomingTransfers in(piece_bytes);
  Result result;
  TimePoint now{};
  for (int turn = 0; !out.complete() && turn < 100'000; ++turn) {
    std::vector<Received> answers;
    out.advance(now, [&](const Piece& piece) {
      if (lose(++result.sendings)) return;
      answers.push_back(in.take(piece));
      if (auto whole = in.whole()) result.arrived = std::move(*whole);
    });
    for (const Received& answer : answers) out.take(answer, now);
    now += 1ms;
  }
  EXPECT_TRUE(out.complete());
  return result;
}

TEST(Transfer, SendsEachPieceOnceWhereNothingIsLost) {
  for (const std::size_t size :
       {std::size_t{1}, piece_bytes, piece_bytes + 1, 100 * piece_bytes - 1}) {
    const Bytes packet = random_bytes(size, 1);
    const Result result = transfer(packet, [](std::size_t) { return false; });
    EXPECT_EQ(result.arrived, packet);
    EXPECT_EQ(result.sendings, (size + piece_bytes - 1) / piece_bytes);
  }
}

TEST(Transfer, SendsAgainOnlyWhatWasLost) {
  const Bytes packet = random_bytes(50 * piece_bytes, 2);
  const Result result =
      transfer(packet, [](std::size_t sending) { return sending == 3 || sending == 20; });
  EXPECT_EQ(result.arrived, packet);
  EXPECT_EQ(result.sendings, 52u);
}

TEST(Transfer, EndsWhereThePiecesUnderWayAreAllLost) {
  const Bytes packet = random_bytes(20 * piece_bytes, 3);
  const Result result =
      transfer(packet, [](std::size_t sending) { return sending <= OutgoingTransfer::window; });
  EXPECT_EQ(result.arrived, packet);
  EXPECT_EQ(result.sendings, 20 + OutgoingTransfer::window);
}

TEST(Transfer, IsWholeOnceWhateverIsRepeated) {
  IncomingTransfers in(piece_bytes);
  const Bytes packet = random_bytes(piece_bytes + 10, 4);
  const Piece first{1, static_cast<std::uint32_t>(packet.size()), 0,
                    ByteView(packet).first(piece_bytes)};
  const Piece last{1, static_cast<std::uint32_t>(packet.size()), 1,
                   ByteView(packet).subspan(piece_bytes)};
  EXPECT_EQ(in.take(last).all_before, 0u);
  EXPECT_EQ(in.take(last).beyond, 1u);
  EXPECT_FALSE(in.whole());
  EXPECT_EQ(in.take(first).all_before, 2u);
  EXPECT_EQ(in.whole(), packet);
  for (const Piece& again : {first, last}) {
    EXPECT_EQ(in.take(again).all_before, 2u) << "its answer was lost";
    EXPECT_FALSE(in.whole());
  }
  const Piece next{2, 4, 0, ByteView(packet).first(4)};
  EXPECT_EQ(in.take(next).all_before, 1u);
  EXPECT_TRUE(in.whole());
  EXPECT_EQ(in.take(first).all_before, 2u) << "of the packet before";
  EXPECT_FALSE(in.whole());
}

TEST(Transfer, PiecesThatContradictThemselvesAreNone) {
  const Bytes content(piece_bytes);
  const auto read = [&](const Piece& piece) {
    Bytes packet(Piece::head_bytes);
    piece.write_head(std::span(packet).first<Piece::head_bytes>());
    packet.insert(packet.end(), piece.content.begin(), piece.content.end());
    return Piece::read(packet, piece_bytes).has_value();
  };
  const ByteView all(content);
  const auto two = static_cast<std::uint32_t>(piece_bytes + 5);
  EXPECT_TRUE(read({1, two, 0, all}));
  EXPECT_TRUE(read({1, two, 1, all.first(5)}));
  EXPECT_FALSE(read({0, two, 0, all})) << "no number";
  EXPECT_FALSE(read({1, two, 2, all.first(5)})) << "beyond the end";
  EXPECT_FALSE(read({1, two, 1, all.first(6)})) << "longer than what is left";
  EXPECT_FALSE(read({1, two, 0, all.first(5)})) << "shorter than a piece";
  EXPECT_FALSE(read({1, 0, 0, {}})) << "of nothing";
  EXPECT_FALSE(read({1, static_cast<std::uint32_t>(largest_transfer + 1), 0, all})) << "too large";
  EXPECT_FALSE(Piece::read(all, piece_bytes));
  EXPECT_FALSE(Received::read(all.first(Received::bytes)));
}

TEST(Transfer, BelievesNoAnswerBeyondWhatItSends) {
  OutgoingTransfer out(1, Bytes(2 * piece_bytes), piece_bytes);
  out.advance(TimePoint{}, [](const Piece&) {});
  out.take({1, 3, 0}, TimePoint{});
  out.take({2, 2, 0}, TimePoint{});
  EXPECT_FALSE(out.complete());
  out.take({1, 0, ~std::uint32_t{0}}, TimePoint{});
  EXPECT_FALSE(out.complete());
  out.take({1, 2, 0}, TimePoint{});
  EXPECT_TRUE(out.complete());
}

/// Client and server over a medium with the layers that its capabilities ask for, and beats as
/// maintenance gives them.
class Fragmented : public testing::Test {
 protected:
  explicit Fragmented(std::unique_ptr<Medium> medium)
      : medium_(with_layers(std::move(medium), clock_)),
        acceptor_(medium_->listen("CAMERA", false).value()),
        client_(std::move(*medium_->connect(acceptor_->address()))),
        server_(wait_for_client(*acceptor_, *client_)) {}

  /// Both ends look once at what has come; gives what came for `to`.
  std::optional<Bytes> look(const Connection* to) {
    std::optional<Bytes> found;
    acceptor_->accept();
    for (Connection* connection : {client_.get(), server_.get()}) {
      const auto packet = connection->receive();
      if (packet && connection == to) found.emplace(packet->begin(), packet->end());
    }
    const TimePoint now = std::chrono::steady_clock::now();
    if (now < next_beat_) return found;
    next_beat_ = now + 10ms;
    client_->beat();
    server_->beat();
    return found;
  }
  Bytes arrived_at(const Connection& to) {
    const TimePoint end = too_late();
    while (std::chrono::steady_clock::now() < end) {
      if (auto packet = look(&to)) return std::move(*packet);
    }
    ADD_FAILURE() << "it did not arrive";
    return {};
  }
  /// As soon as the one before has arrived as a whole.
  void send_when_free(Connection& from, const Bytes& packet) {
    const TimePoint end = too_late();
    while (!from.send(packet, {})) {
      look(nullptr);
      if (std::chrono::steady_clock::now() > end) return ADD_FAILURE() << "still full";
    }
  }

  const SystemClock clock_;
  const std::unique_ptr<Medium> medium_;
  const std::unique_ptr<Acceptor> acceptor_;
  const std::unique_ptr<Connection> client_;
  const std::unique_ptr<Connection> server_;
  TimePoint next_beat_{};
};

/// Where the keys of a test are, before the medium that reads them.
struct WithKeys {
  std::string keys() const { return directory.path() + "/keys"; }
  const ScratchDirectory directory;
};

/// Over lcm, with a line between them that suffers.
class InPieces : public WithKeys, public Fragmented {
 protected:
  InPieces() : Fragmented(make_faulty(make_lcm(options()), line(), real_clock())) {}

  static const Clock& real_clock() {
    static const SystemClock clock;
    return clock;
  }
  static Faults line() {
    Faults faults;
    faults.loss = 0.1;
    faults.duplication = 0.1;
    faults.reordering = 0.3;
    return faults;
  }
  LcmOptions options() const {
    LcmOptions options;
    options.key_directory = keys();
    return options;
  }
};

TEST_F(InPieces, WhatArrivedAndIsSentAgainArrivesAgain) {
  const Bytes packet = random_bytes(50'000, 7);
  const TimePoint end = too_late();
  for (int time = 0; time < 3; ++time) {
    std::optional<Bytes> arrived;
    while (!arrived && std::chrono::steady_clock::now() < end) {
      client_->send(packet,
                    {});  // as a session does that has no answer: its peer took it for too old, say
      arrived = look(server_.get());
    }
    EXPECT_EQ(arrived, packet);
  }
}

TEST_F(InPieces, LargePacketsArriveThoughEveryTenthPieceIsLost) {
  EXPECT_EQ(medium_->capabilities().largest_packet, largest_transfer);
  for (unsigned i = 1; i <= 3; ++i) {
    const Bytes packet = random_bytes(1'000'000 + i, i);
    send_when_free(*client_, packet);
    EXPECT_EQ(arrived_at(*server_), packet);
    send_when_free(*server_, packet);
    EXPECT_EQ(arrived_at(*client_), packet);
  }
}

TEST_F(InPieces, OneIsUnderWayAndNotSentTwice) {
  const Bytes one = random_bytes(300'000, 1);
  const Bytes other = random_bytes(300'000, 2);
  ASSERT_TRUE(client_->send(one, {}));
  EXPECT_EQ(client_->send(other, {}).error(), SendProblem::Full);
  EXPECT_TRUE(client_->send(ByteView(one).first(100), ByteView(one).subspan(100)))
      << "it is under way";
  EXPECT_EQ(arrived_at(*server_), one);
  send_when_free(*client_, other);
  EXPECT_EQ(arrived_at(*server_), other) << "and not the first again";
  EXPECT_EQ(client_->send(Bytes(largest_transfer + 1), {}).error(), SendProblem::TooLarge);
}

/// Over 200-byte datagrams.
class InSmallPieces : public Fragmented {
 protected:
  using Fragmented::Fragmented;
  void expect_large_packets() {
    EXPECT_EQ(medium_->capabilities().largest_packet, largest_transfer);
    const Bytes packet = random_bytes(100'001, 1);
    send_when_free(*client_, packet);
    EXPECT_EQ(arrived_at(*server_), packet);
    send_when_free(*server_, packet);
    EXPECT_EQ(arrived_at(*client_), packet);
  }
};

class OverAPair : public InSmallPieces {
 protected:
  OverAPair() : InSmallPieces(make_pair_medium()) {}
};
TEST_F(OverAPair, LargePacketsArrive) { expect_large_packets(); }

class OverASealedPair : public WithKeys, public InSmallPieces {
 protected:
  OverASealedPair() : InSmallPieces(make_sealed_pair(keys())) {}
};
TEST_F(OverASealedPair, LargePacketsArrive) { expect_large_packets(); }

struct Counts {
  std::atomic<int> sends{0};
  std::atomic<int> overlaps{0};  // calls that begin before another one has returned
};

/// Counts calls of send(), share() and unshare(), which a connection allows one thread at a time.
class OneSender final : public ConnectionLayer {
 public:
  OneSender(std::unique_ptr<Connection> inner, const Capabilities& capabilities, Counts& counts)
      : ConnectionLayer(std::move(inner), capabilities), counts_(counts) {}

  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    const Turn turn(*this);
    ++counts_.sends;
    std::this_thread::yield();
    return inner().send(head, body);
  }
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override {
    const Turn turn(*this);
    return inner().share(id, stream);
  }
  void unshare(std::uint32_t id) override {
    const Turn turn(*this);
    inner().unshare(id);
  }

 private:
  struct Turn {
    explicit Turn(OneSender& of) : sender(of) {
      if (sender.running_.exchange(true)) ++sender.counts_.overlaps;
    }
    ~Turn() { sender.running_.store(false); }
    OneSender& sender;
  };
  Counts& counts_;
  std::atomic<bool> running_{false};
};

struct WithCounts {
  Counts counts;
};

/// Over a pair, where the client's line counts.
class OverOneSender : public WithCounts, public Fragmented {
 protected:
  OverOneSender()
      : Fragmented(make_layer(
            make_pair_medium(), pair_capabilities,
            [this](std::unique_ptr<Connection> connection, const Capabilities& capabilities,
                   Role role) -> std::unique_ptr<Connection> {
              if (role == Role::Server) return connection;
              return std::make_unique<OneSender>(std::move(connection), capabilities, counts);
            })) {}
};

TEST_F(OverOneSender, AStreamIsSharedWhileNoOtherThreadSends) {
  std::atomic<bool> done{false};
  std::thread sharing([&] {
    const auto stream = client_->make_stream(8, 2);
    for (int seen = 0; !done; std::this_thread::yield()) {
      const int sends = counts.sends;
      if (std::exchange(seen, sends) == sends) continue;
      EXPECT_TRUE(client_->share(1, *stream));
      client_->unshare(1);
    }
  });
  const Bytes packet = random_bytes(20'000, 1);
  send_when_free(*server_, packet);
  EXPECT_EQ(arrived_at(*client_), packet) << "the receiving thread has acknowledged each piece";
  done = true;
  sharing.join();
  EXPECT_GT(counts.sends, 100);
  EXPECT_EQ(counts.overlaps, 0);
}

}  // namespace
}  // namespace gecos::media
