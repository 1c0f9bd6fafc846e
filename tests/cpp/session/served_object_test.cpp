// What a served object does with packets that no client of ours would send, or not so late.
#include "gecos/session/served_object.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "gecos/session/function_code.hpp"
#include "gecos/session/packets.hpp"
#include "gecos/session/reserved_codec.hpp"
#include "probe.hpp"

namespace gecos::session {
namespace {

/// The server's end of a line that loses what the test says.
class TestLink final : public media::Link {
 public:
  explicit TestLink(bool reliable) { offer_.reliable = reliable, offer_.largest_packet = 64 * 1024; }

  const media::Offer& offer() const override { return offer_; }
  const media::Peer& peer() const override { return peer_; }
  tl::expected<std::uint64_t, media::SendProblem> send(ByteView head, ByteView) override {
    if (full) return tl::unexpected(media::SendProblem::Full);
    sent.emplace_back(head.begin(), head.end());
    return sent.size();
  }
  std::optional<ByteView> receive() override { return std::nullopt; }
  std::optional<std::uint64_t> taken_by_peer() override { return std::nullopt; }
  bool arm() override { return true; }
  void disarm() override {}
  std::span<const int> descriptors() const override { return {}; }
  void beat() override {}
  std::uint64_t beats_seen() override { return ++beats_; }
  media::Loss loss() override { return media::Loss::None; }
  std::string loss_text() const override { return {}; }
  tl::expected<void, media::SendProblem> share(std::uint32_t, media::StreamWriter&) override {
    return {};
  }
  void unshare(std::uint32_t) override {}
  std::unique_ptr<media::StreamReader> open_stream(std::uint32_t) override { return nullptr; }

  bool full = false;
  std::vector<Bytes> sent;

 private:
  media::Offer offer_;
  media::Peer peer_;
  std::uint64_t beats_ = 0;
};

class Servant final : public probe::ProbeServant {
 public:
  void gecos_dispatch(IncomingCall call) override {
    if (keep) {
      kept.push_back(std::move(call));
    } else {
      call.finish(result);
    }
  }
  void gecos_session_ended(std::uint64_t) override { ++sessions_ended; }

  bool keep = false;
  Bytes result;
  std::vector<IncomingCall> kept;
  int sessions_ended = 0;
};

class ServedObjects : public ::testing::Test {
 protected:
  explicit ServedObjects(bool reliable = true) {
    auto link = std::make_unique<TestLink>(reliable);
    link_ = link.get();
    session_ = std::make_shared<ServerSession>(std::move(link), object_);
    Hello hello;
    hello.user = "ada";
    hello.interface_name = "probe::Probe";
    wire::PacketHeader header;
    header.kind = wire::PacketKind::Hello;
    take(header, wire::to_bytes(hello));
  }
  ~ServedObjects() override {
    object_->close();
    servant_.kept.clear();
    object_->join();
  }

  void take(wire::PacketHeader header, ByteView body = {}) {
    Bytes packet;
    write_packet(packet, header, body);
    object_->take(session_, packet);
    object_->run_ready(Starter::Poller);
  }
  void packet(wire::PacketKind kind, std::uint64_t counter, FunctionCode code = {},
              ByteView body = {}, Epoch epoch = {}) {
    wire::PacketHeader header;
    header.kind = kind;
    header.session = session_->id();
    header.counter = counter;
    header.code = code;
    header.epoch = epoch;
    header.acknowledged = acknowledged_;
    take(header, body);
  }
  void call(std::uint64_t counter, FunctionCode code, ByteView body = {}, Epoch epoch = {}) {
    packet(wire::PacketKind::Call, counter, code, body, epoch);
  }
  void acquire(std::uint64_t counter) {
    Bytes body(4 + 1);
    wire::Encoder to(body);
    to.put(static_cast<std::int32_t>(Status::ACTOR));
    to.put(false);
    call(counter, FunctionCode{static_cast<std::uint32_t>(Reserved::Acquire)}, body);
  }
  void release(std::uint64_t counter, Epoch epoch) {
    Bytes body(8 + 1);
    wire::Encoder to(body);
    to.put(number(epoch));
    to.put(false);
    call(counter, FunctionCode{static_cast<std::uint32_t>(Reserved::Release)}, body);
  }
  /// Detail of the newest reply to `counter`; nothing while there was none.
  std::optional<Detail> reply_to(std::uint64_t counter) const {
    for (auto at = link_->sent.rbegin(); at != link_->sent.rend(); ++at) {
      const auto packet = wire::decode_packet(*at);
      if (packet->header.kind == wire::PacketKind::Reply && packet->header.counter == counter) {
        return detail_from(static_cast<std::uint8_t>(packet->header.flags));
      }
    }
    return std::nullopt;
  }
  Epoch granted() const {
    Grant grant;
    const auto packet = wire::decode_packet(link_->sent.back());
    wire::Decoder from(packet->body);
    EXPECT_TRUE(wire::get_block(from, grant, "grant"));
    return Epoch{grant.epoch};
  }

  Servant servant_;
  std::shared_ptr<Runtime> runtime_ = Runtime::make({}, system_clock());
  std::shared_ptr<ServedObject> object_ =
      std::make_shared<ServedObject>(runtime_, "PROBE", servant_, ObjectOptions{});
  std::shared_ptr<ServerSession> session_;
  TestLink* link_ = nullptr;
  std::uint64_t acknowledged_ = 0;
};

class OverALossyLine : public ServedObjects {
 protected:
  OverALossyLine() : ServedObjects(false) {}
};

TEST_F(ServedObjects, TakesNothingMoreOfASessionThatHasEnded) {
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done);
  object_->depart(session_, ServedObject::Departure::Lost);
  EXPECT_EQ(servant_.sessions_ended, 1);
  call(2, probe::read_code);
  EXPECT_EQ(reply_to(2), std::nullopt);
  acquire(3);
  EXPECT_EQ(reply_to(3), std::nullopt);
}

TEST_F(ServedObjects, SayThatASessionEndedOnceNoCallOfItIsUnderWay) {
  servant_.keep = true;
  call(1, probe::read_code);
  object_->depart(session_, ServedObject::Departure::Lost);
  EXPECT_EQ(servant_.sessions_ended, 0) << "its handler still uses what belongs to the session";
}

TEST_F(ServedObjects, LetsNobodyEndTheSessionOfAnother) {
  acquire(1);
  const Epoch epoch = granted();
  wire::PacketHeader foreign;
  foreign.kind = wire::PacketKind::Goodbye;
  foreign.session = SessionId{4711};
  take(foreign);
  call(2, probe::set_code, {}, epoch);
  EXPECT_EQ(reply_to(2), Detail::Done);
  EXPECT_FALSE(session_->left);
}

TEST_F(ServedObjects, StopsWhatAnswersLaterToo) {
  acquire(1);
  const Epoch epoch = granted();
  servant_.keep = true;
  call(2, probe::set_code, {}, epoch);
  ASSERT_EQ(servant_.kept.size(), 1u);
  call(3, FunctionCode{static_cast<std::uint32_t>(Reserved::Stop)});
  EXPECT_EQ(reply_to(2), Detail::Stopped);
  EXPECT_TRUE(servant_.kept[0].interrupted());
}

TEST_F(ServedObjects, PartsFromAClientThatAsksAndNeverListens) {
  ASSERT_FALSE(object_->judge_silence(session_));
  link_->full = true;
  bool parted = false;
  for (std::uint64_t counter = 1; counter < 100'000 && !parted; ++counter) {
    call(counter, FunctionCode{static_cast<std::uint32_t>(Reserved::Ping)});
    parted = session_->overrun();
  }
  EXPECT_TRUE(parted);
  EXPECT_TRUE(object_->judge_silence(session_)) << "though it gives signs of life";
}

TEST_F(ServedObjects, PacketsThatCountNoCallAreIgnored) {
  link_->sent.clear();
  for (const auto kind :
       {wire::PacketKind::Query, wire::PacketKind::Cancel, wire::PacketKind::Call}) {
    packet(kind, 0, probe::read_code);
  }
  EXPECT_TRUE(link_->sent.empty());
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(OverALossyLine, PacketsThatCountNoCallAreIgnored) {
  link_->sent.clear();
  for (const auto kind :
       {wire::PacketKind::Query, wire::PacketKind::Cancel, wire::PacketKind::Call}) {
    packet(kind, 0, probe::read_code);
  }
  EXPECT_TRUE(link_->sent.empty());
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(OverALossyLine, ACallWhoseAnswerWasCrowdedOutStillComesToAnEnd) {
  servant_.result.resize(40 * 1024);
  call(1, probe::read_code);
  call(2, probe::read_code);
  link_->sent.clear();  // the first answer was lost
  packet(wire::PacketKind::Query, 1);
  EXPECT_EQ(reply_to(1), Detail::OutcomeUnknown);
  packet(wire::PacketKind::Query, 2);
  EXPECT_EQ(reply_to(2), Detail::Done);
}

TEST_F(OverALossyLine, ALateRepetitionOfWhatWasAcknowledgedIsIgnored) {
  call(1, probe::read_code);
  acknowledged_ = 1;
  call(2, probe::read_code);
  link_->sent.clear();
  call(1, probe::read_code);
  EXPECT_TRUE(link_->sent.empty());
}

TEST_F(OverALossyLine, AReleaseThatOvertakesACommandWaitsForIt) {
  acquire(1);
  const Epoch epoch = granted();
  release(3, epoch);
  EXPECT_EQ(reply_to(3), std::nullopt);
  call(2, probe::set_code, {}, epoch);
  EXPECT_EQ(reply_to(2), Detail::Done) << "what was issued before a release still runs";
  release(3, epoch);
  EXPECT_EQ(reply_to(3), Detail::Done);
}

TEST_F(OverALossyLine, ACommandThatOvertakesAnotherWaitsForIt) {
  acquire(1);
  const Epoch epoch = granted();
  link_->sent.clear();
  call(4, probe::set_code, {}, epoch);
  call(3, probe::set_code, {}, epoch);
  call(3, probe::set_code, {}, epoch);
  packet(wire::PacketKind::Query, 3);
  EXPECT_TRUE(link_->sent.empty()) << "as far as its caller knows it has not arrived";
  call(2, probe::set_code, {}, epoch);
  std::vector<std::uint64_t> answered;
  for (const Bytes& sent : link_->sent) {
    const auto packet = wire::decode_packet(sent);
    if (packet->header.kind == wire::PacketKind::Reply) answered.push_back(packet->header.counter);
  }
  EXPECT_EQ(answered, (std::vector<std::uint64_t>{2, 3, 4}));
}

TEST_F(OverALossyLine, AReadingWaitsForNothing) {
  call(2, probe::read_code);
  EXPECT_EQ(reply_to(2), Detail::Done);
}

TEST_F(OverALossyLine, ACommandThatCameTooEarlyCanBeCanceled) {
  acquire(1);
  const Epoch epoch = granted();
  call(3, probe::set_code, {}, epoch);
  packet(wire::PacketKind::Cancel, 3);
  EXPECT_EQ(reply_to(3), Detail::Canceled);
  servant_.keep = true;
  call(2, probe::set_code, {}, epoch);
  EXPECT_EQ(servant_.kept.size(), 1u) << "the canceled one never starts";
}

TEST_F(OverALossyLine, ACommandThatCameTooEarlyGoesWithItsSession) {
  acquire(1);
  call(3, probe::set_code, {}, granted());
  object_->depart(session_, ServedObject::Departure::Lost);
  EXPECT_EQ(reply_to(3), Detail::Rejected) << "should anybody still hear it";
  EXPECT_TRUE(session_->early.empty());
  EXPECT_EQ(servant_.sessions_ended, 1);
}

}  // namespace
}  // namespace gecos::session
