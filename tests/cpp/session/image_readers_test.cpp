// Readers of one stream of images in processes of their own: some read on, one dies with a sample
// that it was lent, one stands still for a while.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <list>
#include <sstream>
#include <thread>

#include "../generated/idle_camera.hpp"
#include "../media/kind_names.hpp"
#include "child.hpp"
#include "gecos/gecos.hpp"
#include "images/camera_client.hpp"
#include "place.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::media::Kind;
using images::Image;

constexpr std::uint16_t last_picture = 400;
constexpr std::size_t octets = 50'000;

class Camera final : public images::IdleCamera {
 public:
  /// Returns where the octets of the picture were written; nullptr if it was not lent or sent.
  const std::uint8_t* show(std::uint16_t number) {
    auto loan = lend_picture({.width = number}, octets);
    if (!loan) return nullptr;
    std::ranges::fill(loan.octets(), static_cast<std::uint8_t>(number));
    const std::uint8_t* const written = loan.octets().data();
    return loan.publish() ? written : nullptr;
  }
};

/// Returns how often this thread has let go of its core to wait for something.
long times_waited() {
  rusage used{};
  EXPECT_EQ(::getrusage(RUSAGE_THREAD, &used), 0);
  return used.ru_nvcsw;
}

/// Returns which file has the memory at `address`, and at which offset.
std::string place_in_file(const void* address) {
  const auto wanted = reinterpret_cast<std::uintptr_t>(address);
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t begin = 0, end = 0, offset = 0, inode = 0;
    char dash = 0;
    std::string rights, device;
    std::istringstream words(line);
    words >> std::hex >> begin >> dash >> end >> rights >> offset >> device >> std::dec >> inode;
    if (wanted < begin || wanted >= end) continue;
    return std::to_string(inode) + "+" + std::to_string(offset + wanted - begin);
  }
  return "nowhere";
}

struct Connected {
  gecos::Lab lab;
  std::optional<gecos::Stream<Image>> pictures;
};

/// Subscribes once it hears "go", and says "ready".
std::unique_ptr<Connected> subscribe(probe::Child::Line& line, Kind kind) {
  line.hear();
  auto connected = std::make_unique<Connected>();
  const auto camera = connected->lab.create<images::Camera>("CAMERA", {.medium = kind}).value();
  connected->pictures = camera.picture(gecos::stream).value();
  line.say("ready");
  return connected;
}

/// Reads all pictures to the last one. Says where that one lay, or what was wrong.
void read_all(probe::Child::Line& line, Kind kind) {
  const auto connected = subscribe(line, kind);
  std::uint64_t seen = 0;
  for (;;) {
    const auto sample = connected->pictures->next_in_place(20s);
    if (!sample) return line.say("ended: " + std::string(to_string(sample.error())));
    const std::uint16_t number = sample->value.width;
    const bool whole = std::ranges::all_of(
        sample->octets, [&](std::uint8_t octet) { return octet == std::uint8_t(number); });
    if (!whole && sample->intact()) return line.say("picture " + std::to_string(number) + " torn");
    // Before the first sample nothing counts as lost.
    seen = seen == 0 ? sample->sequence : seen + 1 + sample->lost;
    if (seen != sample->sequence) {
      return line.say("picture " + std::to_string(number) + " is number " +
                      std::to_string(sample->sequence) + " after " + std::to_string(seen));
    }
    if (number == last_picture) return line.say(place_in_file(sample->octets.data()));
  }
}

/// Says "keeps" while it keeps its first picture.
void keep_one(probe::Child::Line& line, Kind kind) {
  const auto connected = subscribe(line, kind);
  const auto sample = connected->pictures->next_in_place(20s);
  line.say(sample ? "keeps" : "got none");
  line.hear();
}

class ImageReaders : public ::testing::TestWithParam<Kind> {
 protected:
  probe::Place place_;
  std::list<probe::Child> reading_;
  probe::Child dying_{[](probe::Child::Line& line) { keep_one(line, GetParam()); }};
};
INSTANTIATE_TEST_SUITE_P(Over, ImageReaders, ::testing::Values(Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

TEST_P(ImageReaders, InOtherProcessesShareOneMemoryAndNeverDelayTheWriter) {
  for (int reader = 0; reader < 3; ++reader) {
    reading_.emplace_back([](probe::Child::Line& line) { read_all(line, GetParam()); });
  }
  probe::Child& frozen = reading_.back();
  const probe::BrokerHere broker;
  gecos::Lab lab;
  Camera camera;
  gecos::Server server(lab);
  const auto added = server.add("CAMERA", camera, {.simulated = true, .media = {GetParam()}});
  ASSERT_TRUE(added) << added.error().text;
  for (auto* child : {&dying_, &reading_.front(), &*std::next(reading_.begin()), &frozen}) {
    child->line().say("go");
    ASSERT_EQ(child->line().hear(), "ready");
  }

  std::uint16_t number = 1;
  ASSERT_NE(camera.show(number), nullptr);
  ASSERT_EQ(dying_.line().hear(), "keeps");
  dying_.kill_at_once();
  frozen.signal(SIGSTOP);
  const long before = times_waited();
  while (++number < last_picture) ASSERT_NE(camera.show(number), nullptr) << number;
  if (GetParam() == Kind::Shm) {
    EXPECT_EQ(times_waited(), before) << "the writer has waited for a reader";
  }
  frozen.signal(SIGCONT);
  const std::uint8_t* const written = camera.show(last_picture);
  ASSERT_NE(written, nullptr);
  std::jthread again;
  if (GetParam() == Kind::Lcm) {  // which may lose each sample, the last one too
    again = std::jthread([&](const std::stop_token& enough) {
      for (; !enough.stop_requested(); std::this_thread::sleep_for(10ms)) camera.show(last_picture);
    });
  }
  for (auto& reader : reading_) {
    const std::string said = reader.line().hear();
    if (GetParam() == Kind::Shm) {
      EXPECT_EQ(said, place_in_file(written));
    } else {
      EXPECT_TRUE(said.starts_with("0+")) << said << " is no private memory";
    }
    EXPECT_EQ(reader.wait(), 0);
  }
}

}  // namespace
