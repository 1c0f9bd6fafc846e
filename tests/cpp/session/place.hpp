// Where a test with processes of its own takes place, and the broker that its process is.
#pragma once

#include <cstdlib>
#include <stdexcept>

#include "../media/scratch_directory.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"

namespace probe {

/// A directory of this test's own, so that its broker is nobody else's.
class Place {
 public:
  Place() { setenv("GECOS_RUNTIME_DIR", directory_.path().c_str(), 1); }

 private:
  const gecos::media::ScratchDirectory directory_;
};

/// Made after the test's children, for it has threads.
struct BrokerHere {
  BrokerHere() {
    const auto served = broker.serve(server, {gecos::media::Kind::Inproc, gecos::media::Kind::Shm});
    if (!served) throw std::runtime_error(served.error().text);
  }
  gecos::Lab lab;
  gecos::broker::Broker broker;
  gecos::Server server{lab};
};

}  // namespace probe
