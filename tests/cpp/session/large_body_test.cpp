#include "over_media.hpp"

namespace {

using gecos::Detail;

/// lcm carries small packets only: what is larger goes in pieces.
class LargeBody : public probe::Bench {
 protected:
  LargeBody() : Bench(gecos::media::Kind::Lcm) {}
  void SetUp() override {
    Bench::SetUp();
    serve("PROBE", servant_);
    probe_ = connect(lab_);
    servant_.on_read([](gecos::IncomingCall call) {
      const gecos::Bytes echo(call.arguments().begin(), call.arguments().end());
      call.finish(echo);
    });
  }
  std::shared_ptr<gecos::session::CommandCore> echo(const gecos::Bytes& body,
                                                    const gecos::CallOptions& options = {}) {
    return probe_.session()->call(probe::operation(probe::read_code), body.size(),
                                  [&](gecos::wire::Encoder& to) { to.put_bytes(body); }, options);
  }
  static gecos::Bytes body(std::size_t size) {
    gecos::Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 31 >> 3);
    return bytes;
  }
  probe::Probe probe_;
};

TEST_F(LargeBody, GoesBothWays) {
  for (const std::size_t size : {std::size_t{8'000}, std::size_t{9'000}, std::size_t{60'000},
                                 std::size_t{1'000'000}, std::size_t{4'000'000}}) {
    const auto sent = body(size);
    const auto command = echo(sent);
    ASSERT_TRUE(command->wait_until(gecos::TimePoint::max()));
    ASSERT_EQ(command->progress().detail, Detail::Done) << command->failure();
    EXPECT_TRUE(std::ranges::equal(command->result(), sent)) << size;
  }
}

TEST_F(LargeBody, SeveralAtOnceAndSmallOnesBesideThem) {
  std::vector<gecos::Bytes> bodies;
  std::vector<std::shared_ptr<gecos::session::CommandCore>> commands;
  for (const std::size_t size : {std::size_t{500'000}, std::size_t{10}, std::size_t{400'000},
                                 std::size_t{20}, std::size_t{300'000}}) {
    bodies.push_back(body(size));
    commands.push_back(echo(bodies.back(), {.deadline = std::chrono::seconds(30)}));
  }
  for (std::size_t i = 0; i < commands.size(); ++i) {
    commands[i]->wait_until(gecos::TimePoint::max());
    ASSERT_EQ(commands[i]->progress().detail, Detail::Done) << commands[i]->failure();
    EXPECT_TRUE(std::ranges::equal(commands[i]->result(), bodies[i])) << i;
  }
}

TEST_F(LargeBody, ThatNoMediumCarriesIsRefusedWithItsSize) {
  const auto command = echo(body(8 * 1024 * 1024));
  ASSERT_EQ(command->progress().detail, Detail::BadParameter);
  EXPECT_NE(command->failure().text.find("lcm carries 8388608"), std::string::npos)
      << command->failure().text;
}

}  // namespace
