// Channels whose messages anybody reads: LCM's own messages on LCM's own port.
#include <gtest/gtest.h>

#include "gecos/media/inproc/inproc.hpp"
#include "gecos/media/sealed/stream.hpp"
#include "gecos/media/shm/shm.hpp"
#include "lcm_recorder.hpp"

namespace gecos::media {
namespace {

class OpenChannelTest : public testing::Test {
 protected:
  static LcmOptions options(const ScratchDirectory& directory) {
    LcmOptions options = with_keys(directory);
    options.open_port = draw_port();  // not LCM's, where others may send
    return options;
  }
  Bytes heard() {
    recorder_.look();
    const std::array<int, 1> one{recorder_.port().descriptor()};
    while (recorder_.all().empty() && sleep_on(one, too_late()) != Wake::TimedOut) recorder_.look();
    return recorder_.all().empty() ? Bytes{} : recorder_.all().front();
  }

  const ScratchDirectory directory_;
  const LcmOptions options_ = options(directory_);
  const std::unique_ptr<Medium> lcm_ = make_lcm(options_);
  const std::unique_ptr<Acceptor> acceptor_ = lcm_->listen("BARO", false).value();
  Recorder recorder_{options_.open_port, "BARO.readings"};
};

TEST_F(OpenChannelTest, AMessageArrivesAsItWasGiven) {
  const auto channel = acceptor_->open_channel("BARO.readings").value();
  const Bytes message(largest_lcm_packet, std::byte{7});
  ASSERT_TRUE(channel->publish(message));
  EXPECT_TRUE(heard() == message) << "no header, no seal, one datagram";
}

TEST_F(OpenChannelTest, AMessageOfAStrangerCannotBeToldFromOneOfTheServer) {
  const Bytes message(100, std::byte{7});
  Recorder stranger(options_.open_port, "BARO.readings");
  stranger.say("BARO.readings", message);
  EXPECT_TRUE(heard() == message) << "so an open stream is nothing to control by";
}

TEST_F(OpenChannelTest, AMessageThatDoesNotFitInADatagramIsRefused) {
  const auto channel = acceptor_->open_channel("BARO.readings").value();
  const auto sent = channel->publish(Bytes(64 * 1024));
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error(), SendProblem::TooLarge);
  ASSERT_TRUE(channel->publish(Bytes(3)));
  EXPECT_EQ(heard().size(), 3);
}

TEST_F(OpenChannelTest, ANameThatIsTooLongForLcmIsRefused) {
  EXPECT_TRUE(acceptor_->open_channel(std::string(63, 'n')));
  const auto refused = acceptor_->open_channel(std::string(64, 'n'));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text,
            "the name of the channel, " + std::string(64, 'n') +
                ", has 64 bytes; at most 63 are possible: give the object a shorter name");
}

TEST_F(OpenChannelTest, MediaThatNobodyOverhearsHaveNone) {
  const auto shm = make_shm({.directory = directory_.path()});
  const auto inproc = make_inproc();
  for (Medium* const medium : {shm.get(), inproc.get()}) {
    const auto acceptor = medium->listen("BARO", false).value();
    EXPECT_EQ(acceptor->open_channel("BARO.readings").value(), nullptr);
  }
}

}  // namespace
}  // namespace gecos::media
