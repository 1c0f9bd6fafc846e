// A servant that sends its events when it is asked to.
#pragma once

#include "bell_server.hpp"

namespace ringing {

class Ringer : public AlarmServant {
 protected:
  gecos::Result<void> press(const std::string& who, double force, std::uint32_t times) override {
    for (std::uint32_t i = 0; i < times; ++i) publish_pressed({who, force});
    return {};
  }
  gecos::Result<void> let(std::uint32_t times) override {
    for (std::uint32_t i = 0; i < times; ++i) publish_let_go({});
    return {};
  }
  gecos::Result<void> silence(std::int32_t zone) override {
    publish_silenced({zone});
    return {};
  }
};

}  // namespace ringing
