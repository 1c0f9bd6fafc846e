// Generated clients and servers against each other, without a session between them.
#include <gtest/gtest.h>

#include <stdexcept>

#include "direct_session.hpp"
#include "everything_client.hpp"
#include "everything_server.hpp"

using namespace everything;
using gecos::Detail;
using gecos::State;

namespace {

class Painter final : public DeepServant {
 public:
  double volume = 2;
  std::int32_t seen_times = -1;

 protected:
  gecos::Result<Colour> paint(Colour what, const std::vector<std::string>& words,
                              std::int32_t times) override {
    seen_times = times;
    if (words.empty()) return tl::unexpected(Refused{"no words", 1.5});
    if (words[0] == "boom") throw std::runtime_error("the can fell over");
    if (words[0] == "bang") throw 7;
    return what;
  }
  gecos::Result<Stage_measure_result> measure(std::int32_t channel, const Grows& state) override {
    if (channel == 0) return tl::unexpected(Refused{"no channel", 1.5});
    Stage_measure_result result;
    result.result = channel * 0.5;
    result.note = "channel";
    result.state = state;
    result.state.first += 1;
    return result;
  }
  gecos::Result<Numbers> all() override { return Numbers{}; }
  gecos::Result<double> level() override { return volume; }
  gecos::Result<void> set_level(double value) override {
    volume = value;
    return {};
  }
  gecos::Result<Sequences> samples() override { return Sequences{}; }
  gecos::Result<void> register_(std::int32_t to, std::int32_t size, std::int32_t call) override {
    seen_times = to + size + call;
    return {};
  }
};

struct GeneratedCalls : testing::Test {
  Painter servant;
  std::shared_ptr<Direct> session = std::make_shared<Direct>(servant);
  Deep stage{session};
};

TEST_F(GeneratedCalls, GiveTheResultOfTheHandler) {
  const auto painted = stage.paint(Colour::BLUE, {"a"}, 5).get();
  ASSERT_TRUE(painted);
  EXPECT_EQ(*painted, Colour::BLUE);
  EXPECT_EQ(servant.seen_times, 5);
  EXPECT_TRUE(stage.register_(1, 2, 3).get());
  EXPECT_EQ(servant.seen_times, 6);
}

TEST_F(GeneratedCalls, GiveAllValuesOfAnOperationThatHasSeveral) {
  Grows state;
  state.first = 41;
  const auto measured = stage.measure(3, state).get();
  ASSERT_TRUE(measured);
  EXPECT_EQ(measured->result, 1.5);
  EXPECT_EQ(measured->note, "channel");
  EXPECT_EQ(measured->state.first, 42);
}

TEST_F(GeneratedCalls, FillInWhatAnOlderCallerLeavesOut) {
  for (const auto& operation : Stage::gecos_description().operations) {
    if (operation.name != "paint") continue;
    const gecos::Bytes older = {{}, {}, {},           std::byte{1},   {}, {}, {}, std::byte{1}, {},
                                {}, {}, std::byte{2}, std::byte{'a'}, {}};
    gecos::Command<Colour> painted(session->send(operation, older),
                                   [](gecos::wire::Decoder& from, Colour& value) {
                                     return decode_enum(from, value, "paint");
                                   });
    ASSERT_TRUE(painted.get()) << painted.get().error();
    EXPECT_EQ(servant.seen_times, 3);  // @default(3)
    return;
  }
  FAIL() << "there is no operation paint";
}

TEST_F(GeneratedCalls, CarryDeclaredExceptionsWithTheirType) {
  const auto painted = stage.paint(Colour::RED, {}).get();
  ASSERT_FALSE(painted);
  EXPECT_EQ(painted.error().detail, Detail::Fault);
  const auto refused = painted.error().as<Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(*refused, (Refused{"no words", 1.5}));
}

TEST_F(GeneratedCalls, TurnWhatAHandlerThrowsIntoAFaultWithItsText) {
  const auto painted = stage.paint(Colour::RED, {"boom"}).get();
  ASSERT_FALSE(painted);
  EXPECT_EQ(painted.error().detail, Detail::Fault);
  EXPECT_EQ(painted.error().text,
            "the handler of 'paint' threw std::runtime_error, which it does not declare: "
            "the can fell over; the handler must catch the exception and return a gecos::Fault");
}

TEST_F(GeneratedCalls, NameAnExceptionThatOnlyAnotherOperationDeclares) {
  const auto measured = stage.measure(0, {}).get();
  ASSERT_FALSE(measured);
  EXPECT_EQ(measured.error().detail, Detail::Fault);
  EXPECT_FALSE(measured.error().as<Refused>());
  EXPECT_EQ(measured.error().text.find("the handler of 'measure' raised "), 0u);
  EXPECT_NE(measured.error().text.find("Refused, which it does not declare: "), std::string::npos)
      << measured.error();
}

TEST_F(GeneratedCalls, TurnWhatIsNoExceptionOfTheStandardLibraryIntoAFaultToo) {
  const auto painted = stage.paint(Colour::RED, {"bang"}).get();
  ASSERT_FALSE(painted);
  EXPECT_EQ(painted.error().detail, Detail::Fault);
  EXPECT_EQ(painted.error().text,
            "the handler of 'paint' threw int, which it does not declare; the handler must catch "
            "the exception and return a gecos::Fault");
  EXPECT_TRUE(stage.paint(Colour::RED, {"a"}).get()) << "and the next call is carried out";
}

TEST_F(GeneratedCalls, RefuseBadParametersBeforeAnythingIsSent) {
  const auto far = stage.paint(Colour::RED, {"a"}, 10).get();
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().detail, Detail::BadParameter);
  EXPECT_EQ(far.error().text, "paint.times: 10 is outside [0, 9]; give at most 9");
  EXPECT_EQ(stage.set_level(6).get().error().text,
            "level.value: 6 is outside [0.0, 5.0]; give at most 5.0");
  EXPECT_EQ(stage.paint(Colour::RED, {"abcde"}).wait(), State::CommandFailed);
  EXPECT_EQ(session->sent, 0);
}

TEST_F(GeneratedCalls, RefuseBadParametersAgainWhereTheyArrive) {
  for (const auto& operation : Stage::gecos_description().operations) {
    if (operation.name != "level=") continue;
    gecos::Bytes six(8);
    gecos::wire::Encoder(std::span(six)).put(6.0);
    const gecos::Command<void> set(session->send(operation, six));
    EXPECT_EQ(set.get().error().detail, Detail::BadParameter);
    EXPECT_NE(set.get().error().text.find("level.value"), std::string::npos);
    EXPECT_EQ(servant.volume, 2);
    return;
  }
  FAIL() << "there is no setter of level";
}

TEST_F(GeneratedCalls, DoNotPassOnAResultThatTheInterfaceForbids) {
  servant.volume = 99;
  const auto level = stage.level().get();
  ASSERT_FALSE(level);
  EXPECT_EQ(level.error().detail, Detail::Fault);
  EXPECT_NE(level.error().text.find("level: 99 is outside [0.0, 5.0]; give at most 5.0"),
            std::string::npos);
}

TEST_F(GeneratedCalls, AnswerAnOperationThatTheyLack) {
  gecos::OperationDescription unknown;
  unknown.code = gecos::FunctionCode{1};
  const gecos::Command<void> command(session->send(unknown, {}));
  EXPECT_EQ(command.get().error().detail, Detail::UnknownOperation);
}

TEST_F(GeneratedCalls, FailOnANilProxy) {
  EXPECT_EQ(Deep().level().wait(), State::ConnectionFailed);
}

TEST(GeneratedDescriptions, NameEachOperationAndStream) {
  EXPECT_EQ(StageInterface::paint.name, "paint");
  EXPECT_EQ(StageInterface::set_level.kind, gecos::OperationKind::Setter);
  EXPECT_EQ(StageInterface::samples_stream.code, StageInterface::samples.code);
  EXPECT_TRUE(StageInterface::all.idempotent) << "a getter may be sent again";
  EXPECT_FALSE(StageInterface::all.presence);
  EXPECT_TRUE(StageInterface::paint.presence);
}

TEST(GeneratedDescriptions, AreSortedByCodeAndHoldWhatIsInherited) {
  const auto& deep = Deep::gecos_description();
  EXPECT_TRUE(deep.is_a("everything::Stage"));
  ASSERT_EQ(deep.operations.size(), 1u) << "what is inherited is not stated again";
  EXPECT_EQ(deep.inherits[0], &Stage::gecos_description());
  const auto all = deep.all_operations();
  ASSERT_EQ(all.size(), Stage::gecos_description().operations.size() + 1);
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_LT(gecos::number(all[i - 1]->code), gecos::number(all[i]->code));
    EXPECT_EQ(deep.find(all[i]->code), all[i]);
  }
  const auto streams = deep.all_streams();
  ASSERT_EQ(streams.size(), 1u);
  EXPECT_EQ(streams[0]->rate_hz, 10);
  EXPECT_EQ(deep.find_stream(streams[0]->code), streams[0]);
  EXPECT_EQ(deep.find(streams[0]->code)->kind, gecos::OperationKind::Getter);
}

}  // namespace
