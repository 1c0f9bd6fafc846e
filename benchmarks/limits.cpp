#include "benchmarks/limits.hpp"

#include <lcm/lcm.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <new>
#include <stdexcept>

#include "benchmarks/raw_ring.hpp"

namespace gecos::benchmarks {
namespace {

using Packet = std::array<char, 64>;

struct TwoRings {
  RawRing<Packet> there;
  RawRing<Packet> back;
};

template <auto wait>
class RingPair final : public PingPong {
 public:
  explicit RingPair(Cores cores)
      : rings_(new (map()) TwoRings), server_([this, cores] {
          pin_server(cores);
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
    void* at = ::mmap(nullptr, sizeof(TwoRings), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS,
                      -1, 0);
    if (at == MAP_FAILED) throw std::bad_alloc();
    return at;
  }
  TwoRings* const rings_;
  std::uint64_t number_ = 0;
  Packet packet_{};
  OtherProcess server_;
};

class SocketPair final : public PingPong {
 public:
  explicit SocketPair(Cores cores) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0)
      throw std::runtime_error("socketpair");
    end_ = ends[0];
    server_ = std::make_unique<OtherProcess>([&] {
      pin_server(cores);
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
  std::unique_ptr<OtherProcess> server_;
};

class LcmPair final : public PingPong {
 public:
  explicit LcmPair(Cores cores)
      : server_([cores] {
          pin_server(cores);
          lcm_t* const lcm = ::lcm_create(provider);
          ::lcm_subscribe(
              lcm, "PING",
              [](const lcm_recv_buf_t* got, const char*, void*) {
                ::lcm_publish(got->lcm, "PONG", got->data, got->data_size);
              },
              nullptr);
          while (::lcm_handle(lcm) == 0) {
          }
        }),
        lcm_(::lcm_create(provider)) {
    ::lcm_subscribe(
        lcm_, "PONG",
        [](const lcm_recv_buf_t*, const char*, void* self) {
          ++static_cast<LcmPair*>(self)->answers_;
        },
        this);
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
      if (::lcm_handle_timeout(lcm_, 1000) <= 0)
        throw std::runtime_error("raw LCM: an answer was lost");
    }
  }

 private:
  static constexpr const char* provider = "udpm://239.255.76.67:19999?ttl=0";
  OtherProcess server_;
  lcm_t* const lcm_;
  std::uint64_t answers_ = 0;
  Packet packet_{};
};

}  // namespace

std::unique_ptr<Pair> raw_spinning_ring(Cores cores) {
  return std::make_unique<RingPair<[] {}>>(cores);
}
std::unique_ptr<Pair> raw_yielding_ring(Cores cores) {
  return std::make_unique<RingPair<[] { ::sched_yield(); }>>(cores);
}
std::unique_ptr<Pair> raw_unix_socket(Cores cores) { return std::make_unique<SocketPair>(cores); }
std::unique_ptr<Pair> raw_lcm(Cores cores) { return std::make_unique<LcmPair>(cores); }

}  // namespace gecos::benchmarks
