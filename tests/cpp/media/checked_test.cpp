#include "gecos/media/layers/checked.hpp"

#include <gtest/gtest.h>

#include "gecos/media/inproc/inproc.hpp"
#include "gecos/media/testing/faulty.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

TEST(Crc32c, IsThatOfTheStandards) {
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xe3069283u);
  EXPECT_EQ(crc32c(bytes_of("6789"), crc32c(bytes_of("12345"))), 0xe3069283u) << "in two pieces";
}

TEST(Checked, OfDamagedPacketsNoneArrivesAndOfTheOthersAll) {
  const FakeClock clock;
  const auto medium = make_checked(make_faulty(make_inproc(), {.corruption = 0.5}, clock));
  EXPECT_TRUE(medium->capabilities().intact);
  EXPECT_FALSE(medium->capabilities().reliable);
  const auto acceptor = medium->listen("RX90", false).value();
  End client(std::move(*medium->connect(acceptor->address())));
  End server(acceptor->accept());
  int arrived = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::string text = "packet " + std::to_string(i);
    ASSERT_TRUE(client.send(text));
    while (const auto packet = server.connection->receive()) {
      ++arrived;
      ASSERT_EQ(std::string(reinterpret_cast<const char*>(packet->data()), packet->size()), text);
    }
  }
  EXPECT_NEAR(arrived, 500, 100);
}

TEST(Checked, ThePacketThatIsTooLargeByTheChecksumIsRefused) {
  const auto medium = make_checked(make_inproc());
  const auto acceptor = medium->listen("RX90", false).value();
  End client(std::move(*medium->connect(acceptor->address())));
  const std::size_t largest = medium->capabilities().largest_packet;
  EXPECT_EQ(largest, make_inproc()->capabilities().largest_packet - 4);
  EXPECT_TRUE(client.send(std::string(largest, 'x')));
  EXPECT_EQ(client.send(std::string(largest + 1, 'x')).error(), SendProblem::TooLarge);
}

}  // namespace
}  // namespace gecos::media
