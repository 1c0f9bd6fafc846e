// Round trips over a plain ring, a socket and LCM, without this project:
//   spin     ring in shared memory that never gives its core away
//   yield    the same, giving it away after every look, and asleep on a futex after 50 µs of that
//   futex    the same, asleep on a futex at once
//   socket   Unix stream socket, blocking
//   lcm      LCM with a handler on each side
//   images-copy  no other process: an image is written, copied and read. "Sending" is the copy.

#include <fcntl.h>
#include <lcm/lcm.h>
#include <linux/futex.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <climits>
#include <cstring>
#include <deque>
#include <new>
#include <stdexcept>

#include "benchmarks/raw_ring.hpp"
#include "images.hpp"
#include "speaker.hpp"

namespace peers {
namespace {

using namespace std::chrono_literals;

enum class Waiting { Spin, Yield, Futex };

/// A ring whose reader can sleep.
class WakingRing {
 public:
  void put(std::uint64_t number, const Sample& sample) {
    ring_.put(number, sample);
    // seq_cst, as in `sleep`: who sleeps has looked after this write, or is seen here.
    if (asleep_.exchange(0) != 0)
      ::syscall(SYS_futex, &asleep_, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
  }

  Sample get(std::uint64_t number, Waiting waiting) {
    Sample sample;
    if (waiting == Waiting::Spin) {
      ring_.get(number, sample, [] {});
    } else if (waiting == Waiting::Futex) {
      ring_.get(number, sample, [&] { sleep(number); });
    } else {
      Clock::time_point begin{};
      ring_.get(number, sample, [&] {
        if (begin == Clock::time_point()) begin = Clock::now();
        if (Clock::now() - begin < 50us) {
          ::sched_yield();
        } else {
          sleep(number);
        }
      });
    }
    return sample;
  }
  /// For a reader that spins: no system call, no look at who sleeps.
  void put_unwatched(std::uint64_t number, const Sample& sample) { ring_.put(number, sample); }

 private:
  void sleep(std::uint64_t number) {
    asleep_.exchange(1);
    if (!ring_.holds(number)) ::syscall(SYS_futex, &asleep_, FUTEX_WAIT, 1, nullptr, nullptr, 0);
  }

  gecos::benchmarks::RawRing<Sample> ring_;
  alignas(64) std::atomic<std::uint32_t> asleep_{
      0};  ///< tells the writer that the reader wants a wake-up
};

struct TwoRings {
  WakingRing there;
  WakingRing back;
};

TwoRings* map(int file) {
  void* const at = ::mmap(nullptr, sizeof(TwoRings), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (at == MAP_FAILED) throw std::runtime_error("cannot map the rings");
  return static_cast<TwoRings*>(at);
}

void put(WakingRing& ring, std::uint64_t number, const Sample& sample, Waiting waiting) {
  waiting == Waiting::Spin ? ring.put_unwatched(number, sample) : ring.put(number, sample);
}

[[noreturn]] void serve_rings(Waiting waiting) {
  const int file = ::memfd_create("rings", MFD_CLOEXEC);
  if (file < 0 || ::ftruncate(file, sizeof(TwoRings)) != 0)
    throw std::runtime_error("cannot make the rings");
  TwoRings& rings = *new (map(file)) TwoRings;
  say_ready("/proc/" + std::to_string(::getpid()) + "/fd/" + std::to_string(file));
  for (std::uint64_t i = 1;; ++i) put(rings.back, i, rings.there.get(i, waiting), waiting);
}

class RingClient final : public PipeliningClient {
 public:
  RingClient(const std::string& address, Waiting waiting) : waiting_(waiting) {
    const int file = ::open(address.c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0) throw std::runtime_error("cannot open the rings at " + address);
    rings_ = map(file);
    ::close(file);
  }
  Sample call(const Sample& sample) override {
    issue(sample);
    return collect();
  }

 protected:
  void issue(const Sample& sample) override { put(rings_->there, ++issued_, sample, waiting_); }
  Sample collect() override { return rings_->back.get(++collected_, waiting_); }

 private:
  const Waiting waiting_;
  TwoRings* rings_ = nullptr;
  std::uint64_t issued_ = 0;
  std::uint64_t collected_ = 0;
};

// Socket

/// The socket has an abstract name outside the file system, which disappears with its server.
std::pair<sockaddr_un, socklen_t> abstract(const std::string& name) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  name.copy(address.sun_path + 1, sizeof address.sun_path - 1);
  return {address, static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size())};
}

void serve_socket() {
  const std::string name = "bench-peers-" + std::to_string(::getpid());
  const auto [address, size] = abstract(name);
  const int listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::bind(listener, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      ::listen(listener, 1) != 0) {
    throw std::runtime_error("cannot listen on a Unix socket");
  }
  say_ready(name);
  const int end = ::accept(listener, nullptr, nullptr);
  Sample sample;
  while (::recv(end, &sample, sizeof sample, MSG_WAITALL) > 0) {
    if (::send(end, &sample, sizeof sample, MSG_NOSIGNAL) < 0) return;
  }
}

class SocketClient final : public PipeliningClient {
 public:
  explicit SocketClient(const std::string& name)
      : end_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const auto [address, size] = abstract(name);
    if (::connect(end_, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
      throw std::runtime_error("cannot connect to " + name);
    }
  }
  ~SocketClient() override { ::close(end_); }
  Sample call(const Sample& sample) override {
    issue(sample);
    return collect();
  }

 protected:
  void issue(const Sample& sample) override {
    if (::send(end_, &sample, sizeof sample, MSG_NOSIGNAL) < 0)
      throw std::runtime_error("the server has gone");
  }
  Sample collect() override {
    Sample sample;
    if (::recv(end_, &sample, sizeof sample, MSG_WAITALL) <= 0)
      throw std::runtime_error("the server has gone");
    return sample;
  }

 private:
  int end_;
};

// LCM

lcm_t* open_lcm() {
  lcm_t* const lcm = ::lcm_create("udpm://239.255.76.67:19998?ttl=0");
  if (lcm == nullptr) throw std::runtime_error("lcm_create: is there a route for multicast?");
  return lcm;
}

void serve_lcm() {
  lcm_t* const lcm = open_lcm();
  auto* const asked = ::lcm_subscribe(
      lcm, "THERE",
      [](const lcm_recv_buf_t* got, const char*, void*) {
        ::lcm_publish(got->lcm, "BACK", got->data, got->data_size);
      },
      nullptr);
  ::lcm_subscription_set_queue_capacity(asked, 0);  // its default of 30 drops without a word
  say_ready("");
  while (::lcm_handle(lcm) == 0) {
  }
}

class LcmClient final : public PipeliningClient {
 public:
  LcmClient() : lcm_(open_lcm()) {
    auto* const answers = ::lcm_subscribe(
        lcm_, "BACK",
        [](const lcm_recv_buf_t* got, const char*, void* self) {
          Sample sample;
          if (got->data_size == sizeof sample) {
            std::memcpy(&sample, got->data, sizeof sample);
            static_cast<LcmClient*>(self)->answers_.push_back(sample);
          }
        },
        this);
    ::lcm_subscription_set_queue_capacity(answers, 0);
  }
  ~LcmClient() override { ::lcm_destroy(lcm_); }
  Sample call(const Sample& sample) override {
    issue(sample);
    return collect();
  }

 protected:
  void issue(const Sample& sample) override {
    if (::lcm_publish(lcm_, "THERE", &sample, sizeof sample) != 0)
      throw std::runtime_error("lcm_publish");
  }
  Sample collect() override {
    while (answers_.empty()) {
      if (::lcm_handle_timeout(lcm_, 2000) <= 0) throw std::runtime_error("an answer was lost");
    }
    const Sample sample = answers_.front();
    answers_.pop_front();
    return sample;
  }

 private:
  lcm_t* const lcm_;
  std::deque<Sample> answers_;
};

Waiting waiting_named(const std::string& how) {
  if (how == "spin") return Waiting::Spin;
  if (how == "yield") return Waiting::Yield;
  if (how == "futex") return Waiting::Futex;
  throw std::invalid_argument("\"" + how + "\" is none of spin, yield, futex, socket, lcm");
}

void serve(const std::string& how) {
  if (how == "socket") return serve_socket();
  if (how == "lcm") return serve_lcm();
  serve_rings(waiting_named(how));
}

std::unique_ptr<Client> connect(const std::string& how, const std::string& address) {
  if (how == "socket") return std::make_unique<SocketClient>(address);
  if (how == "lcm") return std::make_unique<LcmClient>();
  return std::make_unique<RingClient>(address, waiting_named(how));
}

// Images

class CopiedImages final : public images::Reader {
  const std::uint8_t* next() override {
    camera_.begin();
    camera_.write_and_send(written_.data(), [&] { read_ = written_; });
    return read_.data();
  }

  images::Camera camera_;
  std::vector<std::uint8_t> written_ = std::vector<std::uint8_t>(images::size);
  std::vector<std::uint8_t> read_ = written_;
};

void serve_nothing(const std::string&) {
  say_ready("");
  for (;;) ::pause();
}

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  if (peers::images::wanted(argc, argv)) {
    return peers::images::speak(argc, argv, peers::serve_nothing,
                                [](const std::string&, const std::string&) {
                                  return std::make_unique<peers::CopiedImages>();
                                });
  }
  return peers::speak(argc, argv, peers::serve, peers::connect);
}
