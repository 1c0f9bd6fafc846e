// What an object does with the calls and sessions of visitors, packet by packet.
#include "gecos/session/server/visitor_calls.hpp"

#include <fstream>

#include "../media/scratch_directory.hpp"
#include "gecos/binding.hpp"
#include "object_host_bench.hpp"

namespace gecos::session {
namespace {

/// An object of which visitors may only use 'look'.
class VisitorCalls : public ServedObjects {
 protected:
  VisitorCalls() {
    const auto visitors = std::make_shared<Visitors>();
    visitors->open = {probe::look_code};
    ObjectOptions options;
    options.visitors = visitors;
    UserRights rights;
    rights.visitor = [this](const auto&, const auto&) { return user_; };
    object_->close();
    object_->join();
    object_ = std::make_shared<ObjectHost>(runtime_, "PROBE", servant_, options, audit_, rights);
    connect();
  }
  /// Ends the object. Returns the lines of its audit that tell of `event`.
  std::vector<std::string> in_audit(const std::string& event) {
    object_->close();
    audit_->end();
    std::ifstream file(folder_.path() + "/audit.jsonl");
    std::vector<std::string> found;
    for (std::string line; std::getline(file, line);) {
      if (line.find("\"event\":\"" + event + "\"") != std::string::npos) found.push_back(line);
    }
    return found;
  }
  std::vector<std::string> commands_in_audit() { return in_audit("command"); }
  /// The number at the end of the last refusal.
  std::string number_told() {
    const std::string text = failure();
    const auto at = text.rfind("(request ") + 9;
    return text.substr(at, text.size() - at - 1);
  }
  ObjectStats stats() {
    user_.reset();
    connect();
    call(1, GecosObjectInterface::stats.code);
    const auto reply = wire::decode_packet(connection_->sent.back());
    const auto stats = layout::from_bytes<GecosObject_stats_result>(reply->body);
    EXPECT_TRUE(stats);
    return stats ? stats->result : ObjectStats{};
  }

  const media::ScratchDirectory folder_;
  const std::shared_ptr<audit::Audit> audit_ =
      std::make_shared<audit::Audit>(audit::Journal(folder_.path()));
  std::optional<access::UserAtHost> user_ = access::UserAtHost{"ada", "desk"};  ///< no value: none
};

std::uint64_t denied_in(const std::vector<OutcomeCount>& outcomes) {
  for (const auto& [detail, calls] : outcomes) {
    if (detail == static_cast<std::uint8_t>(Detail::Denied)) return calls;
  }
  return 0;
}

TEST_F(VisitorCalls, ThatInventOperationsShareALineOfTheAudit) {
  for (std::uint32_t i = 1; i <= 100; ++i) {
    call(i, FunctionCode{0x10000000u + i});
    ASSERT_EQ(reply_to(i), Detail::Denied);
  }
  const auto lines = commands_in_audit();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[0].find("\"operation\":\"unknown operation\""), std::string::npos) << lines[0];
  EXPECT_NE(lines[1].find("\"count\":99"), std::string::npos) << lines[1];
}

TEST_F(VisitorCalls, OfAllOperationsAndSessionsDoNotFillTheAudit) {
  std::vector<FunctionCode> codes{probe::read_code};
  for (const auto* operation : GecosObjectInterface::description.all_operations()) {
    codes.push_back(operation->code);
  }
  constexpr std::size_t sessions = 6;
  for (std::size_t i = 0; i < sessions; ++i) {
    for (std::uint64_t counter = 1; counter <= 3 * codes.size(); ++counter) {
      call(counter, codes[counter % codes.size()]);
    }
    connect();
  }
  const auto lines = commands_in_audit();
  EXPECT_EQ(lines.size(), 2u) << "one in full and one with a count";
  EXPECT_NE(lines.back().find("\"operation\":\"several operations\""), std::string::npos);
}

TEST_F(VisitorCalls, InManySessionsDoNotFillTheAudit) {
  for (int i = 0; i < 100; ++i) {
    connect();
    object_->depart(session_, ObjectHost::Departure::InOrder);
  }
  const auto ends = in_audit("disconnected");
  ASSERT_EQ(ends.size(), 2u) << "one in full and one with a count";
  EXPECT_NE(ends[1].find("\"count\":"), std::string::npos) << ends[1];
  EXPECT_EQ(in_audit("connected").size(), 2u);
}

TEST_F(VisitorCalls, ThatAreRefusedSayWhichListWouldAllowThem) {
  call(1, probe::read_code);
  EXPECT_EQ(
      failure(),
      "'read' of PROBE was not started: user ada of host desk is a visitor here and may "
      "only look for the objects whose programs admit this user; name the user in "
      "[objects.PROBE.allow] of the lab file, together with all other users of PROBE (request " +
          number_told() + ")");
}

TEST_F(VisitorCalls, OfTwoSessionsHaveNumbersThatTheAuditFinds) {
  call(1, probe::read_code);
  const std::string first = number_told();
  connect();
  call(1, probe::read_code);
  const std::string second = number_told();
  connect();
  call(1, probe::read_code);
  const std::string third = number_told();
  EXPECT_NE(first, second);
  const auto lines = commands_in_audit();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[0].find("\"request\":\"" + first + "\""), std::string::npos) << lines[0];
  EXPECT_NE(lines[1].find("\"request\":\"" + second + "\""), std::string::npos) << lines[1];
  EXPECT_NE(lines[1].find("\"last_request\":\"" + third + "\""), std::string::npos) << lines[1];
}

TEST_F(VisitorCalls, ThatAreOnlyCountedAreSaidToBeOfNoProgram) {
  program_ = "lift.py";
  connect();
  for (std::uint64_t i = 1; i <= 3; ++i) call(i, probe::read_code);
  const auto lines = commands_in_audit();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[0].find("\"program\":\"lift.py\""), std::string::npos) << lines[0];
  EXPECT_EQ(lines[1].find("\"program\":"), std::string::npos) << lines[1];
  EXPECT_NE(lines[1].find("\"user\":\"ada\",\"host\":\"desk\""), std::string::npos) << lines[1];
}

TEST_F(VisitorCalls, InSessionsThatEndForSeveralReasonsAddALineOfEachReason) {
  for (const std::string why : {"was revoked", "ended"}) {
    for (int i = 0; i < 3; ++i) {
      object_->depart(session_, ObjectHost::Departure::Lost, why);
      connect();
    }
  }
  const auto ends = in_audit("disconnected");
  const auto have = [&](const std::string& part) {
    return std::ranges::count_if(
        ends, [&](const auto& line) { return line.find(part) != std::string::npos; });
  };
  EXPECT_EQ(have("\"why\":\"was revoked\""), 2) << "the first one, and one that counts the others";
  EXPECT_EQ(have("\"why\":\"ended\""), 2);
  EXPECT_EQ(have("\"count\":2"), 2);
}

TEST_F(VisitorCalls, ThatAreRefusedAreCounted) {
  for (std::uint64_t i = 1; i <= 3; ++i) call(i, probe::read_code);
  call(4, FunctionCode{0x10000001});
  call(5, GecosObjectInterface::stop.code);
  const auto visitor = session_;
  const ObjectStats counted = stats();
  const auto read = std::ranges::find(counted.operations, "read", &OperationStats::operation);
  ASSERT_NE(read, counted.operations.end());
  EXPECT_EQ(denied_in(read->ended), 3u);
  ASSERT_EQ(counted.sessions.size(), 2u);
  EXPECT_EQ(denied_in(counted.sessions[0].ended), 5u);
}

TEST_F(VisitorCalls, TakeAQuarterOfTheQueueAtMost) {
  const auto send = [this](std::uint64_t counter) {  // starts no call
    Bytes bytes;
    write_packet(bytes, header_of(wire::PacketKind::Call, counter, probe::look_code), {});
    object_->take(session_, bytes);
  };
  const auto first = connect();
  user_.reset();
  auto* const of_second = connection_;
  const auto second = connect();
  auto* const of_other = connection_;
  const auto other = session_;
  session_ = first;
  for (std::uint64_t i = 1; i <= 40; ++i) send(i);
  session_ = second;
  connection_ = of_second;
  for (std::uint64_t i = 1; i <= 24; ++i) send(i);
  EXPECT_EQ(reply_to(24), std::nullopt) << "it waits";
  send(25);
  EXPECT_EQ(reply_to(25), Detail::QueueFull);
  EXPECT_EQ(failure(),
            "'look' of PROBE was not queued: 64 calls of visitors are queued already; wait until "
            "one of them has ended");
  session_ = other;
  connection_ = of_other;
  call(1, probe::look_code);
  EXPECT_EQ(reply_to(1), Detail::Done) << "no visitor";
}

class SessionsOfVisitors : public VisitorCalls {
 protected:
  /// Connects until the user has as many sessions as a visitor may have, and returns them.
  std::vector<std::shared_ptr<ServerSession>> connect_all() {
    std::vector<std::shared_ptr<ServerSession>> open{session_};
    while (open.size() < most_sessions_of_visitor) {
      connect();
      EXPECT_TRUE(session_->greeted());
      open.push_back(session_);
    }
    return open;
  }
  std::string refusal() const {
    const auto packet = wire::decode_packet(connection_->sent.back());
    return packet->header.kind == wire::PacketKind::Refused ? failure() : "";
  }
};

TEST_F(SessionsOfVisitors, AreEightOfOneUserAtATime) {
  const auto open = connect_all();
  connect();
  EXPECT_FALSE(session_->greeted());
  EXPECT_EQ(refusal(),
            "PROBE opens no session: user ada of host desk is a visitor here and already has 8 "
            "sessions, which is the maximum; end a program of this user");
  object_->depart(open[3], ObjectHost::Departure::Lost);
  connect();
  EXPECT_TRUE(session_->greeted()) << "one has ended";
}

TEST_F(SessionsOfVisitors, DoNotLimitThoseOfOthers) {
  auto open = connect_all();
  user_ = access::UserAtHost{"ben", "desk"};
  open.push_back(connect());
  EXPECT_TRUE(session_->greeted()) << "another visitor";
  user_.reset();
  open.push_back(connect());
  EXPECT_TRUE(session_->greeted()) << "no visitor";
}

TEST_F(SessionsOfVisitors, CountNoMoreWhenTheLabFileNamesTheUser) {
  const auto open = connect_all();
  open[0]->visit.widen();
  connect();
  EXPECT_TRUE(session_->greeted());
}

TEST_F(VisitorCalls, AreNotToldWhatOthersDo) {
  const auto described = [this](std::uint64_t counter) {
    call(counter, GecosObjectInterface::describe.code);
    const auto reply = wire::decode_packet(connection_->sent.back());
    const auto about = layout::from_bytes<GecosObject_describe_result>(reply->body);
    EXPECT_TRUE(about);
    return about ? about->result : Description{};
  };
  const auto visitor = user_;
  user_.reset();
  connect();
  acquire(1);
  const Epoch epoch = granted();
  servant_.keep = true;
  call(2, probe::set_code, Bytes(4), epoch);
  call(3, probe::set_code, Bytes(4), epoch);
  const Description full = described(4);
  EXPECT_NE(full.epoch, 0u);
  EXPECT_EQ(full.queued, 1u);
  EXPECT_EQ(full.executing, "set");
  EXPECT_EQ(full.handlers.size(), 1u);
  user_ = visitor;
  const auto busy = connect();
  const Description shown = described(1);
  EXPECT_EQ(shown.name, "PROBE");
  EXPECT_EQ(shown.epoch, 0u);
  EXPECT_EQ(shown.queued, 0u);
  EXPECT_EQ(shown.executing, "");
  EXPECT_TRUE(shown.handlers.empty());
}

}  // namespace
}  // namespace gecos::session
