#include <future>
#include <mutex>

#include "../same_bytes.hpp"
#include "gecos/wire/packet.hpp"
#include "over_media.hpp"

namespace {

using gecos::Detail;
using gecos::media::Kind;

/// What is as large as an image goes beside the ring, or in pieces; a session sees none of it.
class LargeBody : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
    servant_.on_read([](gecos::IncomingCall call) {
      const gecos::Bytes echo(call.arguments().begin(), call.arguments().end());
      call.finish(echo);
    });
  }
  std::shared_ptr<gecos::session::CommandCore> echo(const gecos::Bytes& body,
                                                    const gecos::CallOptions& options = {}) {
    return probe_.session()->call(
        probe::operation(probe::read_code), body.size(),
        [&](gecos::wire::Encoder& to) { to.put_bytes(body); }, options);
  }
  static gecos::Bytes body(std::size_t size) {
    gecos::Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 31 >> 3);
    return bytes;
  }
  /// The largest body that the medium carries.
  static std::size_t largest() {
    const std::size_t packet = (GetParam() == Kind::Lcm ? 8 : 32) * 1024 * 1024;
    return packet - gecos::wire::packet_size(0);
  }
  static void expect_same(gecos::session::CommandCore& command, const gecos::Bytes& sent) {
    command.wait_until(gecos::TimePoint::max());
    ASSERT_EQ(command.progress().detail, Detail::Done) << command.failure();
    ASSERT_TRUE(same_bytes(command.result(), sent)) << sent.size();
  }
  probe::Probe probe_;
};
PROBE_OVER_MEDIA(LargeBody);

TEST_P(LargeBody, GoesBothWays) {
  for (const std::size_t size : {std::size_t{8'000}, std::size_t{9'000}, std::size_t{60'000},
                                 std::size_t{2'000'000}, std::size_t{4'000'000}}) {
    const auto sent = body(size);
    expect_same(*echo(sent), sent);
  }
}

TEST_P(LargeBody, SeveralAtOnceAndSmallOnesBesideThem) {
  std::vector<gecos::Bytes> bodies;
  std::vector<std::shared_ptr<gecos::session::CommandCore>> commands;
  for (const std::size_t size : {std::size_t{500'000}, std::size_t{10}, std::size_t{400'000},
                                 std::size_t{20}, std::size_t{300'000}}) {
    bodies.push_back(body(size));
    commands.push_back(echo(bodies.back(), {.deadline = std::chrono::seconds(30)}));
  }
  for (std::size_t i = 0; i < commands.size(); ++i) expect_same(*commands[i], bodies[i]);
}

TEST_P(LargeBody, ThatNoMediumCarriesIsRefusedWithItsSize) {
  const auto command = echo(body(largest() + 1));
  ASSERT_EQ(command->progress().detail, Detail::BadParameter);
  const std::string carries = std::string(gecos::media::to_string(GetParam())) +
                              " carries at most " +
                              std::to_string(largest() + gecos::wire::packet_size(0));
  EXPECT_NE(command->failure().text.find(carries), std::string::npos) << command->failure().text;
}

TEST_P(LargeBody, AsAResultThatNoMediumCarriesIsAFaultThatSaysSo) {
  servant_.on_read([](gecos::IncomingCall call) { call.finish(gecos::Bytes(largest() + 1)); });
  const auto command = echo(body(4));
  command->wait_until(gecos::TimePoint::max());
  ASSERT_EQ(command->progress().detail, Detail::Fault);
  EXPECT_EQ(command->failure().text, "the result takes " + std::to_string(largest() + 1) +
                                         " bytes and the medium carries at most " +
                                         std::to_string(largest() + gecos::wire::packet_size(0)));
}

/// More than a medium holds at a time.
class LargeResults : public LargeBody {};
INSTANTIATE_TEST_SUITE_P(Over, LargeResults, ::testing::Values(Kind::Inproc, Kind::Shm),
                         gecos::media::name_of);

TEST_P(LargeResults, WaitAtTheServerUntilTheirClientTakesThem) {
  static constexpr std::size_t calls = 60;
  struct Open {
    std::mutex mutex;
    std::vector<gecos::IncomingCall> calls;
    std::promise<void> answered;
  };
  const auto image = body(2'000'000);
  const auto open = std::make_shared<Open>();
  servant_.on_read([image, open](gecos::IncomingCall call) {
    const std::lock_guard lock(open->mutex);
    open->calls.push_back(std::move(call));
    if (open->calls.size() < calls) return;
    for (auto& one : open->calls) one.finish(image);
    open->answered.set_value();
  });
  const auto asked = body(4);
  std::vector<std::shared_ptr<gecos::session::CommandCore>> commands;
  for (std::size_t i = 0; i < calls; ++i) commands.push_back(echo(asked));
  ASSERT_EQ(open->answered.get_future().wait_for(std::chrono::seconds(30)),
            std::future_status::ready);
  for (const auto& command : commands) expect_same(*command, image);
}

}  // namespace
