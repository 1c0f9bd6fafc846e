// Round trips of the media beside their limits: media_benchmark [rounds]

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <vector>

#include "benchmarks/limits.hpp"
#include "gecos/media/lcm.hpp"
#include "gecos/media/shm/shm.hpp"
#include "gecos/media/waiting.hpp"

namespace gecos::benchmarks {
namespace {

using media::Link;

/// Waits as a session does: spins by policy, then sleeps. Nothing once the link is lost.
std::optional<ByteView> await_packet(Link& link, media::SpinPolicy& spin, media::Acceptor* door) {
  spin.begin();
  for (;;) {
    if (const auto packet = link.receive()) return packet;
    if (spin.again()) continue;
    if (link.arm()) {
      std::vector<int> all(link.descriptors().begin(), link.descriptors().end());
      if (door != nullptr) {
        all.insert(all.end(), door->descriptors().begin(), door->descriptors().end());
      }
      media::sleep_on(all, TimePoint::max());
      link.disarm();
    }
    if (link.loss() != media::Loss::None) return std::nullopt;
    spin.begin();
  }
}

class MediumPair final : public PingPong {
 public:
  using Make = std::function<std::unique_ptr<media::Medium>()>;

  MediumPair(Cores cores, const Make& make, media::SpinOptions spin)
      : spin_(clock_, spin) {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) throw std::runtime_error("pipe");
    server_ = std::make_unique<Answering>(cores, [&] {
      const auto medium = make();
      const auto door = medium->listen("BENCHMARK", false).value();
      const std::string& address = door->address();
      if (::write(ends[1], address.c_str(), address.size() + 1) < 0) return;
      std::unique_ptr<Link> link;
      while ((link = door->accept()) == nullptr) {
        media::sleep_on(door->descriptors(), TimePoint::max());
      }
      media::SpinPolicy serving(clock_, spin);
      for (;;) {
        const auto packet = await_packet(*link, serving, door.get());
        if (!packet || !link->send(*packet, {})) return;
      }
    });
    std::array<char, 512> address{};
    const ssize_t size = ::read(ends[0], address.data(), address.size() - 1);
    ::close(ends[0]);
    ::close(ends[1]);
    if (size <= 0) throw std::runtime_error("the server of the benchmark did not start");
    medium_ = make();
    link_ = medium_->connect(address.data()).value();
  }

  void call() override {
    if (!link_->send(ByteView(packet_).first(48), ByteView(packet_).subspan(48))) {
      throw std::runtime_error("send: " + link_->loss_text());
    }
    if (!await_packet(*link_, spin_, nullptr)) {
      throw std::runtime_error("no answer: " + link_->loss_text());
    }
  }

 private:
  const SystemClock clock_;
  media::SpinPolicy spin_;
  std::array<std::byte, 64> packet_{};
  std::unique_ptr<Answering> server_;
  std::unique_ptr<media::Medium> medium_;
  std::unique_ptr<Link> link_;
};

void run(int rounds) {
  const std::string directory =
      std::filesystem::temp_directory_path() / ("gecos-benchmark-" + std::to_string(::getpid()));
  const MediumPair::Make shm = [&] { return media::make_shm({.directory = directory}); };
  const MediumPair::Make lcm = [] { return media::make_lcm(); };
  const auto over = [](Cores cores, const MediumPair::Make& make, media::SpinOptions spin = {}) {
    return [=] { return std::make_unique<MediumPair>(cores, make, spin); };
  };
  const auto raw = [](Cores cores, auto start) { return [=] { return start(cores); }; };
  const media::SpinOptions asleep{.longest = Duration::zero()};
  constexpr int many = 100'000;
  constexpr int few = 5'000;

  pin_client();
  print_table("two cores, spinning",
              paired_rounds({{"raw spinning ring", raw(Cores::Two, raw_spinning_ring)},
                             {"raw yielding ring", raw(Cores::Two, raw_yielding_ring)},
                             {"shm", over(Cores::Two, shm)}},
                            rounds, many));
  print_table("one core, spinning",
              paired_rounds({{"raw yielding ring", raw(Cores::One, raw_yielding_ring)},
                             {"shm", over(Cores::One, shm)}},
                            rounds, few));
  for (const Cores cores : {Cores::Two, Cores::One}) {
    print_table(cores == Cores::Two ? "two cores, asleep" : "one core, asleep",
                paired_rounds({{"Unix socket", raw(cores, raw_unix_socket)},
                               {"shm without spinning", over(cores, shm, asleep)},
                               {"raw LCM", raw(cores, raw_lcm)},
                               {"lcm", over(cores, lcm, asleep)}},
                              rounds, few));
  }
  const BusyNeighbours busy;
  print_table("two cores, each with a busy program",
              paired_rounds({{"Unix socket", raw(Cores::Two, raw_unix_socket)},
                             {"shm", over(Cores::Two, shm)},
                             {"raw LCM", raw(Cores::Two, raw_lcm)},
                             {"lcm", over(Cores::Two, lcm, asleep)}},
                            rounds, few / 5));
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace gecos::benchmarks

int main(int argc, char** argv) {
  gecos::benchmarks::run(argc > 1 ? std::max(1, std::atoi(argv[1])) : 5);
}
