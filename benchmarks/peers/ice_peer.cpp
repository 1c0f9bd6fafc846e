// ZeroC Ice, its C++11 mapping. HOW is its transport, tcp (it has no Unix sockets); the address is
// the proxy.

#include <Ice/Ice.h>

#include <algorithm>
#include <deque>
#include <future>

#include "exchange.h"
#include "speaker.hpp"

namespace peers {
namespace {

class Echo final : public PeersIce::Exchange {
  PeersIce::Sample echo(PeersIce::Sample given, const Ice::Current&) override { return given; }
};

void serve(const std::string& how) {
  const Ice::CommunicatorHolder ice(Ice::initialize());
  const auto adapter = ice->createObjectAdapterWithEndpoints("Exchange", how + " -h 127.0.0.1");
  const auto proxy = adapter->add(std::make_shared<Echo>(), Ice::stringToIdentity("exchange"));
  adapter->activate();
  std::string address = proxy->ice_toString();  // "exchange -t -e 1.1:tcp -h …", with spaces
  std::replace(address.begin(), address.end(), ' ', '|');
  say_ready(address);
  ice->waitForShutdown();
}

class IceClient final : public PipeliningClient {
 public:
  explicit IceClient(std::string address) {
    std::replace(address.begin(), address.end(), '|', ' ');
    object_ = Ice::checkedCast<PeersIce::ExchangePrx>(ice_->stringToProxy(address));
  }
  Sample call(const Sample& sample) override { return ours(object_->echo(theirs(sample))); }

 protected:
  void issue(const Sample& sample) override {
    issued_.push_back(object_->echoAsync(theirs(sample)));
  }
  Sample collect() override {
    const Sample sample = ours(issued_.front().get());
    issued_.pop_front();
    return sample;
  }

 private:
  static PeersIce::Sample theirs(const Sample& s) {
    return {s.stamp, s.axis[0], s.axis[1], s.axis[2], s.axis[3], s.axis[4], s.axis[5], s.axis[6]};
  }
  static Sample ours(const PeersIce::Sample& s) {
    return {s.stamp, {s.a, s.b, s.c, s.d, s.e, s.f, s.g}};
  }

  Ice::CommunicatorHolder ice_{Ice::initialize()};
  std::shared_ptr<PeersIce::ExchangePrx> object_;
  std::deque<std::future<PeersIce::Sample>> issued_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::speak(argc, argv, peers::serve, [](const std::string&, const std::string& address) {
    return std::make_unique<peers::IceClient>(address);
  });
}
