// Channels that a program names in `create`: one for what comes in, one for what goes out.
#include "../settles.hpp"
#include "bench.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::media::Kind;

class Channels : public probe::Bench {
 protected:
  void serve_over(std::vector<Kind> media) {
    gecos::ObjectOptions options;
    options.media = std::move(media);
    const auto added = server_->add("PROBE", servant_, std::move(options));
    ASSERT_TRUE(added) << added.error().text;
  }
  auto create(gecos::CreateOptions channels) {
    channels.patience = 20s;
    return lab_.create<probe::Probe>("PROBE", channels);
  }
  std::string why_not(gecos::CreateOptions channels) {
    const auto created = create(channels);
    return created ? "it was created" : created.error().to_string();
  }
};

std::string_view medium_of(const probe::Probe& robot) {
  return robot.session()->capabilities().name;
}

TEST_F(Channels, CarryCallsOverOneMediumAndSamplesOverTheOther) {
  serve_over({Kind::Shm, Kind::Lcm});
  const auto robot = create({.in = Kind::Lcm, .out = Kind::Shm});
  ASSERT_TRUE(robot) << robot.error();
  EXPECT_EQ(medium_of(*robot), "shm");
  ASSERT_EQ(robot->read().get().value(), 7);
  auto level = robot->level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  const auto received = [&] {
    servant_.publish(5);
    const auto sample = level->latest();
    return sample && sample->value == 5;
  };
  EXPECT_TRUE(settles(received));
  const auto over_shm = create({.medium = Kind::Shm});
  ASSERT_TRUE(over_shm) << over_shm.error();
  lab_.close();
  EXPECT_TRUE(level->lost()) << "the session that brings the samples is closed, too";
}

TEST_F(Channels, WithOneNameLeaveTheOtherDirectionToTheBestMedium) {
  serve_over({Kind::Inproc, Kind::Lcm});
  const auto in = create({.in = Kind::Lcm});
  ASSERT_TRUE(in) << in.error();
  EXPECT_EQ(medium_of(*in), "inproc") << "calls go over the best medium";
  const auto out = create({.out = Kind::Lcm});
  ASSERT_TRUE(out) << out.error();
  EXPECT_EQ(medium_of(*out), "lcm");
}

TEST_F(Channels, ThatAreImpossibleAreRefusedAlthoughOthersExist) {
  serve_over({Kind::Inproc, Kind::Shm});
  EXPECT_EQ(why_not({.in = Kind::Lcm}),
            "PROBE: QOS_UNAVAILABLE: PROBE (in=lcm) cannot be reached over lcm: the server does "
            "not offer this medium; use inproc, shm");
  EXPECT_EQ(why_not({.out = Kind::Lcm}),
            "PROBE: QOS_UNAVAILABLE: PROBE (out=lcm) cannot be reached over lcm: the server does "
            "not offer this medium; use inproc, shm");
  EXPECT_EQ(why_not({.in = Kind::Shm, .out = Kind::Lcm}), why_not({.out = Kind::Lcm}));
  EXPECT_EQ(why_not({.in = Kind::Lcm, .out = Kind::Inproc}), why_not({.in = Kind::Lcm}));
  EXPECT_EQ(why_not({.medium = Kind::Shm, .in = Kind::Lcm}), why_not({.in = Kind::Lcm}));
  EXPECT_EQ(why_not({.in = Kind::Shm, .out = Kind::Inproc}), "it was created");
}

TEST_F(Channels, OfTheirOwnCarryNoStreamThatDemandsAStatus) {
  serve_over({Kind::Inproc, Kind::Shm});
  const auto robot = create({.in = Kind::Shm, .out = Kind::Inproc});
  ASSERT_TRUE(robot) << robot.error();
  const auto refused = robot->session()->subscribe(
      {.code = probe::level_code, .name = "level", .status = gecos::access::Status::Actor});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, gecos::Detail::QosUnavailable);
  EXPECT_EQ(
      refused.error().text,
      "'level' of PROBE was not opened: readers of the stream need a status, but samples would "
      "arrive over the 'in' channel (shm), and only the 'out' channel can have a status; create "
      "the proxy with one medium for both directions");
}

class HardProbe : public probe::Probe {
 public:
  static const gecos::InterfaceDescription& gecos_description() {
    static const gecos::InterfaceDescription described = [] {
      gecos::InterfaceDescription hard = probe::description();
      hard.quality.line = gecos::qos::Class::HardRealtime;
      return hard;
    }();
    return described;
  }
  using Probe::Probe;
};

TEST_F(Channels, MustMeetTheQualityOfTheInterfaceToo) {
  serve_over({Kind::Inproc, Kind::Lcm});
  const auto created = lab_.create<HardProbe>("PROBE", {.in = Kind::Lcm, .patience = 20s});
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error().to_string(),
            "PROBE: QOS_UNAVAILABLE: PROBE (in=lcm) no medium meets the required quality; "
            "class=HARD_REALTIME: the medium lcm shares a queue with other programs and may lose "
            "packets");
}

}  // namespace
