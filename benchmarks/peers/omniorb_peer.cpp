// omniORB. HOW is its transport, unix or tcp, or images over unix; the address is the object's IOR.

#include <omniORB4/CORBA.h>

#include <stdexcept>

#include "exchange.hh"
#include "images.hpp"
#include "speaker.hpp"

namespace peers {
namespace {

class Echo : public POA_peers_corba::Exchange {
  peers_corba::Sample echo(const peers_corba::Sample& given) override { return given; }
};

class Images : public POA_peers_corba::Camera {
  peers_corba::Image* next() override {
    camera_.begin();
    peers_corba::Image_var image = new peers_corba::Image(
        images::size, images::size, peers_corba::Image::allocbuf(images::size), true);
    camera_.write(image->get_buffer());
    return image._retn();
  }

  images::Camera camera_;
};

constexpr const char* largest = "16777216";  // of a message; its default is 2 MiB

template <class Servant>
void serve_at(const char* end_point) {
  const char* options[][2] = {
      {"endPoint", end_point}, {"giopMaxMsgSize", largest}, {nullptr, nullptr}};
  int argc = 0;
  CORBA::ORB_var orb = CORBA::ORB_init(argc, nullptr, "omniORB4", options);
  CORBA::Object_var root = orb->resolve_initial_references("RootPOA");
  PortableServer::POA_var poa = PortableServer::POA::_narrow(root);
  PortableServer::Servant_var<Servant> servant = new Servant;
  PortableServer::ObjectId_var id = poa->activate_object(servant);
  auto object = servant->_this();
  PortableServer::POAManager_var manager = poa->the_POAManager();
  manager->activate();
  CORBA::String_var address = orb->object_to_string(object);
  say_ready(address.in());
  orb->run();
}

void serve(const std::string& how) {
  serve_at<Echo>(how == "unix" ? "giop:unix:" : "giop:tcp:127.0.0.1:");
}

void serve_images(const std::string&) { serve_at<Images>("giop:unix:"); }

class OmniClient final : public Client {
 public:
  explicit OmniClient(const std::string& address) {
    const char* options[][2] = {
        {"clientTransportRule", "* unix,tcp"},
        {"maxGIOPConnectionPerServer", "64"},  // its default of 5 holds back 64 threads
        {nullptr, nullptr}};
    int argc = 0;
    orb_ = CORBA::ORB_init(argc, nullptr, "omniORB4", options);
    // 64 threads connect faster than it accepts.
    omniORB::installTransientExceptionHandler(
        nullptr,
        [](void*, CORBA::ULong, const CORBA::TRANSIENT&) -> CORBA::Boolean { return true; });
    CORBA::Object_var object = orb_->string_to_object(address.c_str());
    object_ = peers_corba::Exchange::_narrow(object);
    if (CORBA::is_nil(object_)) throw std::runtime_error("the address is of something else");
  }
  Sample call(const Sample& sample) override {
    peers_corba::Sample given{sample.stamp, {}};
    std::copy(sample.axis.begin(), sample.axis.end(), given.axis);
    const peers_corba::Sample back = object_->echo(given);
    Sample answer{back.stamp, {}};
    std::copy(back.axis, back.axis + answer.axis.size(), answer.axis.begin());
    return answer;
  }
  /// omniORB has no asynchronous invocation of generated operations.
  std::uint64_t calls_until(Clock::time_point end, unsigned outstanding) override {
    return calls_of_threads(end, outstanding, [this] { call({}); });
  }

 private:
  CORBA::ORB_var orb_;
  peers_corba::Exchange_var object_;
};

class ImageReader final : public images::Reader {
 public:
  explicit ImageReader(const std::string& address) {
    const char* options[][2] = {
        {"clientTransportRule", "* unix,tcp"}, {"giopMaxMsgSize", largest}, {nullptr, nullptr}};
    int argc = 0;
    orb_ = CORBA::ORB_init(argc, nullptr, "omniORB4", options);
    CORBA::Object_var object = orb_->string_to_object(address.c_str());
    object_ = peers_corba::Camera::_narrow(object);
    if (CORBA::is_nil(object_)) throw std::runtime_error("the address is of something else");
  }
  const std::uint8_t* next() override {
    image_ = object_->next();
    return image_->get_buffer();
  }

 private:
  CORBA::ORB_var orb_;
  peers_corba::Camera_var object_;
  peers_corba::Image_var image_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  try {
    if (peers::images::wanted(argc, argv)) {
      return peers::images::speak(argc, argv, peers::serve_images,
                                  [](const std::string&, const std::string& address) {
                                    return std::make_unique<peers::ImageReader>(address);
                                  });
    }
    return peers::speak(argc, argv, peers::serve,
                        [](const std::string&, const std::string& address) {
                          return std::make_unique<peers::OmniClient>(address);
                        });
  } catch (const CORBA::Exception& error) {  // knows no std::exception
    std::fprintf(stderr, "omniorb_peer: %s\n", error._name());
    return 1;
  }
}
