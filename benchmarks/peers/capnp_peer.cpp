// Cap'n Proto RPC over a Unix socket. HOW is unix, or images over it; the address is the socket's.

#include <capnp/ez-rpc.h>
#include <unistd.h>

#include <deque>
#include <stdexcept>

#include "exchange.capnp.h"
#include "images.hpp"
#include "speaker.hpp"

namespace peers {
namespace {

class Echo final : public Exchange::Server {
  kj::Promise<void> echo(EchoContext context) override {
    context.getResults().setAnswer(context.getParams().getGiven());
    return kj::READY_NOW;
  }
};

class Images final : public Camera::Server {
  kj::Promise<void> next(NextContext context) override {
    camera_.begin();
    auto results = context.getResults(capnp::MessageSize{images::size / 8 + 8, 0});
    camera_.write(results.initImage(images::size).begin());
    return kj::READY_NOW;
  }

  images::Camera camera_;
};

template <class Servant>
void serve_object() {
  const std::string address = "unix-abstract:bench-peers-capnp-" + std::to_string(::getpid());
  capnp::EzRpcServer server(kj::heap<Servant>(), address);
  say_ready(address);
  kj::NEVER_DONE.wait(server.getWaitScope());
}

void serve(const std::string&) { serve_object<Echo>(); }

void serve_images(const std::string&) { serve_object<Images>(); }

class CapnpClient final : public PipeliningClient {
 public:
  explicit CapnpClient(const std::string& address)
      : connection_(std::make_unique<Connection>(address)) {}

  Sample call(const Sample& sample) override {
    issue(sample);
    return collect();
  }

 protected:
  void issue(const Sample& sample) override {
    auto request = connection_->object.echoRequest();
    auto given = request.initGiven();
    given.setStamp(sample.stamp);
    given.setA(sample.axis[0]);
    given.setB(sample.axis[1]);
    given.setC(sample.axis[2]);
    given.setD(sample.axis[3]);
    given.setE(sample.axis[4]);
    given.setF(sample.axis[5]);
    given.setG(sample.axis[6]);
    connection_->issued.push_back(request.send());
  }
  Sample collect() override {
    auto& [rpc, object, issued] = *connection_;
    const auto response = issued.front().wait(rpc.getWaitScope());
    issued.pop_front();
    const auto answer = response.getAnswer();
    return {answer.getStamp(),
            {answer.getA(), answer.getB(), answer.getC(), answer.getD(), answer.getE(),
             answer.getF(), answer.getG()}};
  }

 private:
  /// Apart, since its destructors may throw and ours may not.
  struct Connection {
    explicit Connection(const std::string& address)
        : rpc(address), object(rpc.getMain<Exchange>()) {}
    capnp::EzRpcClient rpc;
    Exchange::Client object;
    std::deque<capnp::RemotePromise<Exchange::EchoResults>> issued;
  };
  std::unique_ptr<Connection> connection_;
};

class ImageReader final : public images::Reader {
 public:
  explicit ImageReader(const std::string& address)
      : connection_(std::make_unique<Connection>(address)) {}
  const std::uint8_t* next() override {
    auto& [rpc, object, response] = *connection_;
    response = nullptr;
    response = object.nextRequest().send().wait(rpc.getWaitScope());
    return KJ_ASSERT_NONNULL(response).getImage().begin();
  }

 private:
  /// Apart, as that of calls.
  struct Connection {
    explicit Connection(const std::string& address) : rpc(address), object(rpc.getMain<Camera>()) {}
    capnp::EzRpcClient rpc;
    Camera::Client object;
    kj::Maybe<capnp::Response<Camera::NextResults>> response;
  };
  std::unique_ptr<Connection> connection_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  if (peers::images::wanted(argc, argv)) {
    return peers::images::speak(argc, argv, peers::serve_images,
                                [](const std::string&, const std::string& address) {
                                  return std::make_unique<peers::ImageReader>(address);
                                });
  }
  return peers::speak(argc, argv, peers::serve, [](const std::string&, const std::string& address) {
    return std::make_unique<peers::CapnpClient>(address);
  });
}
