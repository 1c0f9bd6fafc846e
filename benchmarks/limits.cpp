#include "benchmarks/limits.hpp"

#include <lcm/lcm.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <new>
#include <stdexcept>
#include <thread>

namespace gecos::benchmarks {
namespace {

using Packet = std::array<char, 64>;

void pin(unsigned core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(core % std::max(1u, std::thread::hardware_concurrency()), &set);
  ::sched_setaffinity(0, sizeof set, &set);
}

/// Slots with a sequence number each, as small as a ring can be.
struct Ring {
  struct alignas(64) Slot {
    std::atomic<std::uint64_t> sequence{0};
    Packet packet{};
  };
  std::array<Slot, 64> slots;

  void put(std::uint64_t number, const Packet& packet) {
    Slot& slot = slots[number % slots.size()];
    slot.packet = packet;
    slot.sequence.store(number, std::memory_order_release);
  }
  template <class Wait>
  void get(std::uint64_t number, Packet& packet, Wait wait) {
    Slot& slot = slots[number % slots.size()];
    while (slot.sequence.load(std::memory_order_acquire) != number) wait();
    packet = slot.packet;
  }
};

struct TwoRings {
  Ring there;
  Ring back;
};

template <auto wait>
class RingPair final : public PingPong {
 public:
  explicit RingPair(Cores cores)
      : rings_(new(map()) TwoRings), server_(cores, [this] {
          Packet packet;
          for (std::uint64_t i = 1;; ++i) {
            rings_->there.get(i, packet, wait);
            rings_->back.put(i, packet);
          }
        }) {}
  ~RingPair() override { ::munmap(rings_, sizeof *rings_); }
  void call() override {
    rings_->there.put(++number_, packet_);
    rings_->back.get(number_, packet_, wait);
  }

 private:
  static void* map() {
    void* at = ::mmap(nullptr, sizeof(TwoRings), PROT_READ | PROT_WRITE,
                      MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) throw std::bad_alloc();
    return at;
  }
  TwoRings* const rings_;
  std::uint64_t number_ = 0;
  Packet packet_{};
  Answering server_;
};

class SocketPair final : public PingPong {
 public:
  explicit SocketPair(Cores cores) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) throw std::runtime_error("socketpair");
    end_ = ends[0];
    server_ = std::make_unique<Answering>(cores, [&] {
      Packet packet;
      while (::recv(ends[1], packet.data(), packet.size(), MSG_WAITALL) > 0) {
        if (::send(ends[1], packet.data(), packet.size(), 0) < 0) return;
      }
    });
    ::close(ends[1]);
  }
  ~SocketPair() override { ::close(end_); }
  void call() override {
    if (::send(end_, packet_.data(), packet_.size(), 0) < 0 ||
        ::recv(end_, packet_.data(), packet_.size(), MSG_WAITALL) <= 0) {
      throw std::runtime_error("raw socket: the other process has gone");
    }
  }

 private:
  int end_ = -1;
  Packet packet_{};
  std::unique_ptr<Answering> server_;
};

class LcmPair final : public PingPong {
 public:
  explicit LcmPair(Cores cores)
      : server_(cores, [this] {
          lcm_t* const lcm = ::lcm_create(provider);
          ::lcm_subscribe(lcm, "PING", [](const lcm_recv_buf_t* got, const char*, void*) {
            ::lcm_publish(got->lcm, "PONG", got->data, got->data_size);
          }, nullptr);
          while (::lcm_handle(lcm) == 0) {
          }
        }),
        lcm_(::lcm_create(provider)) {
    ::lcm_subscribe(lcm_, "PONG", [](const lcm_recv_buf_t*, const char*, void* self) {
      ++static_cast<LcmPair*>(self)->answers_;
    }, this);
    // The other process may not listen yet: ask until it has answered, then wait for silence.
    do {
      ::lcm_publish(lcm_, "PING", packet_.data(), static_cast<unsigned>(packet_.size()));
    } while (::lcm_handle_timeout(lcm_, 20) <= 0 || answers_ == 0);
    while (::lcm_handle_timeout(lcm_, 50) > 0) {
    }
  }
  ~LcmPair() override { ::lcm_destroy(lcm_); }
  void call() override {
    const std::uint64_t before = answers_;
    ::lcm_publish(lcm_, "PING", packet_.data(), static_cast<unsigned>(packet_.size()));
    while (answers_ == before) {
      if (::lcm_handle_timeout(lcm_, 1000) <= 0) throw std::runtime_error("raw LCM: an answer was lost");
    }
  }

 private:
  static constexpr const char* provider = "udpm://239.255.76.67:19999?ttl=0";
  Answering server_;
  lcm_t* const lcm_;
  std::uint64_t answers_ = 0;
  Packet packet_{};
};

double at_quantile(std::vector<double>& sorted, double quantile) {
  std::ranges::sort(sorted);
  return sorted[static_cast<std::size_t>(static_cast<double>(sorted.size() - 1) * quantile)];
}

}  // namespace

std::unique_ptr<PingPong> raw_spinning_ring(Cores cores) {
  return std::make_unique<RingPair<[] {}>>(cores);
}
std::unique_ptr<PingPong> raw_yielding_ring(Cores cores) {
  return std::make_unique<RingPair<[] { ::sched_yield(); }>>(cores);
}
std::unique_ptr<PingPong> raw_unix_socket(Cores cores) { return std::make_unique<SocketPair>(cores); }
std::unique_ptr<PingPong> raw_lcm(Cores cores) { return std::make_unique<LcmPair>(cores); }

void pin_client() { pin(0); }
void pin_server(Cores cores) { pin(cores == Cores::Two ? 1 : 0); }

Answering::Answering(Cores cores, const std::function<void()>& serve) : pid_(::fork()) {
  if (pid_ != 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  pin_server(cores);
  serve();
  ::_exit(0);
}

Answering::~Answering() {
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

BusyNeighbours::BusyNeighbours() {
  for (const Cores cores : {Cores::One, Cores::Two}) {
    loops_.push_back(std::make_unique<Answering>(cores, [] {
      std::atomic<unsigned> turns{0};
      for (;;) turns.fetch_add(1, std::memory_order_relaxed);
    }));
  }
}

std::vector<Result> paired_rounds(const std::vector<Candidate>& candidates, int rounds, int calls) {
  struct Measured {
    std::vector<double> p50s;
    std::vector<double> p99s;
    std::vector<double> ratios;
  };
  std::vector<Measured> measured(candidates.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const auto pair = candidates[i].start();
      for (int call = 0; call < calls / 10 + 10; ++call) pair->call();  // warm
      std::vector<double> times;
      times.reserve(static_cast<std::size_t>(calls));
      for (int call = 0; call < calls; ++call) {
        const auto before = std::chrono::steady_clock::now();
        pair->call();
        times.push_back(
            std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - before)
                .count());
      }
      measured[i].p50s.push_back(at_quantile(times, 0.5));
      measured[i].p99s.push_back(at_quantile(times, 0.99));
      measured[i].ratios.push_back(measured[i].p50s.back() / measured[0].p50s.back());
    }
  }
  std::vector<Result> results;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    results.push_back({candidates[i].name, at_quantile(measured[i].p50s, 0.5),
                       at_quantile(measured[i].p99s, 0.5), at_quantile(measured[i].ratios, 0.5)});
  }
  return results;
}

void print_table(const std::string& title, const std::vector<Result>& results) {
  std::printf("\n| %s | p50 µs | p99 µs | × %s |\n|---|--:|--:|--:|\n", title.c_str(),
              results.front().name.c_str());
  for (const Result& result : results) {
    std::printf("| %s | %.2f | %.2f | %.2f |\n", result.name.c_str(), result.p50_us, result.p99_us,
                result.ratio);
  }
  std::fflush(stdout);
}

}  // namespace gecos::benchmarks
