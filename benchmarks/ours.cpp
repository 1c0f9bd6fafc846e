#include "benchmarks/ours.hpp"

#include <unistd.h>

#include <array>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"
#include "gecos/media/kinds.hpp"
#include "gecos/media/waiting.hpp"
#include "robcl/laser_distance_sensor_client.hpp"
#include "robcl/laser_distance_sensor_server.hpp"

namespace gecos::benchmarks {
namespace {

using media::Connection;

/// A pipe between this process and another, small enough pieces at a time that it never fills.
class Pipe {
 public:
  Pipe() {
    if (::pipe(ends_.data()) != 0) throw std::runtime_error("pipe");
  }
  ~Pipe() {
    ::close(ends_[0]);
    ::close(ends_[1]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int reading_end() const { return ends_[0]; }
  int writing_end() const { return ends_[1]; }
  void will_only_read() {
    ::close(ends_[1]);
    ends_[1] = -1;
  }
  void write_all(const void* from, std::size_t size) const {
    if (::write(ends_[1], from, size) != static_cast<ssize_t>(size)) {
      throw std::runtime_error("a pipe of the benchmark broke");
    }
  }
  void read_all(void* into, std::size_t size, const char* what) const {
    auto* at = static_cast<char*>(into);
    while (size > 0) {
      const ssize_t got = ::read(ends_[0], at, size);
      if (got <= 0) throw std::runtime_error(std::string(what) + " of the benchmark ended");
      at += got;
      size -= static_cast<std::size_t>(got);
    }
  }

 private:
  std::array<int, 2> ends_{};
};

// Packets

/// Waits as a session does: spins by policy, then sleeps. Nothing once the connection is lost.
std::optional<ByteView> await_packet(Connection& connection, media::SpinPolicy& spin,
                                     media::Acceptor* acceptor) {
  spin.begin();
  for (;;) {
    if (const auto packet = connection.receive()) return packet;
    if (spin.again([&] { return media::place_of(connection.peer_whereabouts()); })) continue;
    if (connection.prepare_to_sleep()) {
      std::vector<int> all(connection.descriptors().begin(), connection.descriptors().end());
      if (acceptor != nullptr) {
        all.insert(all.end(), acceptor->descriptors().begin(), acceptor->descriptors().end());
      }
      media::sleep_on(all, TimePoint::max());
      spin.woke(connection.peer_whereabouts().rang_at, media::Woken::ByAnswer);
      connection.woke();
    }
    if (connection.loss() != media::Loss::None) return std::nullopt;
    spin.begin();
  }
}

class Packets final : public PingPong {
 public:
  Packets(media::Kind kind, Cores cores) : server_([=, this] { serve(kind, cores); }) {
    address_.will_only_read();
    std::array<char, 256> address{};
    address_.read_all(address.data(), address.size(), "the server");
    medium_ = media::open(kind).value();
    connection_ = medium_->connect(address.data()).value();
  }

  void call() override {
    if (!connection_->send(ByteView(packet_).first(48), ByteView(packet_).subspan(48)) ||
        !await_packet(*connection_, spin_, nullptr)) {
      throw std::runtime_error("packets: " + connection_->loss_text());
    }
  }

 private:
  void serve(media::Kind kind, Cores cores) const {
    pin_server(cores);
    const auto medium = media::open(kind).value();
    const auto acceptor = medium->listen("BENCHMARK", false).value();
    std::array<char, 256> address{};
    acceptor->address().copy(address.data(), address.size() - 1);
    address_.write_all(address.data(), address.size());
    std::unique_ptr<Connection> connection;
    while ((connection = acceptor->accept()) == nullptr) {
      media::sleep_on(acceptor->descriptors(), TimePoint::max());
    }
    media::SpinPolicy spin(clock_);
    for (;;) {
      const auto packet = await_packet(*connection, spin, acceptor.get());
      if (!packet || !connection->send(*packet, {})) return;
    }
  }

  const SystemClock clock_;
  media::SpinPolicy spin_{clock_};
  std::array<std::byte, 64> packet_{};
  Pipe address_;
  OtherProcess server_;
  std::unique_ptr<media::Medium> medium_;
  std::unique_ptr<Connection> connection_;
};

// Calls

class Sensor final : public robcl::LaserDistanceSensorServant {
  Result<robcl::Distance> measure() override {
    return robcl::Distance{.value = 0.5, .valid = true, .lower = 0.05, .upper = 2.0, .stamp = 1.0};
  }
  Result<robcl::Distance> beam() override { return measure(); }
  Result<void> power(bool) override { return {}; }
  Result<robcl::Frame> base() override { return robcl::Frame(); }
  Result<std::string> parent() override { return std::string(); }
  Result<void> mount(const std::string&, const robcl::Frame&) override { return {}; }
};

/// This program run again as server: a process that has neither threads nor state of this one.
class SensorServer {
 public:
  SensorServer(media::Kind kind, Cores cores) : process_([=, this] { become(kind, cores); }) {
    ready_.will_only_read();
    char said = 0;
    ready_.read_all(&said, 1, "the server");
  }

 private:
  void become(media::Kind kind, Cores cores) const {
    pin_server(cores);
    const std::string medium(media::to_string(kind));
    const std::string ready = std::to_string(ready_.writing_end());
    ::execl("/proc/self/exe", "call_benchmark", "serve", medium.c_str(), ready.c_str(), nullptr);
  }

  Pipe ready_;
  OtherProcess process_;
};

class SensorCall final : public PingPong {
 public:
  SensorCall(media::Kind kind, Cores cores) : server_(kind, cores) {
    auto created = lab_.create<robcl::LaserDistanceSensor>("LASER", {.medium = kind});
    if (!created) throw std::runtime_error(created.error().to_string());
    laser_ = *created;
  }
  void call() override {
    const auto distance = laser_.measure().get();
    if (!distance) throw std::runtime_error("measure: " + distance.error().text);
  }

 private:
  SensorServer server_;
  Lab lab_;
  robcl::LaserDistanceSensor laser_;
};

class PythonSensorCall final : public Pair {
 public:
  PythonSensorCall(media::Kind kind, Cores cores)
      : server_(kind, cores), client_([=, this] { become_client(kind); }) {
    answers_.will_only_read();
  }

  std::vector<Microseconds> round_trips(Microseconds how_long) override {
    const double seconds = how_long.count() * 1e-6;
    questions_.write_all(&seconds, sizeof seconds);
    std::uint64_t count = 0;
    answers_.read_all(&count, sizeof count, "the Python client");
    std::vector<double> times(count);
    answers_.read_all(times.data(), count * sizeof(double), "the Python client");
    std::vector<Microseconds> trips;
    for (const double time : times) trips.emplace_back(time);
    return trips;
  }

 private:
  void become_client(media::Kind kind) const {
    ::dup2(questions_.reading_end(), STDIN_FILENO);
    ::dup2(answers_.writing_end(), STDOUT_FILENO);
    const std::string medium(media::to_string(kind));
    constexpr const char* python = GECOS_BENCHMARK_PYTHON;  // finds its packages by this name
    ::execl(python, python, GECOS_BENCHMARK_CLIENT, medium.c_str(), nullptr);
  }

  SensorServer server_;
  Pipe questions_;
  Pipe answers_;
  OtherProcess client_;
};

}  // namespace

std::unique_ptr<Pair> packets(media::Kind kind, Cores cores) {
  return std::make_unique<Packets>(kind, cores);
}
std::unique_ptr<Pair> sensor_call(media::Kind kind, Cores cores) {
  return std::make_unique<SensorCall>(kind, cores);
}
std::unique_ptr<Pair> sensor_call_from_python(media::Kind kind, Cores cores) {
  return std::make_unique<PythonSensorCall>(kind, cores);
}

int serve_sensor(media::Kind kind, int ready) {
  Lab lab;
  Server server(lab);
  broker::Broker broker;
  Sensor sensor;
  auto served = broker.serve(server, {media::Kind::Shm});
  if (served) served = server.add("LASER", sensor, {.simulated = true, .media = {kind}});
  if (!served) {
    std::fprintf(stderr, "%s\n", served.error().text.c_str());
    return 1;
  }
  if (::write(ready, "1", 1) < 0) return 1;
  server.run();
  return 0;
}

}  // namespace gecos::benchmarks
