// iceoryx as Debian has it, request/response. HOW: poll (asks again and again) or wait (its
// WaitSet); or publish/subscribe: topics, polled, there and back; images-poll, images-wait. Its
// daemon, RouDi, is the server's parent, so that it can end it and then itself. A host has one: run
// no other meanwhile.

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <deque>
#include <optional>
#include <stdexcept>
#include <thread>

#include "iceoryx_posh/iceoryx_posh_config.hpp"
#include "iceoryx_posh/popo/client.hpp"
#include "iceoryx_posh/popo/publisher.hpp"
#include "iceoryx_posh/popo/server.hpp"
#include "iceoryx_posh/popo/subscriber.hpp"
#include "iceoryx_posh/popo/wait_set.hpp"
#include "iceoryx_posh/roudi/iceoryx_roudi_app.hpp"
#include "iceoryx_posh/roudi/roudi_cmd_line_parser.hpp"
#include "iceoryx_posh/runtime/posh_runtime.hpp"
#include "images.hpp"
#include "speaker.hpp"

namespace peers {
namespace {

using namespace iox;
const capro::ServiceDescription service{"bench-peers", "Exchange", "echo"};

struct Image {
  Image() {}  // by intention, initializes nothing: loan() constructs what it lends
  std::array<std::uint8_t, images::size> octets;
};
const capro::ServiceDescription camera_service{"bench-peers", "Camera", "image"};
constexpr std::size_t queue = 1;  ///< of images, at each reader: the newest one

[[noreturn]] void be_roudi(char* program) {
  ::signal(SIGCHLD, SIG_IGN);  // RouDi ends when its processes have, and a zombie would count
  std::array<char*, 1> arguments{program};
  config::CmdLineParser parser;
  auto parsed = parser.parse(1, arguments.data()).value();
  parsed.logLevel = log::LogLevel::kError;
  RouDiConfig_t config;
  config.setDefaults();
  // For images. Its largest chunks by default are of 4 MiB.
  config.m_sharedMemorySegments.front().m_mempoolConfig.addMemPool({sizeof(Image) + 256, 12});
  std::exit(roudi::IceOryxRouDiApp(parsed, config).run());
}

void start_runtime(const char* what) {
  const std::string name = std::string(what) + std::to_string(::getpid());
  runtime::PoshRuntime::initRuntime(RuntimeName_t(cxx::TruncateToCapacity, name));
}

template <class Port, class State>
class Waiting {
 public:
  Waiting(const std::string& how, Port& port, State state) : blocks_(how == "wait") {
    if (!blocks_ && how != "poll")
      throw std::invalid_argument("\"" + how + "\" is neither poll nor wait");
    if (blocks_ && set_.attachState(port, state).has_error())
      throw std::runtime_error("iceoryx: no room in the wait set");
  }
  void operator()() {
    if (blocks_) set_.wait();
  }

 private:
  const bool blocks_;
  popo::WaitSet<1> set_;
};

void serve(const std::string& how, char* program) {
  if (::fork() != 0) be_roudi(program);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  start_runtime("server");
  popo::ServerOptions options;
  options.requestQueueCapacity = 64;
  popo::Server<Sample, Sample> server(service, options);
  Waiting wait(how, server, popo::ServerState::HAS_REQUEST);
  say_ready("iceoryx");
  for (;;) {
    wait();
    while (server.take().and_then([&](const auto& request) {
      server.loan(request).and_then([&](auto& response) {
        *response = *request;
        response.send().or_else(
            [](auto&) { throw std::runtime_error("iceoryx: a response was not sent"); });
      });
    })) {
    }
  }
}

/// One of its clients has at most 16 answers waiting, so 64 outstanding are spread over four.
class IceoryxClient final : public PipeliningClient {
 public:
  explicit IceoryxClient(const std::string& how) {
    start_runtime("client");
    for (auto& port : ports_) {
      port = std::make_unique<Port>(how);
      while (port->client.getConnectionState() != ConnectionState::CONNECTED)
        std::this_thread::yield();
    }
  }
  Sample call(const Sample& sample) override {
    send(*ports_[0], sample);
    return take(*ports_[0]);
  }

 protected:
  void issue(const Sample& sample) override { send(*ports_[issued_++ % ports_.size()], sample); }
  Sample collect() override { return take(*ports_[collected_++ % ports_.size()]); }

 private:
  using Posh = popo::Client<Sample, Sample>;
  struct Port {
    explicit Port(const std::string& how) : wait(how, client, popo::ClientState::HAS_RESPONSE) {}
    Posh client{service, [] {
                  popo::ClientOptions options;
                  options.responseQueueCapacity = 16;
                  return options;
                }()};
    Waiting<Posh, popo::ClientState> wait;
  };

  static void send(Port& port, const Sample& sample) {
    port.client.loan()
        .and_then([&](auto& request) {
          *request = sample;
          request.send().or_else(
              [](auto&) { throw std::runtime_error("iceoryx: a request was not sent"); });
        })
        .or_else([](auto&) { throw std::runtime_error("iceoryx: no memory for a request"); });
  }
  static Sample take(Port& port) {
    Sample sample;
    while (!port.client.take().and_then([&](const auto& response) { sample = *response; }))
      port.wait();
    return sample;
  }

  std::array<std::unique_ptr<Port>, 4> ports_;
  std::size_t issued_ = 0;
  std::size_t collected_ = 0;
};

// Publish/subscribe

const capro::ServiceDescription there{"bench-peers", "Topics", "there"};
const capro::ServiceDescription back{"bench-peers", "Topics", "back"};

/// One end of a pair of topics: publishes on one of them, and subscribes to the other.
class Topics {
 public:
  Topics(const capro::ServiceDescription& out, const capro::ServiceDescription& in)
      : publisher_(out), subscriber_(in) {
    while (subscriber_.getSubscriptionState() != SubscribeState::SUBSCRIBED)
      std::this_thread::yield();
    while (!publisher_.hasSubscribers()) std::this_thread::yield();
  }
  void send(const Sample& sample) {
    publisher_.publishCopyOf(sample).or_else(
        [](auto&) { throw std::runtime_error("iceoryx: no memory for a sample"); });
  }
  Sample receive() {
    Sample received;
    while (!subscriber_.take().and_then([&](const auto& sample) { received = *sample; })) {
    }
    return received;
  }

 private:
  popo::Publisher<Sample> publisher_;
  popo::Subscriber<Sample> subscriber_;
};

[[noreturn]] void serve_topics(char* program) {
  if (::fork() != 0) be_roudi(program);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  start_runtime("server");
  say_ready("iceoryx");
  for (Topics topics(back, there);;) topics.send(topics.receive());
}

class TopicsClient final : public PipeliningClient {
 public:
  TopicsClient() {
    start_runtime("client");
    topics_.emplace(there, back);
  }
  Sample call(const Sample& sample) override {
    issue(sample);
    return collect();
  }

 protected:
  void issue(const Sample& sample) override { topics_->send(sample); }
  Sample collect() override { return topics_->receive(); }

 private:
  std::optional<Topics> topics_;
};

void serve_images(char* program) {
  if (::fork() != 0) be_roudi(program);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  start_runtime("server");
  popo::PublisherOptions options;
  options.historyCapacity = 1;  // the newest image stays for late readers, as in our stream
  popo::Publisher<Image> publisher(camera_service, options);
  say_ready("iceoryx");
  for (images::Camera camera;;) {
    camera.begin();
    publisher.loan()
        .and_then([&](auto& sample) {
          camera.write_and_send(sample->octets.data(), [&] { sample.publish(); });
        })
        .or_else([](auto&) { throw std::runtime_error("iceoryx: no memory for an image"); });
  }
}

class ImageReader final : public images::Reader {
 public:
  explicit ImageReader(const std::string& how) {
    start_runtime("client");
    port_ = std::make_unique<Port>(how == "images-wait" ? "wait" : "poll");
  }
  const std::uint8_t* next() override {
    image_.reset();
    while (!port_->subscriber.take().and_then([&](auto& sample) { image_ = std::move(sample); }))
      port_->wait();
    return (*image_)->octets.data();
  }

 private:
  using Posh = popo::Subscriber<Image>;
  struct Port {
    explicit Port(const std::string& how)
        : wait(how, subscriber, popo::SubscriberState::HAS_DATA) {}
    Posh subscriber{camera_service, [] {
                      popo::SubscriberOptions options;
                      options.queueCapacity = queue;
                      return options;
                    }()};
    Waiting<Posh, popo::SubscriberState> wait;
  };

  std::unique_ptr<Port> port_;
  std::optional<popo::Sample<const Image>> image_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  if (peers::images::wanted(argc, argv)) {
    return peers::images::speak(
        argc, argv, [&](const std::string&) { peers::serve_images(argv[0]); },
        [](const std::string& how, const std::string&) {
          return std::make_unique<peers::ImageReader>(how);
        });
  }
  return peers::speak(
      argc, argv,
      [&](const std::string& how) {
        if (how == "topics") peers::serve_topics(argv[0]);
        peers::serve(how, argv[0]);
      },
      [](const std::string& how, const std::string&) -> std::unique_ptr<peers::Client> {
        if (how == "topics") return std::make_unique<peers::TopicsClient>();
        return std::make_unique<peers::IceoryxClient>(how);
      });
}
