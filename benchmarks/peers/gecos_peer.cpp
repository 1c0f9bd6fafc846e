// Ours: an operation that moves the device, so with a lease that is checked, the object's queue,
// and a typed reply; waiting as it comes. The broker lives in the server, in GECOS_RUNTIME_DIR.
//   shm, lcm     the medium; over lcm all is encrypted
//   images-poll  images over shm, written and read in place; the client asks for the newest one
//                again and again
//   images-wait  the same; the client waits for the next one
// A client becomes the user that BENCHMARK_USER names, whom a list of the lab file admits to
// EXCHANGE; the audit records the commands. OPEN has no list, so it serves the user of the server
// alone; its readings need no status, and are not recorded.

#include <grp.h>
#include <pwd.h>
#include <unistd.h>

#include <cstdlib>
#include <deque>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "exchange_client.hpp"
#include "exchange_server.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"
#include "images.hpp"
#include "speaker.hpp"

namespace peers {
namespace {

/// Lets the clients of one benchmark share actor status.
constexpr const char* password = "all clients of one benchmark";

/// Makes this process one of `user`.
void become(const std::string& user) {
  const passwd* const entry = ::getpwnam(user.c_str());
  if (entry == nullptr) throw std::runtime_error("this host has no user " + user);
  if (::setgroups(0, nullptr) != 0 || ::setgid(entry->pw_gid) != 0 ||
      ::setuid(entry->pw_uid) != 0) {
    throw std::runtime_error("only root can become " + user +
                             "; run the benchmark as root, or after `unshare --map-root-user "
                             "--map-auto`");
  }
}

gecos::media::Kind medium(const std::string& how) {
  if (const auto kind = gecos::media::kind_from(how)) return *kind;
  throw std::invalid_argument("no medium is called " + how);
}

template <class T, class E>
T must(tl::expected<T, E> result) {
  if (result) return std::move(*result);
  std::ostringstream why;
  why << result.error();
  throw std::runtime_error(why.str());
}

class Echo final : public bench::ExchangeServant {
 public:
  /// A stream has a newest sample once something was published.
  void begin() { publish_pose({}); }

 private:
  gecos::Result<bench::Sample> pose() override { return bench::Sample{}; }
  gecos::Result<bench::Summary> publish(double seconds) override {
    bench::Sample pose;
    const auto took = time_bursts(Seconds(seconds), [&] {
      pose.stamp += 1;
      publish_pose(pose);
    });
    return bench::Summary{.count = took.count, .p50 = took.p50, .p99 = took.p99};
  }
  gecos::Result<bench::Sample> echo(const bench::Sample& given) override { return given; }
  gecos::Result<bench::Sample> echo_unchecked(const bench::Sample& given) override { return given; }
  gecos::Result<bench::Sample> echo_late(const bench::Sample& given, double seconds,
                                         gecos::Execution<>& run) override {
    const auto later = std::chrono::duration_cast<gecos::Duration>(Seconds(seconds));
    if (run.wait_interrupted(later)) return tl::unexpected(gecos::Fault::interrupted());
    return given;
  }
};

void serve(const std::string& how) {
  gecos::broker::Broker broker;
  Echo echo, open;
  gecos::Lab lab;
  gecos::Server server(lab);
  auto served = broker.serve(server, {gecos::media::Kind::Shm});
  const gecos::ObjectOptions options{.simulated = true, .media = {medium(how)}};
  if (served) served = server.add("EXCHANGE", echo, options);
  if (served) served = server.add("OPEN", open, options);
  if (!served) throw std::runtime_error(served.error().text);
  echo.begin();
  say_ready("EXCHANGE");
  server.run();
}

class GecosClient final : public PipeliningClient {
 public:
  GecosClient(const std::string& how, const std::string& name)
      : object_(must(lab_.create<bench::Exchange>(name, {.medium = medium(how)}))),
        how_(how),
        lease_(must(gecos::actor(object_, password))) {}

  Sample call(const Sample& sample) override { return answer(object_.echo(typed(sample))); }
  Sample call_unchecked(const Sample& sample) override {
    if (!open_) open_ = must(lab_.create<bench::Exchange>("OPEN", {.medium = medium(how_)}));
    return answer(open_->echo_unchecked(typed(sample)));
  }
  Sample call_late(const Sample& sample, Seconds late) override {
    return answer(object_.echo_late(typed(sample), late.count()));
  }
  void look() override {
    if (!poses_) {
      poses_ = must(object_.pose(gecos::stream));
      static_cast<void>(must(poses_->next(std::chrono::seconds(10))));
    }
    if (!poses_->latest()) throw std::runtime_error("the stream has no sample");
  }
  Summary publish(Seconds how_long) override {
    const auto took = must(object_.publish(how_long.count()).get());
    return {took.count, took.p50, took.p99};
  }

 protected:
  void issue(const Sample& sample) override { issued_.push_back(object_.echo(typed(sample))); }
  Sample collect() override {
    const Sample sample = answer(issued_.front());
    issued_.pop_front();
    return sample;
  }

 private:
  static bench::Sample typed(const Sample& sample) {
    return {.stamp = sample.stamp, .axis = sample.axis};
  }
  static Sample answer(const gecos::Command<bench::Sample>& command) {
    const auto result = must(command.get());
    return {.stamp = result.stamp, .axis = result.axis};
  }

  gecos::Lab lab_;
  bench::Exchange object_;
  std::string how_;
  std::optional<bench::Exchange> open_;
  gecos::Lease lease_;
  std::optional<gecos::Stream<bench::Sample>> poses_;
  std::deque<gecos::Command<bench::Sample>> issued_;
};

// Images

class LendingCamera final : public bench::CameraServant {
 public:
  [[noreturn]] void publish_for_ever() {
    for (images::Camera camera;;) {
      camera.begin();
      auto loan = lend_picture({}, images::size);
      if (!loan) throw std::runtime_error("no memory for an image");
      camera.write_and_send(loan.octets().data(), [&] {
        if (!loan.publish()) throw std::runtime_error("an image was not sent");
      });
    }
  }

 private:
  gecos::Result<bench::Image> picture() override { return bench::Image{}; }
};

void serve_images(const std::string&) {
  gecos::broker::Broker broker;
  LendingCamera camera;
  gecos::Lab lab;
  gecos::Server server(lab);
  auto served = broker.serve(server, {gecos::media::Kind::Shm});
  const gecos::ObjectOptions options{.simulated = true, .media = {gecos::media::Kind::Shm}};
  if (served) served = server.add("CAMERA", camera, options);
  if (!served) throw std::runtime_error(served.error().text);
  say_ready("CAMERA");
  std::thread([&] { camera.publish_for_ever(); }).detach();
  server.run();
  std::_Exit(0);  // the camera does not end
}

class ImageReader final : public images::Reader {
 public:
  ImageReader(const std::string& how, const std::string& name)
      : waits_(how == "images-wait"),
        object_(must(lab_.create<bench::Camera>(name, {.medium = gecos::media::Kind::Shm}))),
        stream_(must(object_.picture(gecos::stream))) {}

  const std::uint8_t* next() override {
    const std::uint64_t read = sample_ ? sample_->sequence : 0;
    if (waits_) {
      sample_ = must(stream_.next_in_place(std::chrono::seconds(10)));
    } else {
      do {
        sample_ = stream_.latest_in_place();
      } while (!sample_ || sample_->sequence == read);
    }
    return sample_->octets.data();
  }
  bool intact() const override { return sample_->intact(); }

 private:
  const bool waits_;
  gecos::Lab lab_;
  bench::Camera object_;
  gecos::Stream<bench::Image> stream_;
  std::optional<gecos::SampleInPlace<bench::Image>> sample_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  if (peers::images::wanted(argc, argv)) {
    return peers::images::speak(argc, argv, peers::serve_images,
                                [](const std::string& how, const std::string& name) {
                                  return std::make_unique<peers::ImageReader>(how, name);
                                });
  }
  return peers::speak(argc, argv, peers::serve,
                      [](const std::string& how, const std::string& name) {
                        const char* const user = std::getenv("BENCHMARK_USER");
                        if (user != nullptr && *user != '\0') peers::become(user);
                        return std::make_unique<peers::GecosClient>(how, name);
                      });
}
