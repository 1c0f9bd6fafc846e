// Samples whose octets are written and read in place: tests/idl/images shows pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <sstream>

#include "../media/kind_names.hpp"
#include "../robcl/allocations.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"
#include "idle_camera.hpp"
#include "images/camera_client.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::media::Kind;
using images::Image;

using Camera = images::IdleCamera;

class Images : public ::testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(broker_.serve(broker_server_, {Kind::Inproc}));
    gecos::ObjectOptions served;
    served.simulated = true;
    served.media = {GetParam()};
    const auto added = server_->add("CAMERA", camera_, std::move(served));
    ASSERT_TRUE(added) << added.error().text;
    auto created = lab_->create<images::Camera>("CAMERA");
    ASSERT_TRUE(created) << created.error();
    proxy_ = *created;
  }
  gecos::Stream<Image> pictures() {
    auto opened = proxy_.picture(gecos::stream);
    EXPECT_TRUE(opened) << opened.error();
    return *std::move(opened);
  }
  /// Publishes a picture whose octets begin with `first`, and returns where they were written.
  std::uint8_t* publish(std::uint8_t first, std::size_t octets = 12) {
    auto loan = camera_.lend_picture({.width = first, .height = 3, .encoding = "mono8"}, octets);
    EXPECT_TRUE(loan);
    if (!loan) return nullptr;
    std::iota(loan.octets().begin(), loan.octets().end(), first);
    std::uint8_t* const written = loan.octets().data();
    EXPECT_TRUE(loan.publish());
    return written;
  }
  bool shares_memory() const { return GetParam() != Kind::Lcm; }
  gecos::StreamStats stats() const {
    const auto told = gecos::stats(proxy_).get();
    EXPECT_TRUE(told) << told.error();
    for (const auto& each : told->streams) {
      if (each.stream == "picture") return each;
    }
    return {};
  }

  gecos::Lab broker_lab_;
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  Camera camera_;
  gecos::Lab server_lab_;
  std::unique_ptr<gecos::Server> server_ = std::make_unique<gecos::Server>(server_lab_);
  std::unique_ptr<gecos::Lab> lab_ = std::make_unique<gecos::Lab>();
  images::Camera proxy_;
};
INSTANTIATE_TEST_SUITE_P(Over, Images, ::testing::Values(Kind::Inproc, Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

/// Returns the line of /proc/self/maps with `address`, and the offset of `address` in its mapping.
std::pair<std::string, std::size_t> mapping_of(const void* address) {
  const auto wanted = reinterpret_cast<std::uintptr_t>(address);
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t begin = 0, end = 0;
    char dash = 0;
    std::istringstream(line) >> std::hex >> begin >> dash >> end;
    if (begin <= wanted && wanted < end) return {line, wanted - begin};
  }
  return {};
}

TEST_P(Images, AreReadWhereTheyWereWritten) {
  auto stream = pictures();
  std::uint8_t* const written = publish(5);
  const auto sample = stream.next_in_place(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, (Image{.width = 5, .height = 3, .encoding = "mono8"}));
  ASSERT_EQ(sample->octets.size(), 12U);
  EXPECT_EQ(sample->octets[11], 16);
  EXPECT_TRUE(sample->intact());
  if (!shares_memory()) return;
  // A write into the memory of the loan, which a servant may not do after publish(), is seen by the
  // reader: nothing was copied.
  written[7] = 99;
  EXPECT_EQ(sample->octets[7], 99);
  if (GetParam() == Kind::Inproc) {
    EXPECT_EQ(sample->octets.data(), written);
    return;
  }
  const auto [readers, place] = mapping_of(sample->octets.data());
  const auto [writers, same_place] = mapping_of(written);
  EXPECT_NE(readers.find("memfd:gecos stream"), std::string::npos) << readers;
  EXPECT_NE(readers.find("r--s"), std::string::npos) << readers;
  EXPECT_NE(writers.find("rw-s"), std::string::npos) << writers;
  EXPECT_EQ(place, same_place);
}

TEST_P(Images, AreOrdinarySamplesToAReaderThatCopies) {
  auto stream = pictures();
  publish(1);
  const auto copied = stream.next(10s);
  ASSERT_TRUE(copied) << to_string(copied.error());
  EXPECT_EQ(copied->value.pixels.size(), 12U);
  EXPECT_EQ(copied->value.pixels[11], 12);
  EXPECT_EQ(copied->value.encoding, "mono8");
  Image whole{.width = 7, .pixels = {1, 2, 3}, .mask = {4}};
  camera_.publish_picture(whole);
  const auto sample = stream.next_in_place(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->sequence, 2U);
  EXPECT_EQ(sample->lost, 0U);
  EXPECT_TRUE(std::ranges::equal(sample->octets, whole.pixels));
  whole.pixels.clear();
  EXPECT_EQ(sample->value, whole) << "other octets are copied";
  EXPECT_GE(sample->age, 0s);
}

TEST_P(Images, AreReadInPlaceAndByCopiesInTurn) {
  auto stream = pictures();
  EXPECT_FALSE(stream.latest_in_place());
  publish(1);
  ASSERT_TRUE(stream.next_in_place(10s));
  EXPECT_EQ(stream.latest()->value.pixels.at(0), 1) << "again, as a copy";
  EXPECT_EQ(stream.latest_in_place()->octets[0], 1);
  EXPECT_EQ(stream.latest()->value.pixels.at(11), 12);
  publish(2);
  EXPECT_EQ(stream.next(10s)->value.pixels.at(0), 2);
  publish(3);
  publish(4);
  const auto third = stream.next_in_place(10s);
  ASSERT_TRUE(third) << to_string(third.error());
  EXPECT_EQ(third->octets[0], 3);
  const auto fourth = stream.next_in_place(10s);
  ASSERT_TRUE(fourth) << to_string(fourth.error());
  EXPECT_EQ(fourth->octets[0], 4);
  EXPECT_EQ(third->octets[0], 3) << "a reader may hold several";
  EXPECT_EQ(stream.counts().received, 4U) << "each counted once";
  EXPECT_EQ(stream.next_in_place(0s).error(), gecos::StreamEnd::Nothing);
}

TEST_P(Images, ThatAreOverwrittenAreNotIntactAndStayReadable) {
  auto stream = pictures();
  publish(1);
  auto held = stream.next_in_place(10s);
  ASSERT_TRUE(held) << to_string(held.error());
  for (std::uint8_t first = 2; first <= 4; ++first) publish(first);
  EXPECT_TRUE(held->intact()) << "as many samples as the depth";
  publish(5);
  EXPECT_EQ(held->intact(), !shares_memory()) << "the writer waits for no reader";
  const auto next = stream.next_in_place(10s);
  ASSERT_TRUE(next) << to_string(next.error());
  EXPECT_EQ(next->octets[0], 3);
  EXPECT_EQ(next->lost, 1U);
  auto copy = *next;
  stream = pictures();
  proxy_ = {};
  lab_->close();
  server_.reset();
  EXPECT_EQ(copy.octets[11], 14) << "the memory lives as long as the sample";
  EXPECT_TRUE(copy.intact());
}

TEST_P(Images, AreKeptForAReaderThatComesLater) {
  publish(1);
  auto first = pictures();
  EXPECT_EQ(first.next_in_place(10s)->octets[0], 1) << "written before there was a reader";
  publish(2);
  auto later = pictures();
  EXPECT_EQ(later.next_in_place(10s)->octets[0], 2);
}

TEST_P(Images, AreNotSentWithoutPublish) {
  auto stream = pictures();
  {
    auto dropped = camera_.lend_picture({}, 5);
    ASSERT_TRUE(dropped);
    EXPECT_FALSE(camera_.lend_picture({}, 5)) << "a second loan";
    camera_.publish_picture({.width = 8});
    auto moved = std::move(dropped);
    EXPECT_FALSE(dropped.publish());  // NOLINT(bugprone-use-after-move)
    EXPECT_EQ(moved.octets().size(), 5U);
  }
  EXPECT_EQ(stats().dropped, 1U) << "the sample that was published meanwhile";
  publish(3);
  const auto sample = stream.next_in_place(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->octets[0], 3);
  EXPECT_EQ(sample->sequence, 1U);
  EXPECT_EQ(stats().samples, 1U);
}

TEST_P(Images, MayHaveNoOctetsOrAllThatFit) {
  auto stream = pictures();
  ASSERT_TRUE(camera_.lend_picture({}, 0).publish());
  auto sample = stream.next_in_place(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_TRUE(sample->octets.empty());
  publish(1, 50'000);
  sample = stream.next_in_place(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  ASSERT_EQ(sample->octets.size(), 50'000U);
  EXPECT_EQ(sample->octets.back(), static_cast<std::uint8_t>(50'000));
}

TEST_P(Images, ThatDoNotFitAreRefused) {
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(camera_.lend_picture({}, 50'001));
  EXPECT_FALSE(camera_.lend_picture({.pixels = {1}}, 10));
  EXPECT_FALSE(camera_.lend_picture({.encoding = "a text that is too long"}, 10));
  EXPECT_FALSE(camera_.lend_raw({}, 100'000)) << "no bound: 64 KiB";
  const std::string log = ::testing::internal::GetCapturedStderr();
  for (const char* const part :
       {"picture: 50001 octets, at most 50000 fit", "leave it empty and write them into the loan",
        "Image.encoding: 23 bytes, at most 16 fit",
        "the sample takes 100005 bytes, at most 65536 fit; declare bounds for its "
        "sequences and strings"}) {
    EXPECT_NE(log.find(part), std::string::npos) << part << "\n" << log;
  }
  EXPECT_TRUE(camera_.lend_picture({}, 10)) << "a refused loan has ended";
}

// Needs a process of its own, as ctest gives it: the limit counts the lines of a stream in a
// process.
TEST_P(Images, ThatDoNotFitFillNoLog) {
  ::testing::internal::CaptureStderr();
  for (int time = 0; time < 1000; ++time) EXPECT_FALSE(camera_.lend_picture({}, 50'001));
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_LT(std::ranges::count(log, '\n'), 100);
}

TEST_P(Images, OfASequenceWithoutABoundAreReadOverEachMedium) {
  auto opened = proxy_.raw(gecos::stream);
  ASSERT_TRUE(opened) << opened.error();
  auto loan = camera_.lend_raw({.last = true}, 100);
  ASSERT_TRUE(loan);
  loan.octets().front() = loan.octets().back() = 7;
  ASSERT_TRUE(loan.publish());
  const auto read = opened->next_in_place(10s);
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_EQ(read->octets.size(), 100u);
  EXPECT_EQ(read->octets.back(), 7);
  EXPECT_TRUE(read->value.last);
}

TEST_P(Images, OfAFullScreenComeOverSharedMemoryAndAreRefusedOverLcm) {
  auto opened = proxy_.still(gecos::stream);
  if (!shares_memory()) {
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().text.find(
                  "stream 'still' of CAMERA has samples of up to 6220808 bytes, and lcm carries at "
                  "most "),
              std::string::npos)
        << opened.error();
    EXPECT_NE(opened.error().text.find("read it on the host of its server, or reduce the bound"),
              std::string::npos)
        << opened.error();
    return;
  }
  ASSERT_TRUE(opened) << opened.error();
  for (std::uint32_t number = 1; number <= 40; ++number) {
    auto loan = camera_.lend_still({.number = number}, 6'220'800);
    ASSERT_TRUE(loan);
    loan.octets().front() = loan.octets().back() = static_cast<std::uint8_t>(number);
    ASSERT_TRUE(loan.publish());
    const auto sample = opened->next_in_place(10s);
    ASSERT_TRUE(sample) << to_string(sample.error());
    EXPECT_EQ(sample->value.number, number);
    ASSERT_EQ(sample->octets.size(), 6'220'800U);
    EXPECT_EQ(sample->octets.front(), number);
    EXPECT_EQ(sample->octets.back(), number);
  }
}

TEST_P(Images, OfALoanThatOutlivesItsServerGoNowhere) {
  auto stream = pictures();
  auto loan = camera_.lend_picture({}, 10);
  server_.reset();
  std::ranges::fill(loan.octets(), std::uint8_t{1});
  EXPECT_FALSE(loan.publish());
  EXPECT_FALSE(camera_.lend_picture({}, 10)) << "nobody serves the camera";
}

TEST_P(Images, CostNoAllocation) {
  auto opened = proxy_.scan(gecos::stream);
  ASSERT_TRUE(opened) << opened.error();
  const auto exchange = [&] {
    auto loan = camera_.lend_scan({}, 60'000);
    ASSERT_TRUE(loan);
    loan.octets().front() = 1;
    ASSERT_TRUE(loan.publish());
    if (!shares_memory()) return;
    ASSERT_TRUE(opened->next_in_place(10s));
  };
  exchange();
  const robcl::CountAllocations count;
  exchange();
  if (shares_memory()) {
    EXPECT_EQ(count.so_far(), 0);
  }
}

TEST(ImagesOverTwoMedia, HaveOneNumberAndOneContent) {
  gecos::Lab broker_lab;
  gecos::broker::Broker broker;
  gecos::Server broker_server(broker_lab);
  ASSERT_TRUE(broker.serve(broker_server, {Kind::Inproc}));
  Camera camera;
  gecos::Lab server_lab;
  gecos::Server server(server_lab);
  gecos::ObjectOptions served;
  served.simulated = true;
  served.media = {Kind::Inproc, Kind::Shm};
  ASSERT_TRUE(server.add("CAMERA", camera, std::move(served)));
  gecos::Lab lab;
  std::vector<gecos::Stream<Image>> streams;
  std::vector<images::Camera> proxies;
  for (const Kind kind : {Kind::Shm, Kind::Inproc}) {
    auto loan = camera.lend_picture({.width = 1}, 4);
    ASSERT_TRUE(loan);
    std::ranges::fill(loan.octets(), std::uint8_t{7});
    ASSERT_TRUE(loan.publish());
    gecos::CreateOptions options;
    options.medium = kind;
    auto created = lab.create<images::Camera>("CAMERA", options);
    ASSERT_TRUE(created) << created.error();
    auto opened = created->picture(gecos::stream);
    ASSERT_TRUE(opened) << opened.error();
    proxies.push_back(*created);
    streams.push_back(*std::move(opened));
  }
  auto loan = camera.lend_picture({.width = 2}, 4);
  ASSERT_TRUE(loan);
  std::ranges::fill(loan.octets(), std::uint8_t{9});
  ASSERT_TRUE(loan.publish());
  std::vector<std::uint64_t> numbers;
  for (auto& stream : streams) {
    auto sample = stream.next_in_place(10s);
    ASSERT_TRUE(sample) << to_string(sample.error());
    EXPECT_EQ(sample->octets[3], 7) << "kept for the reader that came later";
    while (sample->octets[3] != 9) {
      sample = stream.next_in_place(10s);
      ASSERT_TRUE(sample) << to_string(sample.error());
    }
    EXPECT_EQ(sample->value.width, 2);
    numbers.push_back(sample->sequence);
  }
  EXPECT_EQ(numbers[0], numbers[1]);
}

}  // namespace
