// Feeds DANCER and prints what became of the samples: the C++ half of the pairs in test_inward.py.
#include <cstdio>
#include <functional>
#include <string>
#include <thread>

#include "feeder_client.hpp"
#include "follower.hpp"

namespace {

using namespace std::chrono_literals;
using feeding::in_words;
using feeding::Step;

/// Asks until `holds`, within half a minute: over lcm a sample may be on its way.
void until(const std::function<bool()>& holds) {
  const auto end = std::chrono::steady_clock::now() + 30s;
  while (!holds() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
}

std::string detail_of(const tl::expected<void, gecos::Failure>& sent) {
  return sent ? "SENT" : std::string(to_string(sent.error().detail));
}

}  // namespace

int main(int, char** argv) {
  gecos::LabOptions patient;
  patient.lease_ttl = 20s;
  gecos::Lab lab(patient);
  gecos::CreateOptions over;
  over.medium = gecos::media::kind_from(argv[1]);
  const feeding::Dancer dancer = lab.create<feeding::Dancer>("DANCER", over).value();
  auto speed = dancer.speed(gecos::writer).value();
  auto alter = dancer.alter(gecos::writer).value();
  std::printf("without a lease: %s\n", detail_of(speed.send(1.0)).c_str());
  {
    const auto lease = gecos::actor(dancer);
    for (const double value : {0.5, 1.0, 1.5}) static_cast<void>(speed.send(value));
    std::vector<double> came;
    until([&] {
      const auto values = dancer.speeds().get().value();
      came.insert(came.end(), values.begin(), values.end());
      return came.size() == 3;
    });
    std::printf("speeds:");
    for (const double value : came) std::printf(" %g", value);
    std::printf("\nout of range: %s\n", speed.send(2.5).error().text.c_str());

    const auto follow = dancer.follow();
    until([&] { return follow.feedback().has_value(); });
    alter.feeds(follow);
    for (int i = 1; i <= 4; ++i) {
      static_cast<void>(alter.send(Step{0.025, i}));
      until([&] { return follow.feedback()->count == i; });
    }
    static_cast<void>(alter.send(Step{0, -1}));
    std::printf("moved: %.3f\n", follow.get().value());
    static_cast<void>(alter.send(Step{0.1, 8}));
    until([&] {
      static_cast<void>(dancer.steps().get());
      return alter.report().get()->command_not_running == 1;
    });
    std::printf("alter: %s\n", in_words(alter.report().get().value()).c_str());
    static_cast<void>(speed.send(0.75));
  }
  until([&] {
    static_cast<void>(dancer.speeds().get());
    return speed.report().get()->no_status == 1;
  });
  std::printf("speed: %s\n", in_words(speed.report().get().value()).c_str());
  auto remark = dancer.remark(gecos::writer).value();
  static_cast<void>(remark.send({"good bye"}));
  std::vector<std::string> heard;
  until([&] { return !(heard = dancer.remarks().get().value()).empty(); });
  std::printf("remark: %s\n", heard.at(0).c_str());
}
