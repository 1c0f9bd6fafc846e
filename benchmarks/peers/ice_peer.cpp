// ZeroC Ice, its C++11 mapping. HOW is its transport, tcp (it has no Unix sockets), or images over
// tcp; the address is the proxy.

#include <Ice/Ice.h>

#include <algorithm>
#include <deque>
#include <future>

#include "exchange.h"
#include "images.hpp"
#include "speaker.hpp"

namespace peers {
namespace {

class Echo final : public PeersIce::Exchange {
  PeersIce::Sample echo(PeersIce::Sample given, const Ice::Current&) override { return given; }
};

class Images final : public PeersIce::Camera {
  PeersIce::Image next(const Ice::Current&) override {
    camera_.begin();
    PeersIce::Image image(images::size);
    camera_.write(image.data());
    return image;
  }

  images::Camera camera_;
};

Ice::InitializationData settings() {
  Ice::InitializationData settings;
  settings.properties = Ice::createProperties();
  settings.properties->setProperty("Ice.MessageSizeMax", "16384");  // KiB; its default is 1 MiB
  return settings;
}

void serve_object(const std::shared_ptr<Ice::Object>& object, const std::string& transport) {
  const Ice::CommunicatorHolder ice(Ice::initialize(settings()));
  const auto adapter =
      ice->createObjectAdapterWithEndpoints("Exchange", transport + " -h 127.0.0.1");
  const auto proxy = adapter->add(object, Ice::stringToIdentity("exchange"));
  adapter->activate();
  std::string address = proxy->ice_toString();  // "exchange -t -e 1.1:tcp -h …", with spaces
  std::replace(address.begin(), address.end(), ' ', '|');
  say_ready(address);
  ice->waitForShutdown();
}

void serve(const std::string& how) { serve_object(std::make_shared<Echo>(), how); }

void serve_images(const std::string&) { serve_object(std::make_shared<Images>(), "tcp"); }

template <class Proxy>
std::shared_ptr<Proxy> proxy_at(Ice::CommunicatorHolder& ice, std::string address) {
  std::replace(address.begin(), address.end(), '|', ' ');
  return Ice::checkedCast<Proxy>(ice->stringToProxy(address));
}

class IceClient final : public PipeliningClient {
 public:
  explicit IceClient(const std::string& address)
      : object_(proxy_at<PeersIce::ExchangePrx>(ice_, address)) {}
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

class ImageReader final : public images::Reader {
 public:
  explicit ImageReader(const std::string& address)
      : object_(proxy_at<PeersIce::CameraPrx>(ice_, address)) {}
  const std::uint8_t* next() override {
    image_ = object_->next();
    return image_.data();
  }

 private:
  Ice::CommunicatorHolder ice_{Ice::initialize(settings())};
  std::shared_ptr<PeersIce::CameraPrx> object_;
  PeersIce::Image image_;
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
    return std::make_unique<peers::IceClient>(address);
  });
}
