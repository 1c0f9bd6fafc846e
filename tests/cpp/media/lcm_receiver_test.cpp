// What we hear is what LCM sends, and LCM hears us.

#include <gtest/gtest.h>
#include <lcm/lcm.h>

#include <fstream>

#include "gecos/media/lcm/port.hpp"
#include "gecos/media/sealed/stream.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

/// LCM itself, on a port of the usual group.
class RealLcm {
 public:
  explicit RealLcm(std::uint16_t port)
      : lcm_(::lcm_create(("udpm://239.255.76.67:" + std::to_string(port) + "?ttl=0").c_str())) {
    if (lcm_ == nullptr) throw std::runtime_error("lcm_create");
  }
  ~RealLcm() { ::lcm_destroy(lcm_); }
  RealLcm(const RealLcm&) = delete;
  RealLcm& operator=(const RealLcm&) = delete;

  void send(const char* channel, std::string_view text) {
    ASSERT_EQ(::lcm_publish(lcm_, channel, text.data(), static_cast<unsigned>(text.size())), 0);
  }
  void listen(const char* channel) { ::lcm_subscribe(lcm_, channel, &RealLcm::arrived, this); }
  std::string receive() {
    heard_.clear();
    constexpr int milliseconds = 20'000;
    EXPECT_GT(::lcm_handle_timeout(lcm_, milliseconds), 0) << "nothing came";
    return heard_;
  }

 private:
  static void arrived(const lcm_recv_buf_t* received, const char* /*channel*/, void* self) {
    static_cast<RealLcm*>(self)->heard_.assign(static_cast<const char*>(received->data),
                                               received->data_size);
  }

  lcm_t* const lcm_;
  std::string heard_;
};

class LcmPortBesideLcm : public testing::Test {
 protected:
  LcmPortBesideLcm() {
    const auto heard = port_->subscribe("OURS", [this](ByteView content) {
      all_.push_back(text_of({content.begin(), content.end()}));
    });
    if (!heard) throw std::runtime_error(heard.error().text);
  }
  const std::vector<std::string>& received_up_to(const std::string& last) {
    while (all_.empty() || all_.back() != last) {
      if (port_->pump()) continue;
      if (!all_.empty() && all_.back() == last) break;
      const std::array<int, 1> one{port_->descriptor()};
      if (sleep_on(one, too_late()) == Wake::TimedOut) {
        ADD_FAILURE() << last << " did not come";
        break;
      }
    }
    return all_;
  }

  const std::uint16_t number_ = draw_port();
  const std::unique_ptr<LcmPort> port_ = LcmPort::open({}, number_).value();
  RealLcm lcm_{number_};
  std::vector<std::string> all_;
};

TEST_F(LcmPortBesideLcm, HearsItsMessagesOnTheChannelThatWasAskedFor) {
  lcm_.send("OTHERS", "not for us");
  lcm_.send("OURSELVES", "nor is this");
  lcm_.send("OURS", "");
  lcm_.send("OURS", "first");
  lcm_.send("OURS", std::string(60'000, 'x'));
  lcm_.send("OURS", "last");
  EXPECT_EQ(received_up_to("last"),
            (std::vector<std::string>{"", "first", std::string(60'000, 'x'), "last"}));
}

TEST_F(LcmPortBesideLcm, HearsNothingOfMessagesThatLcmCuts) {
  lcm_.send("OURS", std::string(200'000, 'x'));
  lcm_.send("OURS", "last");
  EXPECT_EQ(received_up_to("last"), std::vector<std::string>{"last"});
}

TEST_F(LcmPortBesideLcm, IsHeardByIt) {
  lcm_.listen("THEIRS");
  const std::string text = "a sample";
  ASSERT_TRUE(port_->publish("THEIRS", bytes_of(text)));
  EXPECT_EQ(lcm_.receive(), text);
}

TEST(LcmMessage, IsNothingElse) {
  const auto read = [](std::string_view datagram) { return LcmMessage::read(bytes_of(datagram)); };
  using namespace std::string_view_literals;
  const auto good = read("LC02\0\0\0\1CHANNEL\0abc"sv);
  ASSERT_TRUE(good);
  EXPECT_EQ(good->channel, "CHANNEL");
  EXPECT_EQ(good->content.size(), 3u);
  for (const auto wrong : {""sv, "LC02"sv, "LC02\0\0\0\1"sv, "LC02\0\0\0\1CHANNEL"sv,
                           "LC03\0\0\0\1CHANNEL\0abc"sv, "XC02\0\0\0\1CHANNEL\0abc"sv}) {
    EXPECT_FALSE(read(wrong)) << wrong;
  }
}

TEST(LcmReceiver, SaysWhatLetsMoreDatagramsWait) {
  long most = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> most;
  LcmOptions greedy;
  greedy.receive_buffer_bytes = static_cast<int>(most) + 1;
  testing::internal::CaptureStderr();
  const bool opened = LcmReceiver::open(greedy, draw_port()).has_value();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(opened);
  EXPECT_NE(said.find("sysctl -w net.core.rmem_max=" + std::to_string(most + 1)), std::string::npos)
      << said;
}

TEST(LcmReceiver, SaysWhatMendsAMissingRoute) {
  LcmOptions nowhere;
  nowhere.group = "10.0.0.1";
  const auto opened = LcmReceiver::open(nowhere, 20017);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().text.find("cannot receive from 10.0.0.1:20017"), std::string::npos);
  EXPECT_NE(opened.error().text.find("ip route add 10.0.0.1/32 dev lo"), std::string::npos);
}

}  // namespace
}  // namespace gecos::media
