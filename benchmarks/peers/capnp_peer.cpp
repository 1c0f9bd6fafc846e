// Cap'n Proto RPC over a Unix socket. HOW is unix; the address is the socket's.

#include <capnp/ez-rpc.h>
#include <unistd.h>

#include <deque>
#include <stdexcept>

#include "exchange.capnp.h"
#include "speaker.hpp"

namespace peers {
namespace {

class Echo final : public Exchange::Server {
  kj::Promise<void> echo(EchoContext context) override {
    context.getResults().setAnswer(context.getParams().getGiven());
    return kj::READY_NOW;
  }
};

void serve(const std::string&) {
  const std::string address = "unix-abstract:bench-peers-capnp-" + std::to_string(::getpid());
  capnp::EzRpcServer server(kj::heap<Echo>(), address);
  say_ready(address);
  kj::NEVER_DONE.wait(server.getWaitScope());
}

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

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::speak(argc, argv, peers::serve, [](const std::string&, const std::string& address) {
    return std::make_unique<peers::CapnpClient>(address);
  });
}
