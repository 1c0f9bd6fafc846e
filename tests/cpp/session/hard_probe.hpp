#pragma once

#include <memory>

#include "probe.hpp"

namespace probe {

/// A Probe whose interface demands HARD_REALTIME.
class HardProbe : public Probe {
 public:
  static const gecos::InterfaceDescription& gecos_description() {
    static const gecos::InterfaceDescription described = [] {
      gecos::InterfaceDescription demanding = description();
      demanding.quality.line = gecos::qos::Class::HardRealtime;
      return demanding;
    }();
    return described;
  }
  HardProbe() = default;
  explicit HardProbe(std::shared_ptr<gecos::session::ClientSession> session)
      : gecos::Object(session), Probe(session) {}
};

}  // namespace probe
