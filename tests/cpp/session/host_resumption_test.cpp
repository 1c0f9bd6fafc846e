// Calls that a client sends again because it lost the session in which it had sent them.
#include "gecos/binding.hpp"
#include "gecos/object_calls.hpp"
#include "gecos/wire/layout.hpp"
#include "object_host_bench.hpp"

namespace gecos::session {
namespace {

/// Over each kind of line.
class SentAgain : public ServedObjects, public ::testing::WithParamInterface<bool> {
 protected:
  SentAgain() : ServedObjects(GetParam()) {}

  /// The client lost its session, and the server noticed.
  SessionId lose() {
    object_->depart(session_, ObjectHost::Departure::Lost);
    return connect()->id();
  }
  Bytes last_body() const {
    const auto packet = wire::decode_packet(connection_->sent.back());
    return Bytes(packet->body.begin(), packet->body.end());
  }
};
INSTANTIATE_TEST_SUITE_P(Over, SentAgain, ::testing::Bool(), [](const auto& made) {
  return std::string(made.param ? "AReliableLine" : "ALossyLine");
});

TEST_P(SentAgain, WhatRunsIsNotStartedTwiceAndToldOfWhereItWasSentLast) {
  servant_.keep = true;
  call(5, probe::look_code);
  const SessionId lost = lose();
  again(1, lost, 5);
  packet(wire::PacketKind::Query, 1);
  const auto told = wire::decode_packet(connection_->sent.back());
  EXPECT_EQ(told->header.kind, wire::PacketKind::Progress);
  EXPECT_EQ(told->header.counter, 1u);
  ASSERT_EQ(servant_.kept.size(), 1u);
  const Bytes result(3, std::byte{7});
  servant_.kept[0].finish(result);
  EXPECT_EQ(reply_to(1), Detail::Done);
  EXPECT_EQ(last_body(), result);
  EXPECT_EQ(servant_.calls, 1);
}

TEST_P(SentAgain, WhatRunsIsFoundAlsoInTheThirdSession) {
  servant_.keep = true;
  call(5, probe::look_code);
  const SessionId first = lose();
  again(1, first, 5);
  const SessionId second = lose();
  again(1, second, 1);
  servant_.kept.at(0).finish({});
  EXPECT_EQ(reply_to(1), Detail::Done);
  EXPECT_EQ(servant_.calls, 1);
}

TEST_P(SentAgain, WhatEndedAfterTheLossIsAnsweredAgain) {
  servant_.keep = true;
  call(1, probe::look_code);
  const SessionId lost = lose();
  servant_.kept.at(0).finish({});
  again(9, lost, 1);
  EXPECT_EQ(reply_to(9), Detail::Done);
  EXPECT_EQ(servant_.calls, 1);
}

TEST_P(SentAgain, WhatNeverCameIsCarriedOut) {
  const SessionId lost = lose();
  again(1, lost, 4);
  EXPECT_EQ(reply_to(1), Detail::Done);
  EXPECT_EQ(servant_.calls, 1);
}

TEST_P(SentAgain, WhatNobodyRemembersIsCarriedOut) {
  again(1, SessionId{4711}, 4);
  EXPECT_EQ(reply_to(1), Detail::Done);
  EXPECT_EQ(servant_.calls, 1);
}

TEST_P(SentAgain, WhatIsNotIdempotentIsACallOfItsOwn) {
  const SessionId lost = lose();
  again(1, lost, 1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_P(SentAgain, WhatDoesNotSayOfWhichItIsRefused) {
  packet(wire::PacketKind::Call, 1, probe::look_code, Bytes(sent_before_size - 1), {}, sent_again);
  EXPECT_EQ(reply_to(1), Detail::BadParameter);
  EXPECT_EQ(servant_.calls, 0);
}

TEST_P(SentAgain, WhatEveryObjectAnswersIsAnsweredToItsArguments) {
  const SessionId lost = lose();
  again(1, lost, 1, GecosObjectInterface::describe.code);
  EXPECT_EQ(reply_to(1), Detail::Done);
  const auto about = layout::from_bytes<GecosObject_describe_result>(last_body());
  ASSERT_TRUE(about) << about.error().message();
  EXPECT_EQ(about->result.name, "PROBE");

  Bytes body(sent_before_size);
  wire::Encoder to(body);
  to.put(number(lost));
  to.put(std::uint64_t{2});
  const GecosObject_outcome_arguments asked{number(process_incarnation()) + 1, number(lost), 1};
  const Bytes arguments = layout::to_bytes(asked);
  body.insert(body.end(), arguments.begin(), arguments.end());
  packet(wire::PacketKind::Call, 2, GecosObjectInterface::outcome.code, body, {}, sent_again);
  EXPECT_EQ(reply_to(2), Detail::Done);
  const auto record = layout::from_bytes<GecosObject_outcome_result>(last_body());
  ASSERT_TRUE(record) << record.error().message();
  EXPECT_NE(record->result.text.find("was restarted"), std::string::npos) << record->result.text;
}

TEST_F(OverALossyLine, WhatEndedBeforeTheLossIsAnsweredAgain) {
  call(1, probe::look_code);
  ASSERT_EQ(servant_.calls, 1);
  object_->depart(session_, ObjectHost::Departure::Lost);
  const auto lost = connect();
  again(1, lost->id(), 1);
  EXPECT_EQ(reply_to(1), Detail::Done);
  EXPECT_EQ(servant_.calls, 1);
}

TEST_F(OverALossyLine, WhatWasSentAgainDoesNotComeInItsFirstSessionAnyMore) {
  const auto first = connect();
  again(1, first->id(), 1);
  ASSERT_EQ(servant_.calls, 1);
  session_ = first;
  call(1, probe::look_code);
  EXPECT_EQ(servant_.calls, 1) << "it was late";
}

/// An object that visitors may only look at.
class SentAgainByAVisitor : public ServedObjects {
 protected:
  SentAgainByAVisitor() {
    const auto visitors = std::make_shared<Visitors>();
    visitors->open = {probe::look_code};
    ObjectOptions options;
    options.visitors = visitors;
    object_->close();
    object_->join();
    object_ = std::make_shared<ObjectHost>(runtime_, "PROBE", servant_, options);
    connect();
  }
  /// The client loses its session, in which it was no visitor, and comes back as one.
  SessionId come_back_as_visitor() {
    object_->depart(session_, ObjectHost::Departure::Lost);
    const SessionId lost = connect()->id();
    session_->visit.open(access::UserAtHost{"ada", "desk"});
    return lost;
  }
};

TEST_F(SentAgainByAVisitor, ACallIsNotAnsweredFromWhatWasSentToNoVisitor) {
  servant_.keep = true;
  call(1, probe::look_code);
  const SessionId lost = come_back_as_visitor();
  servant_.kept.at(0).finish(Bytes(3, std::byte{7}));
  servant_.keep = false;
  again(9, lost, 1);
  EXPECT_EQ(reply_to(9), Detail::Done);
  const auto reply = wire::decode_packet(connection_->sent.back());
  EXPECT_EQ(reply->body.size(), 0u) << "it was carried out anew";
  EXPECT_EQ(servant_.calls, 2);
}

TEST_F(SentAgainByAVisitor, ACallThatRunsForNoVisitorIsNotTakenOver) {
  servant_.keep = true;
  call(1, probe::look_code);
  const SessionId lost = come_back_as_visitor();
  servant_.keep = false;
  again(9, lost, 1);
  EXPECT_NE(reply_to(9), std::nullopt);
  EXPECT_EQ(servant_.calls, 2);
  servant_.kept.at(0).finish({});
}

TEST_F(SentAgainByAVisitor, WhatAVisitorMayNotUseIsRefusedBeforeItIsLookedFor) {
  servant_.keep = true;
  call(1, probe::read_code);
  const SessionId lost = come_back_as_visitor();
  servant_.kept.at(0).finish({});
  again(9, lost, 1, probe::read_code);
  EXPECT_EQ(reply_to(9), Detail::Denied);
  again(10, lost, 1, GecosObjectInterface::stop.code);
  EXPECT_EQ(reply_to(10), Detail::Denied);
  Bytes body(sent_before_size + 4);
  wire::Encoder to(body);
  to.put(number(lost));
  to.put(std::uint64_t{2});
  to.put(number(probe::level_code));
  packet(wire::PacketKind::Call, 11, GecosObjectInterface::subscribe.code, body, {}, sent_again);
  EXPECT_EQ(reply_to(11), Detail::Denied) << "the stream is not open to visitors";
  call(12, GecosObjectInterface::subscribe.code,
       layout::to_bytes(GecosObject_subscribe_arguments{number(probe::level_code)}));
  EXPECT_EQ(reply_to(12), Detail::Denied);
}

}  // namespace
}  // namespace gecos::session
